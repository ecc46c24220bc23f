// Colours: those of the style sheet, so that picture and page agree, and the ramp of conditions.
import { Color } from "three";

const root = document.documentElement;
const dark = matchMedia("(prefers-color-scheme: dark)");

/** A colour of the style sheet by its name. */
export function colour(name) {
  return new Color(cssColour(name));
}

export function cssColour(name) {
  return getComputedStyle(root).getPropertyValue(`--${name}`).trim();
}

export function setTheme(name) {
  root.dataset.theme = name;
}

export function isDark() {
  const theme = root.dataset.theme;
  return theme === "dark" || (theme === "system" && dark.matches);
}

export function onSystemTheme(callback) {
  dark.addEventListener("change", callback);
}

// Blue for well conditioned to red for badly: it differs in lightness too.
const RAMP = ["#5b9bd8", "#6f79c0", "#95549f", "#b53670", "#c01a3c"].map((hex) => new Color(hex));

function mixed(t) {
  const x = Math.min(Math.max(t, 0), 1) * (RAMP.length - 1);
  const k = Math.min(Math.floor(x), RAMP.length - 2);
  return RAMP[k].clone().lerp(RAMP[k + 1], x - k);
}

export const rampCss = `linear-gradient(90deg, ${RAMP.map((c) => `#${c.getHexString()}`).join(", ")})`;

const LEAST_SPAN = 100;

/** A logarithmic scale of condition numbers from 1; null (infinite) is the worst. */
export function conditionScale(conditions) {
  const finite = conditions.filter((c) => c !== null);
  const high = finite.reduce((a, b) => Math.max(a, b), LEAST_SPAN);
  const at = (c) => (c === null ? 1 : Math.log(c) / Math.log(high));
  return { low: 1, high, colour: (c) => mixed(at(c)) };
}
