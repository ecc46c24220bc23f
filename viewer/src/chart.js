// What changes along a motion: one curve over the slider, a cursor at the pose that is shown.
import { short } from "./numbers.js";

const SVG = "http://www.w3.org/2000/svg";
const WIDTH = 1000;
const HEIGHT = 100;
/** Of the height above and below the curve. */
const MARGIN = 6;

/** A chart of the first of: clearance, condition (logarithmic), with the ends of both axes as numbers. */
export class Chart {
  constructor(figure, onChoose) {
    const part = (name) => figure.querySelector(name);
    this.figure = figure;
    this.svg = part("svg");
    this.caption = part("figcaption");
    this.ends = { high: part(".high"), low: part(".low"), first: part(".first"), name: part(".parameter"), last: part(".last") };
    this.svg.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
    this.svg.addEventListener("pointerdown", (event) => {
      const box = this.svg.getBoundingClientRect();
      onChoose(Math.round(((event.clientX - box.left) / box.width) * (this.count - 1)));
    });
  }

  use(series) {
    this.count = series.T.length;
    const given = series.facts.clearance;
    const numeric = given?.some((value) => typeof value === "number");
    const values = numeric ? given : series.condition.map((c) => (c === null ? null : Math.log(c)));
    const known = values.filter((value) => typeof value === "number");
    this.figure.hidden = !series.parameter || known.length < 2;
    this.svg.replaceChildren();
    this.cursor = null;
    if (this.figure.hidden) return;
    const low = numeric ? Math.min(0, ...known) : Math.min(...known);
    const high = Math.max(...known);
    const y = (value) => HEIGHT - MARGIN - ((value - low) / (high - low || 1)) * (HEIGHT - 2 * MARGIN);
    const points = values
      .map((value, k) => [k, value])
      .filter(([, value]) => typeof value === "number")
      .map(([k, value]) => `${this.x(k).toFixed(1)},${y(value).toFixed(1)}`);
    for (const value of [low, high]) this.rule({ x1: 0, x2: WIDTH, y1: y(value), y2: y(value) }, "var(--rule)");
    this.add("polyline", { points: points.join(" "), fill: "none", stroke: "var(--accent)", "stroke-width": 1.6 });
    this.cursor = this.rule({ y1: 0, y2: HEIGHT }, "var(--ink)");
    this.caption.textContent = numeric ? "clearance" : "condition (logarithmic)";
    const number = (value) => short(numeric ? value : Math.exp(value), 3);
    const at = series.parameter.values;
    const texts = { high: number(high), low: number(low), first: short(at[0], 4), name: series.parameter.name, last: short(at.at(-1), 4) };
    for (const [name, text] of Object.entries(texts)) this.ends[name].textContent = text;
  }

  rule(ends, stroke) {
    return this.add("line", { ...ends, stroke, "stroke-width": 1.2 });
  }

  add(tag, attributes) {
    const node = document.createElementNS(SVG, tag);
    const all = { ...attributes, "vector-effect": "non-scaling-stroke" };
    for (const [key, value] of Object.entries(all)) node.setAttribute(key, value);
    this.svg.append(node);
    return node;
  }

  x(index) {
    return (index / Math.max(this.count - 1, 1)) * WIDTH;
  }

  move(index) {
    this.cursor?.setAttribute("x1", this.x(index));
    this.cursor?.setAttribute("x2", this.x(index));
  }
}
