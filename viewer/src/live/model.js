// The platform at present: values, all modes, which is followed. What changes it, and what happened.
import { quaternion } from "./kernel.js";
import { meeting } from "./folds.js";
import { carry, inPairs, nearest } from "./matching.js";
import { distance } from "./rotations.js";

/** Two modes that appear where two had met are the same again. */
const AGAIN = 0.5;
const KEPT_FOLDS = 50;

export class Model {
  /** `modes` are the poses for the values of the file, in the order of `gsp solve`. */
  constructor(kernel, length, values, home) {
    Object.assign(this, { kernel, length, home });
    this.start = { values, poses: [] };
    this.values = values;
    this.modes = [];
    this.account = { complete: false, isPossible: true, expected: kernel.expected, proved: 0, real: 0 };
    this.folds = [];
    this.highest = 0;
    this.followed = null;
    /** Where the followed mode is while the others are not known yet. */
    this.ahead = null;
  }

  /** Begin with the poses for the values of the file; `numbered` are those of `gsp solve`. */
  begin(found, numbered) {
    const { values } = this.start;
    this.start.numbered = numbered;
    this.start.found = found;
    this.values = values;
    this.folds = [];
    const left = new Set(found.poses);
    this.modes = [];
    numbered.forEach((given, k) => {
      const pose = nearest(given, left, this.length, 0.01);
      if (!pose) return;
      left.delete(pose);
      this.modes.push(this.mode(k + 1, pose, true));
    });
    this.highest = numbered.length;
    for (const pose of left) this.modes.push(this.mode((this.highest += 1), pose, true));
    this.count(found);
    this.follow(this.home);
  }

  mode(number, { R, T }, isProved, values = this.values) {
    const q = quaternion(R);
    return { number, R, T, q: q[0] < 0 ? q.map((x) => -x) : q, condition: this.kernel.condition(R, T, values), isProved };
  }

  count({ complete, isPossible, expected, proved, poses }) {
    this.account = { complete, isPossible, expected, proved, real: poses.length };
  }

  get current() {
    return this.modes.find(({ number }) => number === this.followed) ?? null;
  }

  /** Follow a mode; that of home if there is none of that number, else the first. */
  follow(number) {
    const named = (wanted) => this.modes.find((one) => one.number === wanted);
    const mode = named(number) ?? named(this.home) ?? this.modes[0];
    this.followed = mode?.number ?? null;
  }

  /** Follow the mode in a pose, and call it by a number. */
  name(pose, number) {
    const there = nearest(pose, this.modes, this.length, 0.01);
    if (!there) return;
    const other = this.modes.find((mode) => mode.number === number);
    if (other && number !== null) other.number = there.number;
    there.number = number ?? there.number;
    this.modes.sort((a, b) => a.number - b.number);
    this.highest = Math.max(this.highest, there.number);
    this.followed = there.number;
  }

  /**
   * Go to other values, where `found` are all poses. A step on which modes are lost or found is taken
   * in parts, halved `parts` times at most: `solve(values)` gives all poses on the way, at once or
   * later. `known` has modes that were followed to these values. Returns what happened.
   */
  async go(to, found, { solve, known, parts }) {
    const step = carry(this, this.modes, this.values, to, found.poses, known);
    const isPlain = step.lost.length + step.born.length === 0;
    if (!isPlain && parts > 0 && found.complete) {
      const half = this.values.map((x, i) => (x + to[i]) / 2);
      const first = await this.go(half, await solve(half), { solve, parts: parts - 1 });
      const second = await this.go(to, found, { solve, known, parts: parts - 1 });
      return {
        met: [...first.met, ...second.met],
        gone: [...first.gone, ...second.gone],
        followed: first.followed ?? second.followed,
      };
    }
    const happened = this.lose(step.lost, to);
    this.values = to;
    this.modes = step.carried.map(({ mode, pose, isProved }) => this.mode(mode.number, pose, isProved));
    this.modes.push(...this.welcome(step.born));
    this.modes.sort((a, b) => a.number - b.number);
    this.count(found);
    happened.followed = this.followed;
    if (!this.current) this.followed = null;
    return happened;
  }

  /** Pairs that met on the way to other values, and modes of which that is not known. */
  lose(lost, to) {
    const { pairs, alone } = inPairs(lost, this.length);
    const happened = { met: [], gone: [...alone] };
    for (const [a, b] of pairs) {
      const where = meeting(this, a, b, this.values, to);
      if (where) happened.met.push({ modes: [a, b], ...where });
      else happened.gone.push(a, b);
    }
    this.folds = [...happened.met, ...this.folds].slice(0, KEPT_FOLDS);
    return happened;
  }

  /** New modes: with the numbers that they had if they appear where they had vanished, else new ones. */
  welcome(born) {
    const { pairs, alone } = inPairs(born, this.length);
    const modes = [];
    for (const pair of pairs) {
      const fold = this.fold(pair);
      const numbers = fold ? fold.modes.map(({ number }) => number) : [(this.highest += 1), (this.highest += 1)];
      const isCrossed = fold && distance(pair[0], fold.pair[1], this.length) < distance(pair[0], fold.pair[0], this.length);
      if (isCrossed) numbers.reverse();
      pair.forEach((pose, k) => modes.push(this.mode(numbers[k], pose, true)));
    }
    for (const pose of alone) modes.push(this.mode((this.highest += 1), pose, true));
    return modes;
  }

  /** Take the fold at which two modes vanished that now appear again. */
  fold(pair) {
    const far = ({ pair: [a, b] }) => Math.min(
      distance(pair[0], a, this.length) + distance(pair[1], b, this.length),
      distance(pair[0], b, this.length) + distance(pair[1], a, this.length),
    );
    const best = this.folds.reduce((least, fold) => (far(fold) < (least ? far(least) : AGAIN) ? fold : least), null);
    if (best) this.folds = this.folds.filter((fold) => fold !== best);
    return best;
  }

  /** Go where a pose is: its values are measured, and the mode in it is followed. */
  async goPose(pose, found, values, how) {
    const before = this.followed;
    const happened = await this.go(values, found, how);
    const there = nearest(pose, this.modes, this.length, 1e-4);
    if (there) this.followed = there.number;
    return { ...happened, passed: there && before !== null && there.number !== before ? [before, there.number] : null };
  }

  /** Move the followed mode alone, where all poses take long; it is not shown if that is not proved. */
  goAhead(to, pose) {
    const from = this.ahead ?? { mode: this.current, values: this.values };
    this.ahead = { values: to, mode: null };
    if (!from.mode) return;
    const { status, R, T } = pose ? { status: 0, ...pose } : this.kernel.follow(from.mode.R, from.mode.T, from.values, to);
    if (status === 0) this.ahead.mode = this.mode(from.mode.number, { R, T }, true, to);
  }

  /** All modes at the values to which the followed one, `mode`, went ahead (null if it did not). */
  async catchUp(to, found, { mode, pose, ...how }) {
    if (pose) return this.goPose(pose, found, to, how);
    const known = mode ? new Map([[mode.number, mode]]) : undefined;
    const happened = await this.go(to, found, { ...how, known });
    if (!mode) return happened;
    // The way of the mode may have been another one than that of the others.
    this.name(mode, mode.number);
    const isThere = ({ number }) => this.modes.some((one) => one.number === number);
    return {
      ...happened,
      met: happened.met.filter(({ modes }) => !modes.every(isThere)),
      gone: happened.gone.filter((one) => !isThere(one)),
    };
  }
}
