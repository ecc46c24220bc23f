// What changes along a motion: one curve over the slider, a cursor at the pose that is shown.

const SVG = "http://www.w3.org/2000/svg";
const WIDTH = 1000;
const HEIGHT = 100;

/** A chart of the first of: clearance, condition (logarithmic). */
export class Chart {
  constructor(svg, caption, onChoose) {
    this.svg = svg;
    this.caption = caption;
    svg.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
    svg.addEventListener("pointerdown", (event) => {
      const box = svg.getBoundingClientRect();
      onChoose(Math.round(((event.clientX - box.left) / box.width) * (this.count - 1)));
    });
  }

  use(series) {
    this.count = series.T.length;
    const given = series.facts.clearance;
    const numeric = given?.some((value) => typeof value === "number");
    const values = numeric ? given : series.condition.map((c) => (c === null ? null : Math.log(c)));
    const known = values.filter((value) => typeof value === "number");
    this.svg.toggleAttribute("hidden", !series.parameter || known.length < 2);
    this.caption.hidden = this.svg.hasAttribute("hidden");
    this.svg.replaceChildren();
    this.cursor = null;
    if (!known.length) return;
    const low = numeric ? Math.min(0, ...known) : Math.min(...known);
    const span = Math.max(...known) - low || 1;
    const points = values
      .map((value, k) => [k, value])
      .filter(([, value]) => typeof value === "number")
      .map(([k, value]) => `${this.x(k).toFixed(1)},${(HEIGHT - 6 - ((value - low) / span) * (HEIGHT - 24)).toFixed(1)}`);
    this.add("polyline", { points: points.join(" "), fill: "none", stroke: "var(--accent)", "stroke-width": 1.6, "vector-effect": "non-scaling-stroke" });
    this.cursor = this.add("line", { y1: 0, y2: HEIGHT, stroke: "var(--ink)", "stroke-width": 1.2, "vector-effect": "non-scaling-stroke" });
    this.caption.textContent = numeric ? "clearance" : "condition (logarithmic)";
  }

  add(tag, attributes) {
    const node = document.createElementNS(SVG, tag);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
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
