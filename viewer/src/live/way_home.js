// A safe way of the followed mode home: straight values, straight poses, or poses of a map. Each piece of it is
// straight in values, so ranges hold on all of it; the kernel proves that none of its poses is singular.
import { quaternion, rotation } from "./kernel.js";
import { nearest, proved } from "./matching.js";
import { distance, turned, turnedBack } from "./rotations.js";
import { add, cross, dot, norm, sub } from "./vectors.js";

/** A pose is there if it is this near. */
const THERE = 1e-6;
/** The pose of home is known this well: numbers of the page have fewer digits. */
const HOME = 1e-2;
/** A straight way of values is halved so often at most, to be proved. */
const HALVINGS = 8;
/** Straight ways of poses have at first so many pieces, each halved so often at most. */
const PIECES = 8;
const POSE_HALVINGS = 6;
/** So many poses of the map are tried, the nearest first, and so many milliseconds at most. */
const TRIED = 24;
const PATIENCE = 250;
/** Parts of a range, or of one, that rounding may leave it by. */
const ROOM = 1e-9;
/** In how many places of each piece cones are tested. */
const LOOKS = 12;

export class WaysHome {
  /** `ways` is what the page has of limits and poses (gspcli/pictures/live_home.py). */
  constructor(model, ways) {
    Object.assign(this, { model, ways });
    this.poses = ways.poses.map((numbers) => ({ T: numbers.slice(0, 3), R: rotation(numbers.slice(3)) }));
    this.parts = new Map();
  }

  /** The pose of home. */
  get home() {
    const { start, home, length } = this.model;
    const wanted = start.numbered?.[home - 1];
    const pose = wanted && nearest(wanted, start.found.poses, length, HOME);
    return pose ? { R: pose.R, T: Array.from(pose.T), values: start.values } : null;
  }

  /**
   * Return the way home of the present mode: its `kind` (values, poses, stored), its poses with their values (`rows`),
   * how many of these are of the map (`stored`), and whether it begins `outside` a limit. If there is no way, return
   * the `reason`: sign (every way is singular somewhere) or none (not found). Null without a mode.
   */
  find() {
    const { model, home } = this;
    const { current, kernel, length } = model;
    if (!current || !home) return null;
    const here = { R: current.R, T: Array.from(current.T), values: model.values };
    if (distance(here, home, length) < THERE && here.values.every((x, i) => x === home.values[i])) return { isHome: true };
    const outside = this.isOutside(here);
    const signs = [here, home].map(({ R, T, values }) => kernel.sign(R, T, values));
    if (this.ways.signed && signs[0] * signs[1] < 0) return { reason: "sign" };
    const straight = this.straight(here, home);
    if (straight) return { ...straight, outside };
    const way = this.throughMap(here);
    return way ? { ...way, outside } : { reason: "none" };
  }

  /** A straight way, of values or else of poses; null if neither is proved. */
  straight(from, to) {
    const rows = this.ofValues(from, to);
    if (rows) return { kind: "values", rows };
    const others = this.ofPoses(from, to);
    return others && { kind: "poses", rows: others };
  }

  ofValues(from, to) {
    const { kernel, length } = this.model;
    const there = proved(kernel, from, from.values, to.values, HALVINGS);
    if (!there || distance(there, to, length) > THERE) return null;
    return this.keepsCones(from, to) ? [from, to] : null;
  }

  /** The middle of the platform on a line, turning about one axis; in pieces that are straight in values. */
  ofPoses(from, to) {
    const at = between(from, to, this.ways.middle);
    const rows = [from];
    for (let k = 1; k <= PIECES; k += 1) {
      const more = this.piece(rows.at(-1), k === PIECES ? to : null, at, [(k - 1) / PIECES, k / PIECES], POSE_HALVINGS);
      if (!more) return null;
      rows.push(...more);
    }
    return rows;
  }

  /** The rows after one on a part of a way of poses; null if it is not proved, or leaves a limit. */
  piece(from, last, at, [begin, end], halvings) {
    const { kernel, length } = this.model;
    const pose = last ?? at(end);
    const values = last?.values ?? kernel.measure(pose.R, pose.T, from.values);
    if (!values) return null;
    const to = { ...pose, values };
    if (this.isOutside(to)) return null;
    const { status, R, T } = kernel.follow(from.R, from.T, from.values, values);
    if (status === 0 && distance({ R, T }, to, length) < THERE) return this.keepsCones(from, to) ? [to] : null;
    if (halvings === 0) return null;
    const half = (begin + end) / 2;
    const first = this.piece(from, null, at, [begin, half], halvings - 1);
    const second = first && this.piece(first.at(-1), last, at, [half, end], halvings - 1);
    return second && [...first, ...second];
  }

  /** By a straight way to one of the nearest poses of the map, and from pose to pose home. */
  throughMap(here) {
    const { length } = this.model;
    const order = this.poses.map((pose, k) => ({ k, far: distance(pose, here, length) })).sort((a, b) => a.far - b.far);
    const end = performance.now() + PATIENCE;
    for (const { k } of order.slice(0, TRIED)) {
      if (performance.now() > end) return null;
      const rest = this.fromStored(k);
      const first = rest && this.straight(here, rest.rows[0]);
      if (first) return { kind: "stored", stored: rest.stored, rows: [...first.rows, ...rest.rows.slice(1)] };
    }
    return null;
  }

  /** The way home from a pose of the map, proved here once; null if it is not. */
  fromStored(k) {
    if (k < 0) return { stored: 0, rows: [this.home] };
    if (!this.parts.has(k)) this.parts.set(k, this.proveStored(k));
    return this.parts.get(k);
  }

  proveStored(k) {
    const rest = this.fromStored(this.ways.after[k]);
    if (!rest) return null;
    const next = rest.rows[0];
    const pose = this.poses[k];
    const values = this.model.kernel.measure(pose.R, pose.T, next.values);
    const from = values && { ...pose, values };
    const way = from && !this.isOutside(from) && this.straight(from, next);
    return way ? { stored: rest.stored + 1, rows: [...way.rows, ...rest.rows.slice(1)] } : null;
  }

  /** Whether a pose violates a range or a cone. */
  isOutside({ R, T, values }) {
    const isBeyond = (range, i) => {
      const room = ROOM * Math.max(...range.map(Math.abs));
      return !(values[i] >= range[0] - room && values[i] <= range[1] + room);
    };
    return this.ways.within.some((range, i) => range && isBeyond(range, i)) || this.tilt({ R, T }) > 1 + ROOM;
  }

  /** The largest tilt of a joint by the half angle of its cone; 0 without cones. */
  tilt({ R, T }) {
    return Math.max(0, ...(this.ways.cones ?? []).map(({ points: [platform, base], body, axis, angle }) => {
      const r = sub(add(turned(R, platform), Array.from(T)), base);
      const direction = body === "base" ? r : turnedBack(R, r).map((x) => -x);
      const far = Math.atan2(norm(cross(axis, direction)), dot(axis, direction));
      return Number.isFinite(far) ? far / angle : 0;
    }));
  }

  /** Whether places between two rows, straight in values, keep the cones, or do not leave them farther than at first. */
  keepsCones(from, to) {
    if (!this.ways.cones?.length) return true;
    const most = Math.max(1, this.tilt(from)) + ROOM;
    for (let k = 1; k <= LOOKS; k += 1) {
      const place = this.placeOn(from, to, k / LOOKS);
      if (!place || this.tilt(place) > most) return false;
    }
    return true;
  }

  /** The pose at a part of a piece that is straight in values. */
  placeOn(from, to, t) {
    if (t >= 1) return to;
    const values = from.values.map((x, i) => x + t * (to.values[i] - x));
    const found = proved(this.model.kernel, from, from.values, values, HALVINGS);
    return found && { ...found, values };
  }

  /** Where one is on a way at a part of its length. */
  at(rows, t) {
    const { length } = this.model;
    const sizes = rows.slice(1).map((row, k) => distance(rows[k], row, length));
    let left = t * sizes.reduce((sum, x) => sum + x, 0);
    for (const [k, size] of sizes.entries()) {
      if (left <= size || k === sizes.length - 1) return this.placeOn(rows[k], rows[k + 1], size > 0 ? left / size : 1);
      left -= size;
    }
    return rows.at(-1);
  }
}

/** Poses on the straight way between two: a point of the platform moves on a line while it turns about one axis. */
function between(from, to, point) {
  const [p, q] = [quaternion(from.R), quaternion(to.R)];
  const cosine = p.reduce((sum, x, k) => sum + x * q[k], 0);
  const near = cosine < 0 ? q.map((x) => -x) : q;
  const angle = Math.atan2(Math.hypot(...p.map((x, k) => near[k] - x)) / 2, Math.hypot(...p.map((x, k) => near[k] + x)) / 2);
  const [a, b] = [from, to].map(({ R, T }) => add(turned(R, point), Array.from(T)));
  return (t) => {
    // Half the angle between both quaternions is that of their sum and difference.
    const weights = angle > 1e-8
      ? [Math.sin(2 * (1 - t) * angle), Math.sin(2 * t * angle)].map((x) => x / Math.sin(2 * angle))
      : [1 - t, t];
    const mixed = p.map((x, k) => weights[0] * x + weights[1] * near[k]);
    const size = Math.hypot(...mixed);
    const R = rotation(mixed.map((x) => x / size));
    const middle = a.map((x, k) => x + t * (b[k] - x));
    return { R, T: sub(middle, turned(R, point)) };
  };
}
