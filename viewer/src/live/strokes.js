// What is drawn of a constraint at a pose, as gspcli/pictures/{strokes,guides,stage,arms}.py have it: the
// shortest connection with its right angles, or the arc between two directions; the arm or rail of its point.
import { armAt } from "./drives.js";
import { turned, turnedBack } from "./rotations.js";
import { add, cross, dot, middle, norm, perpendicular, sub, times, unit } from "./vectors.js";

/** Marks as fractions of the size of the scene. */
const SQUARE = 0.045;
const RAY = 0.36;
const ARC = 0.24;
const ARC_POINTS = 13;
/** Where on its line an angle is drawn: this far from the middle to the end. */
const OUTWARD = 0.55;
/** A plane reaches this much beyond the feet on it, and to none farther from its middle than that. */
const MARGIN = 0.12;
const REACH = 2;
const PARALLEL = 1e-9;
/** Feet outside by less than this fraction of the drawn part are inside. */
const INSIDE = 1e-6;

/** Strokes `[{style, points}]` of a constraint, and where its number is written; q is where its motor is. */
export function strokesAt({ kind, platform, base, drive, q = 0 }, { R, T }, size) {
  const place = (p) => add(turned(R, p), T);
  const at = { platform: place(middle(platform.outline)), base: middle(base.outline) };
  const directions = { w: platform.direction && turned(R, platform.direction), v: base.direction };
  if (kind.startsWith("A")) return angle(kind, vertex(kind, at, base), directions, size);
  const ends = connection(kind, at, directions);
  const strokes = [{ style: kind === "DPP" ? "leg" : "perpendicular", points: [ends.platform, ends.base] }];
  strokes.push(...rightAngles(kind, ends, directions, size));
  if (base.primitive !== "P") strokes.push(guide(base, ends.base, (p) => p));
  if (platform.primitive !== "P") strokes.push(guide(platform, turnedBack(R, sub(ends.platform, T)), place));
  if (drive) strokes.push(armAt(drive, q, { R, T }, size));
  return { strokes, label: times(0.5, add(ends.platform, ends.base)) };
}

/** Where a distance meets its primitives, in the frames of their bodies; null for an angle. */
export function feetAt({ kind, platform, base }, { R, T }) {
  if (kind.startsWith("A")) return null;
  const at = { platform: add(turned(R, middle(platform.outline)), T), base: middle(base.outline) };
  const ends = connection(kind, at, { w: platform.direction && turned(R, platform.direction), v: base.direction });
  return { platform: turnedBack(R, sub(ends.platform, T)), base: ends.base };
}

/** The outline of a plane that reaches to a foot on it; null if it does already, or if the foot is far away. */
export function reaching({ outline }, foot, size) {
  const centre = middle(outline);
  if (norm(sub(foot, centre)) > REACH * size) return null;
  const axes = [[0, 1], [0, 3]].map(([a, b]) => times(0.5, sub(outline[b], outline[a])));
  const ends = axes.map((half) => {
    const far = dot(sub(foot, centre), half) / dot(half, half);
    const beyond = Math.abs(far) > 1 + INSIDE ? far + (Math.sign(far) * MARGIN * size) / norm(half) : 0;
    return [Math.min(-1, beyond), Math.max(1, beyond)];
  });
  if (ends.every(([low, high]) => low === -1 && high === 1)) return null;
  const [[left, right], [below, above]] = ends;
  return [[left, below], [right, below], [right, above], [left, above]]
    .map(([x, y]) => add(centre, add(times(x, axes[0]), times(y, axes[1]))));
}

const along = (r, direction) => times(dot(r, direction), direction);

function connection(kind, { platform: p, base: x }, { w, v }) {
  const r = sub(p, x);
  if (kind === "DPL") return { platform: p, base: add(x, along(r, v)) };
  if (kind === "DLP") return { platform: sub(p, along(r, w)), base: x };
  if (kind === "DPH") return { platform: p, base: sub(p, along(r, v)) };
  if (kind === "DHP") return { platform: add(x, along(r, w)), base: x };
  if (kind !== "DLL") return { platform: p, base: x };
  const normal = cross(w, v);
  const square = dot(normal, normal);
  if (square < PARALLEL ** 2) return { platform: p, base: add(x, along(r, v)) };
  return {
    platform: add(p, times(dot(cross(v, r), normal) / square, w)),
    base: add(x, times(dot(cross(w, r), normal) / square, v)),
  };
}

function rightAngles(kind, ends, { w, v }, size) {
  const leg = sub(ends.platform, ends.base);
  const side = Math.min(SQUARE * size, norm(leg) / 3);
  const square = (at, up, aside) => {
    const [rise, run] = [times(side, unit(up, [0, 0, 0])), times(side, aside)];
    return { style: "square", points: [add(at, run), add(add(at, run), rise), add(at, rise)] };
  };
  const marks = [];
  if (["DPL", "DPH", "DLL"].includes(kind)) marks.push(square(ends.base, leg, kind === "DPH" ? perpendicular(v) : v));
  if (["DLP", "DHP", "DLL"].includes(kind)) {
    marks.push(square(ends.platform, times(-1, leg), kind === "DHP" ? perpendicular(w) : w));
  }
  return marks;
}

/** The way from what is drawn of a line or plane to a foot on it; a point where the foot is inside. */
function guide({ primitive, outline }, foot, place) {
  const centre = middle(outline);
  const sides = primitive === "L" ? [[0, 1]] : [[0, 1], [0, 3]];
  let nearest = centre;
  for (const [a, b] of sides) {
    const half = times(0.5, sub(outline[b], outline[a]));
    const far = dot(sub(foot, centre), half) / dot(half, half);
    const inside = Math.min(Math.max(far, -1), 1);
    nearest = add(nearest, times(Math.abs(far - inside) <= INSIDE ? far : inside, half));
  }
  return { style: "guide", points: [place(nearest), place(foot)] };
}

function vertex(kind, at, base) {
  if (kind === "AHL") return at.platform;
  return base.primitive === "L" ? add(at.base, times(OUTWARD, sub(base.outline[1], at.base))) : at.base;
}

function angle(kind, at, { w, v }, size) {
  const [first, second] = arms(kind, w, v);
  const cosine = dot(first, second);
  const over = sub(second, times(cosine, first));
  const across = unit(over, perpendicular(first));
  const full = Math.atan2(norm(over), cosine);
  const arc = Array.from({ length: ARC_POINTS }, (_, k) => {
    const turn = (full * k) / (ARC_POINTS - 1);
    return add(at, times(ARC * size, add(times(Math.cos(turn), first), times(Math.sin(turn), across))));
  });
  const rays = [first, second].map((arm) => ({ style: "ray", points: [at, add(at, times(RAY * size, arm))] }));
  const label = add(at, times(1.25, sub(arc[(ARC_POINTS - 1) / 2], at)));
  return { strokes: [{ style: "arc", points: arc }, ...rays], label };
}

/** The unit directions between which an angle lies, from the base on (the paper's Section 4). */
function arms(kind, w, v) {
  if (kind === "ALL") return [v, w];
  if (kind === "AHH") return [v, times(-1, w)];
  const [line, normal] = kind === "ALH" ? [w, v] : [v, w];
  const flat = unit(sub(line, times(dot(line, normal), normal)), perpendicular(normal));
  return line === w ? [flat, line] : [line, flat];
}
