// The colour of a mode by its number: that of the style sheet.
import { Color } from "three";
import { cssColour } from "../theme.js";

const MANY = 12;
const known = new Map();

export function modeColour(number) {
  const name = `mode-${(number - 1) % MANY}`;
  if (!known.has(name)) known.set(name, cssColour(name));
  return known.get(name);
}

/** The same for the picture. */
export const modePaint = (number) => new Color(modeColour(number));

/** Read the style sheet again, after another theme. */
export const forgetColours = () => known.clear();
