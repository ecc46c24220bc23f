// Which mode is which after a move: by proof where there is one, else by nearness.
import { distance } from "./rotations.js";

/** A pose that was followed with proof is found again this near. */
const SAME = 1e-5;
/** A way that is not proved in one step is halved so often at most. */
const HALVINGS = 5;
/** Farther than this (lengths of the scene and radians) no mode has gone in a step. */
const REASON = 0.3;

/**
 * Match modes at `from` to poses at `to`, one to one. `known` has poses at `to` of modes that were
 * followed in between, by number. Returns the modes with their new poses (`isProved`: continued with
 * proof), those that are lost and the poses that are new.
 */
export function carry({ kernel, length }, modes, from, to, poses, known = new Map()) {
  const free = new Set(poses);
  const carried = [];
  const open = [];
  for (const mode of modes) {
    const there = known.get(mode.number) ?? proved(kernel, mode, from, to);
    if (!there) {
      open.push(mode);
      continue;
    }
    const pose = nearest(there, free, length, SAME) ?? there;
    free.delete(pose);
    carried.push({ mode, pose, isProved: true });
  }
  const pairs = open
    .flatMap((mode) => [...free].map((pose) => ({ mode, pose, far: distance(mode, pose, length) })))
    .filter(({ far }) => far < REASON)
    .sort((a, b) => a.far - b.far);
  const lost = new Set(open);
  for (const { mode, pose } of pairs) {
    if (!lost.has(mode) || !free.has(pose)) continue;
    lost.delete(mode);
    free.delete(pose);
    carried.push({ mode, pose, isProved: false });
  }
  return { carried, lost: [...lost], born: [...free] };
}

/** Where a mode is at other values, if every part of the straight way there is proved; else null. */
export function proved(kernel, mode, from, to, halvings = HALVINGS) {
  const { status, R, T } = kernel.follow(mode.R, mode.T, from, to);
  if (status === 0) return { R, T };
  if (halvings === 0) return null;
  const half = from.map((x, i) => (x + to[i]) / 2);
  const there = proved(kernel, mode, from, half, halvings - 1);
  return there && proved(kernel, there, half, to, halvings - 1);
}

/** The nearest of some poses, if it is near enough. */
export function nearest(there, poses, length, limit = Infinity) {
  let best = null;
  let least = limit;
  for (const pose of poses) {
    const far = distance(there, pose, length);
    if (far < least) [best, least] = [pose, far];
  }
  return best;
}

/** All in pairs, the nearest first; who is left alone comes without a partner. */
export function inPairs(poses, length) {
  const left = new Set(poses);
  const all = poses
    .flatMap((a, k) => poses.slice(k + 1).map((b) => ({ a, b, far: distance(a, b, length) })))
    .sort((x, y) => x.far - y.far);
  const pairs = [];
  for (const { a, b } of all) {
    if (!left.has(a) || !left.has(b)) continue;
    left.delete(a);
    left.delete(b);
    pairs.push([a, b]);
  }
  return { pairs, alone: [...left] };
}
