// The map: how many modes are real over two of the values, filled by the worker, coarse to fine.
import { cssColour } from "../theme.js";
import { sharesText } from "./words.js";

const byId = (id) => document.getElementById(id);
const CELLS = 128;
const COARSE = 16;
/** Of cells where not all poses are proved; and of none yet. */
const OPEN = -1;
const NONE = -2;
/** Milliseconds for which other values must rest before the map begins again. */
const REST = 120;
/** A legend of more numbers is written smaller, beside the map. */
const MANY = 10;
/** Milliseconds between two legends, and between two pictures, while it fills. */
const TOLD = 500;
const PAINTED = 100;

export class ModeMap {
  /** `onMove(values)` goes where the map was pointed at. */
  constructor(worker, live, names, onMove) {
    Object.assign(this, { worker, live, onMove });
    const usable = live.ranges.flatMap(([low, high], i) => (high > low ? [i] : []));
    this.isShown = usable.length > 1;
    byId("map-part").hidden = !this.isShown;
    this.first = usable.slice(0, 2);
    this.which = [...this.first];
    this.canvas = byId("map");
    this.canvas.width = this.canvas.height = CELLS;
    this.context = this.canvas.getContext("2d");
    this.image = this.context.createImageData(CELLS, CELLS);
    this.counts = new Int16Array(CELLS * CELLS).fill(NONE);
    this.id = 0;
    this.under = null;
    for (const select of [byId("map-x"), byId("map-y")]) {
      for (const i of usable) select.add(new Option(names[i], String(i)));
      select.addEventListener("change", () => this.choose(select));
    }
    worker.addEventListener("message", ({ data }) => data.squares && this.receive(data));
    this.point();
  }

  /** Two different values: the one that is chosen, and the other. */
  choose(select) {
    const axis = select.id === "map-x" ? 0 : 1;
    const before = this.which[axis];
    this.which[axis] = Number(select.value);
    if (this.which[1 - axis] === this.which[axis]) this.which[1 - axis] = before;
    this.use(this.which);
    this.onChoose?.();
  }

  use(which) {
    this.which = [...which];
    this.drawn = null;
    if (this.values) this.show(this.values);
  }

  /** Show where we are; the map begins again if one of the other values is another one. */
  show(values) {
    this.values = values;
    if (!this.isShown) return;
    byId("map-x").value = String(this.which[0]);
    byId("map-y").value = String(this.which[1]);
    const [x, y] = this.which.map((i) => part(values[i], this.live.ranges[i]));
    const dot = byId("map-dot");
    // Beyond the map, as moves of the pose may lead, it stays at the edge.
    const [left, up] = [x, y].map((t) => Math.min(Math.max(t, 0), 1));
    dot.style.left = `${100 * left}%`;
    dot.style.top = `${100 * (1 - up)}%`;
    dot.classList.toggle("beyond", left !== x || up !== y);
    const drawn = values.map((v, i) => (this.which.includes(i) ? this.which.indexOf(i) : `=${v}`)).join();
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    this.canvas.classList.add("old");
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.begin(), REST);
  }

  begin() {
    this.id += 1;
    this.isFresh = true;
    this.isFilled = false;
    this.canvas.dataset.filled = "false";
    this.ends();
    const { values, which, id } = this;
    const cells = this.live.quick ? CELLS : CELLS / 4;
    this.cells = cells;
    this.worker.postMessage({ map: { id, values, which, ranges: this.live.ranges, cells, coarse: COARSE } });
  }

  ends() {
    const number = (x) => String(Number(x.toPrecision(4)));
    this.which.forEach((i, axis) => {
      const [low, high] = this.live.ranges[i];
      byId(`map-${"xy"[axis]}-ends`).textContent = `${"→↑"[axis]} ${number(low)} … ${number(high)} ${this.live.units[i]}`;
    });
  }

  receive({ id, squares, filled }) {
    if (id !== this.id) return;
    if (this.isFresh) this.counts.fill(NONE);
    this.isFresh = false;
    this.canvas.classList.remove("old");
    const scale = CELLS / this.cells;
    for (let k = 0; k < squares.length; k += 4) {
      const [column, row, side] = [0, 1, 2].map((n) => squares[k + n] * scale);
      for (let y = row; y < row + side; y += 1) this.counts.fill(squares[k + 3], y * CELLS + column, y * CELLS + column + side);
    }
    this.isFilled = filled;
    // What moves the platform meanwhile needs the time.
    if (filled || performance.now() > (this.painted ?? 0) + PAINTED) this.paint();
  }

  /** Colours of the style sheet, from few to many. */
  colours() {
    const numbers = (name) => cssColour(name).match(/[0-9a-f]{2}/gi).map((hex) => parseInt(hex, 16));
    const [low, middle, high] = ["map-low", "map-middle", "map-high"].map(numbers);
    const most = this.counts.reduce((a, b) => Math.max(a, b), 8);
    const mixed = (t) => (t < 0.5 ? [low, middle, 2 * t] : [middle, high, 2 * t - 1]);
    return (count) => {
      if (count === OPEN) return numbers("map-open");
      const [a, b, t] = mixed(count / most);
      return a.map((x, k) => Math.round(x + t * (b[k] - x)));
    };
  }

  /** Paint once before the next picture, for any number of messages. */ paint() {
    this.painting ??= requestAnimationFrame(() => {
      this.painting = null;
      this.paintNow();
    });
  }

  paintNow() {
    const colour = this.colours();
    const pixels = new Uint32Array(this.image.data.buffer);
    this.palette = new Map();
    const opaque = new Uint32Array(1000);
    for (const count of new Set(this.counts)) {
      if (count === NONE) continue;
      const [red, green, blue] = colour(count);
      this.palette.set(count, [red, green, blue]);
      opaque[count - NONE] = (255 << 24) | (blue << 16) | (green << 8) | red;
    }
    for (let row = 0; row < CELLS; row += 1) {
      const there = (CELLS - 1 - row) * CELLS;
      for (let column = 0; column < CELLS; column += 1) {
        pixels[there + column] = opaque[this.counts[row * CELLS + column] - NONE];
      }
    }
    this.context.putImageData(this.image, 0, 0);
    const now = (this.painted = performance.now());
    if (this.isFilled || now > (this.told ?? 0) + TOLD) this.tell(now);
  }

  /** The legend, and the same in words. */
  tell(now) {
    this.told = now;
    const cells = new Map();
    for (const count of this.counts) cells.set(count, (cells.get(count) ?? 0) + 1);
    const all = this.counts.length - (cells.get(NONE) ?? 0);
    cells.delete(NONE);
    const shares = [...cells].sort(([a], [b]) => b - a)
      .map(([count, many]) => ({ count: count === OPEN ? "not all proved" : String(count), part: many / all, of: count }));
    byId("map-legend").classList.toggle("many", shares.length > MANY);
    byId("map-legend").replaceChildren(...shares.map(({ count, part, of }) => {
      const item = document.createElement("li");
      const swatch = document.createElement("i");
      swatch.style.background = `rgb(${this.palette.get(of)})`;
      item.classList.toggle("open", of === OPEN);
      item.dataset.count = String(of);
      item.append(swatch, `${count} `);
      const share = document.createElement("span");
      share.textContent = part < 0.01 ? "< 1 %" : `${Math.round(100 * part)} %`;
      item.append(share);
      return item;
    }));
    this.say();
    const [x, y] = this.which.map((i) => i + 1);
    this.canvas.setAttribute("aria-label", `Map of the number of real modes over values ${x} and ${y}: ${sharesText(shares)}`);
    this.canvas.dataset.filled = String(this.isFilled);
  }

  /** Say how many modes are real under the pointer: neighbouring blues are hard to tell apart. */
  pointAt(event) {
    this.under = null;
    if (event) {
      const box = this.canvas.getBoundingClientRect();
      const column = Math.floor(((event.clientX - box.left) / box.width) * CELLS);
      const row = Math.floor((1 - (event.clientY - box.top) / box.height) * CELLS);
      const count = column in this.counts && row in this.counts ? this.counts[row * CELLS + column] : NONE;
      if (count !== undefined && count !== NONE) this.under = count;
    }
    this.say();
  }

  say() {
    const here = this.under === OPEN ? "not all proved here" : `${this.under} here`;
    byId("map-state").textContent = this.under !== null ? here : this.isFilled ? "" : "filling …";
    for (const item of byId("map-legend").children) item.classList.toggle("here", Number(item.dataset.count) === this.under);
  }

  /** Pointer and arrow keys move the two values. */
  point() {
    const go = (parts) => {
      const values = [...this.values];
      this.which.forEach((i, axis) => {
        const [low, high] = this.live.ranges[i];
        values[i] = Number((low + Math.min(Math.max(parts[axis], 0), 1) * (high - low)).toPrecision(6));
      });
      this.onMove(values);
    };
    const to = ({ clientX, clientY }) => {
      const box = this.canvas.getBoundingClientRect();
      go([(clientX - box.left) / box.width, 1 - (clientY - box.top) / box.height]);
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      to(event);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (this.canvas.hasPointerCapture(event.pointerId)) to(event);
      this.pointAt(event);
    });
    this.canvas.addEventListener("pointerleave", () => this.pointAt(null));
    this.canvas.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!way || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      go(this.which.map((i, axis) => part(this.values[i], this.live.ranges[i]) + way[axis] * (event.shiftKey ? 0.05 : 0.005)));
    });
  }
}

const part = (value, [low, high]) => (value - low) / (high - low || 1);
