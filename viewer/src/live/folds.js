// Folds: where two modes meet. How near one is, and where on the way two were lost.
import { distance } from "./rotations.js";

/** Halvings of the way on which two modes were lost. */
const HALVINGS = 10;
/** Two modes that were lost had met if they came together to this, or to this part of where they were. */
const MET = 0.08;
const PART = 0.5;
/** A fold is near where the nearest mode is nearer than this, and the condition larger. */
const NEAR = 0.35;
const BAD = 12;

const between = (from, to, t) => from.map((x, i) => x + t * (to[i] - x));

/** Follow two modes with proof as far as both can be; null if they do not come together. */
export function meeting({ kernel, length }, a, b, from, to) {
  let [low, high] = [0, 1];
  let pair = [a, b];
  for (let k = 0; k < HALVINGS; k += 1) {
    const t = (low + high) / 2;
    const there = pair.map(({ R, T }) => kernel.follow(R, T, between(from, to, low), between(from, to, t)));
    if (there.every(({ status }) => status === 0)) [low, pair] = [t, there];
    else high = t;
  }
  const far = distance(...pair, length);
  return far < Math.max(MET, PART * distance(a, b, length)) ? { pair, values: between(from, to, low) } : null;
}

/** The mode that another one approaches in a fold, and how far it is; null if none is near. */
export function approaching(mode, modes, length) {
  if (!(mode.condition > BAD)) return null;
  let best = null;
  for (const other of modes) {
    if (other === mode) continue;
    const far = distance(mode, other, length);
    if (far < (best?.far ?? NEAR)) best = { other, far };
  }
  return best;
}
