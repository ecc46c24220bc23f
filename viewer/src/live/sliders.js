// Six sliders with a number beside each: of the values, or of the pose.

const STEPS = 2000;

/** Decimals so that a step of a slider changes the last or last but one. */
function decimalsFor(width) {
  return Math.min(Math.max(Math.ceil(-Math.log10(width / STEPS)), 0), 12);
}

class Slider {
  constructor(home, { name, title, kind, unit, id }, onInput) {
    this.onInput = onInput;
    this.row = document.createElement("div");
    this.row.className = "slider";
    this.row.innerHTML = '<label><b></b> <span class="between"></span> <span class="kind"></span></label>'
      + '<span class="entry"><input type="number" step="any" inputmode="decimal"><span class="unit"></span></span>'
      + '<input type="range" min="0" step="1">';
    const part = (selector) => this.row.querySelector(selector);
    this.number = part("input[type=number]");
    this.range = part("input[type=range]");
    part("b").textContent = name;
    part(".between").textContent = title;
    part(".kind").textContent = kind;
    part(".unit").textContent = unit;
    part("label").htmlFor = this.number.id = id;
    this.range.max = String(STEPS);
    this.range.setAttribute("aria-label", `${name} ${title}`.trim());
    this.unit = unit;
    this.range.addEventListener("input", () => this.slide());
    this.range.addEventListener("keydown", (event) => this.hold(event));
    this.number.addEventListener("change", () => this.type());
    this.number.addEventListener("keydown", (event) => this.hold(event));
    home.append(this.row);
  }

  /** Slide from low to high; numbers that are typed may be beyond these, but within the limits. */
  use(low, high, [least, most] = [null, null]) {
    Object.assign(this, { low, high, least: least ?? -Infinity, most: most ?? Infinity });
    this.decimals = decimalsFor(high - low || 1);
    this.range.disabled = this.number.disabled = !(high > low);
  }

  slide() {
    const exact = this.low + (Number(this.range.value) / STEPS) * (this.high - this.low);
    const end = { 0: this.low, [STEPS]: this.high }[this.range.value];
    this.give(end ?? Number(exact.toFixed(this.decimals)));
  }

  type() {
    const value = this.number.valueAsNumber;
    if (Number.isFinite(value)) this.give(Math.min(Math.max(value, this.least), this.most));
    else this.show(this.value);
  }

  /** Arrow keys step by the last decimal (ten with shift) where the browser would step by one or by a pixel. */
  hold(event) {
    const way = { ArrowUp: 1, ArrowDown: -1 }[event.key] ?? (event.target === this.range ? { ArrowRight: 1, ArrowLeft: -1 }[event.key] : undefined);
    if (!way) return;
    event.preventDefault();
    const step = Math.max(10 ** -this.decimals, (this.high - this.low) / STEPS) * (event.shiftKey ? 10 : 1);
    const next = this.value + way * step;
    const isRange = event.target === this.range;
    const [low, high] = isRange ? [this.low, this.high] : [this.least, this.most];
    this.give(Number(Math.min(Math.max(next, low), high).toFixed(this.decimals)));
  }

  give(value) {
    this.show(value);
    this.onInput(value);
  }

  show(value) {
    this.value = value;
    const text = String(Number(value.toFixed(this.decimals + 2)));
    this.number.value = text;
    this.range.value = String(Math.round(((value - this.low) / (this.high - this.low || 1)) * STEPS));
    this.range.setAttribute("aria-valuetext", `${text} ${this.unit}`);
    // A value of the file at the end of its range may differ from it by rounding.
    const slack = 1e-9 * (Math.abs(this.low) + Math.abs(this.high));
    this.row.classList.toggle("outside", value < this.low - slack || value > this.high + slack);
  }
}

/** A group of sliders. `onInput` gets all its numbers. */
export class Sliders {
  constructor(home, rows, onInput) {
    this.parts = rows.map((row, k) => new Slider(home, row, (value) => {
      this.numbers[k] = value;
      onInput([...this.numbers]);
    }));
    this.numbers = [];
  }

  use(ranges, limits = []) {
    this.parts.forEach((part, k) => part.use(...ranges[k], limits[k]));
  }

  show(numbers) {
    this.numbers = [...numbers];
    this.parts.forEach((part, k) => part.show(numbers[k]));
  }

  choose(which) {
    this.parts.forEach(({ row }, k) => row.classList.toggle("chosen", k === which));
  }
}
