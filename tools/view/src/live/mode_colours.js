// The colour of a mode by its number: that of the style sheet.
import { Color } from "three";

const MANY = 12;

export function modeColour(number) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--mode-${(number - 1) % MANY}`).trim();
}

/** The same for the picture. */
export const modePaint = (number) => new Color(modeColour(number));
