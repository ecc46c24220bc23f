// Colours of modes: nine of the style sheet, and a second cue for further modes.
import { Color } from "three";
import { cssColour } from "../theme.js";

const COLOURS = 9;
/** Of so many there is a sign in the list and a kind of edge in the picture. */
const CUES = 4;
const known = new Map();

export function modeColour(number) {
  const name = `mode-${(number - 1) % COLOURS}`;
  if (!known.has(name)) known.set(name, cssColour(name));
  return known.get(name);
}

/** The same for the picture. */
export const modePaint = (number) => new Color(modeColour(number));

/** The second cue: 0 for the first nine modes, 1 for the next. */
export const cueOf = (number) => Math.floor((number - 1) / COLOURS) % CUES;

/** Read the style sheet again, after another theme. */
export const forgetColours = () => known.clear();
