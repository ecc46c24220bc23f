// The state in the fragment of the address: values by number of constraint, the mode, and where it is.
// #1=4.25&3=5&mode=2
import { rotation } from "./kernel.js";
import { distance } from "./rotations.js";

/** Milliseconds of rest before the address is written: browsers count how often that is done. */
const REST = 250;
const SAME = 1e-4;
/** Of values that were measured at a pose. */
const DIGITS = 12;

/** The fragment of a state; empty for the state of the file. `at` is only needed where numbers have a history. */
export function fragmentOf({ values, home, mode, homeMode, at, map }) {
  const parts = values.flatMap((x, i) => (x === home[i] ? [] : [`${i + 1}=${Number(x.toPrecision(DIGITS))}`]));
  if (mode !== null && mode !== homeMode) parts.push(`mode=${mode}`);
  if (at) parts.push(`at=${at.map((x) => Number(x.toPrecision(7))).join(",")}`);
  if (map) parts.push(`map=${map.map((i) => i + 1).join(",")}`);
  return parts.length ? `#${parts.join("&")}` : "";
}

/** What a fragment asks for; what is no number is left out. */
export function stateOf(fragment, home) {
  const asked = new URLSearchParams(fragment.replace(/^#/, ""));
  const number = (name) => (asked.get(name) ? Number(asked.get(name)) : NaN);
  const list = (name, count) => {
    const numbers = (asked.get(name) ?? "").split(",").map(Number);
    return numbers.length === count && numbers.every(Number.isFinite) ? numbers : null;
  };
  const mode = number("mode");
  const map = list("map", 2)?.map((k) => k - 1);
  return {
    values: home.map((x, i) => (Number.isFinite(number(String(i + 1))) ? number(String(i + 1)) : x)),
    mode: Number.isInteger(mode) ? mode : null,
    at: list("at", 7),
    map: map && map[0] !== map[1] && map.every((k) => k in home) ? map : null,
  };
}

/** Keeps the address and the model the same. */
export class Link {
  constructor(model, map, { onState }) {
    Object.assign(this, { model, map, onState });
    window.addEventListener("hashchange", () => this.read());
  }

  read() {
    clearTimeout(this.resting);
    this.known = window.location.hash;
    const state = stateOf(window.location.hash, this.model.start.values);
    if (state.map) this.map.use(state.map);
    this.usual ??= [...this.map.first];
    this.onState(state);
  }

  write() {
    if (this.usual === undefined) return;
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.replace(), REST);
  }

  replace() {
    const { model, map } = this;
    // Another link may be set already of which the event is yet to come.
    if (model.ahead || window.location.hash !== this.known) return;
    const mode = model.current;
    const fragment = fragmentOf({
      values: model.values,
      home: model.start.values,
      mode: mode?.number ?? null,
      homeMode: model.home,
      at: mode && !this.isStraight(mode) ? [...mode.T, ...mode.q] : null,
      map: map.which.some((k, n) => k !== this.usual[n]) ? map.which : null,
    });
    if (fragment === window.location.hash) return;
    const { pathname, search } = window.location;
    window.history.replaceState(null, "", fragment || `${pathname}${search}`);
    this.known = window.location.hash;
  }

  /** Whether the mode of this number, on the straight way from the values of the file, is this one. */
  isStraight(mode) {
    const { model } = this;
    const { values, numbered } = model.start;
    const first = numbered[mode.number - 1];
    if (!first) return false;
    const there = model.kernel.follow(first.R, first.T, values, model.values);
    return there.status === 0 && distance(there, mode, model.length) < SAME;
  }
}

/** A pose from the numbers of a link. */
export const poseOf = (at) => ({ T: at.slice(0, 3), R: rotation(at.slice(3)) });
