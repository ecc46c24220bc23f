// What moves the platform: sliders of values and of the pose, the map, the link; one move a frame.
import { Expressed } from "./expressed.js";
import { poseOf } from "./link.js";
import { fromAngles, toAngles } from "./rotations.js";
import { Sliders } from "./sliders.js";

const byId = (id) => document.getElementById(id);
const POSE = ["x", "y", "z", "rx", "ry", "rz"];
/** Milliseconds that all poses may take in a move; where they take longer they are solved when it rests. */
const QUICK = 16;
/** Of so many times the shortest counts: others may have had to wait. */
const TIMES = 3;
/** Milliseconds for which values must rest before all poses are solved that take long. */
const REST = 80;
/** Steps on which modes were lost or found are taken in parts, halved so often, where it is quick. */
const PARTS = 2;
/** Milliseconds that the way home takes in the picture. */
const WAY = 1500;
/** How far sliders of the pose go to each side, in sizes of the scene and degrees. */
const SHIFT = 0.5;
const TURN = 45;

export class Motion {
  /** `show(happened)` shows the model after a move. */
  constructor(model, ways, scene, live, worker, show) {
    Object.assign(this, { model, ways, scene, live, worker, onShow: show });
    this.wanted = null;
    this.id = 0;
    this.turn = 0;
    this.times = Array(TIMES).fill(live.quick ? 0 : Infinity);
    const value = ({ number, platform, base, kind }, k) => ({
      name: String(number), title: `${platform}–${base}`, kind, unit: live.units[k], id: `value-${number}`,
    });
    const coordinate = (name, k) => ({
      name, title: "", kind: "", unit: k < 3 ? scene.units.length : "°", id: `pose-${name}`,
    });
    const motor = (name, k) => ({
      name, title: live.titles[k], kind: live.kinds[k], unit: live.units[k], id: `value-${k + 1}`,
    });
    const rows = live.names ? live.names.map(motor) : scene.constraints.map(value);
    this.expressed = new Expressed(live.frame);
    const said = document.createElement("p");
    said.className = "note";
    said.textContent = live.frame.words;
    byId("coordinates").append(said);
    this.sliders = {
      values: new Sliders(byId("values"), rows, (values) => this.goTo(values)),
      pose: new Sliders(byId("coordinates"), POSE.map(coordinate), (numbers) => this.want({ numbers })),
    };
    this.sliders.values.use(live.ranges, live.limits);
    for (const input of document.querySelectorAll("input[name=moved]")) {
      input.addEventListener("change", () => this.turnTo(input.value));
    }
  }

  /** Whether all poses take longer than a move may. */
  get isSlow() {
    return Math.min(...this.times) > QUICK;
  }

  took(milliseconds) {
    this.times = [...this.times.slice(1), milliseconds];
  }

  /** All poses for some values, here or, if that takes long, in the worker. */
  solver() {
    return this.isSlow ? (values) => this.solvedBeside(values) : (values) => this.solvedHere(values);
  }

  solvedHere(values) {
    const began = performance.now();
    const found = this.model.kernel.solve(values);
    this.took(performance.now() - began);
    return found;
  }

  solvedBeside(values) {
    this.id += 1;
    const { id, worker } = this;
    return new Promise((resolve) => {
      const receive = ({ data }) => {
        if (!data.solved || data.id !== id) return;
        worker.removeEventListener("message", receive);
        this.took(data.milliseconds);
        resolve(data.solved);
      };
      worker.addEventListener("message", receive);
      worker.postMessage({ solve: { values, id } });
    });
  }

  /** How the model goes elsewhere; what comes after `stop` is not waited for. */
  how() {
    const { turn } = this;
    const solve = this.solver();
    const stillWanted = (found) => (turn === this.turn ? found : new Promise(() => {}));
    return { solve: async (values) => stillWanted(await solve(values)), parts: this.live.quick ? PARTS : 0 };
  }

  /** Solve the values of the file and number the modes as `gsp solve` did. */
  async begin(given) {
    const { model } = this;
    model.begin(await this.solver()(model.start.values), given);
    this.onShow();
  }

  goTo(values) {
    this.want({ values });
  }

  /** Bring the followed mode home along a proved way; where none is found it stays, and this is said. */
  goHome() {
    const { model } = this;
    if (model.ahead || this.way) return;
    const found = this.ways.find();
    this.onShow({ way: found });
    if (!found?.rows) return;
    const { followed } = model;
    const began = performance.now();
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    const way = {};
    const step = () => {
      if (this.way !== way) return;
      const t = still ? 1 : (performance.now() - began) / WAY;
      if (t < 1) {
        const place = this.ways.at(found.rows, t);
        if (!place) return;
        this.want({ values: place.values, known: new Map([[followed, place]]) });
        this.way = way;
        requestAnimationFrame(step);
        return;
      }
      this.stop();
      this.begun();
      this.rebase();
      this.onShow({ isAnew: true });
    };
    this.way = way;
    requestAnimationFrame(step);
  }

  /** One move a frame, the last that was asked for. */
  want(target) {
    this.way = null;
    if (!this.wanted) requestAnimationFrame(() => this.wanted && this.move());
    this.wanted = target;
  }

  /** Forget moves that were asked for and are not done. */
  stop() {
    this.way = null;
    this.turn += 1;
    this.wanted = this.target = null;
    this.model.ahead = null;
    this.isBusy = false;
    clearTimeout(this.resting);
  }

  async move() {
    const { model, wanted } = this;
    if (model.ahead?.isOpening) this.stop();
    this.wanted = null;
    const pose = wanted.numbers
      && this.expressed.to({ T: wanted.numbers.slice(0, 3), R: fromAngles(wanted.numbers.slice(3)) });
    const near = model.ahead?.values ?? model.values;
    const values = pose ? model.kernel.measure(pose.R, pose.T, near) : wanted.values;
    if (values === null) {
      this.rebase();
      this.onShow({ unreached: true });
      return;
    }
    this.pose = pose ? wanted.numbers : null;
    if (this.isSlow || model.ahead) {
      this.goAhead(values, pose, wanted.known);
      return;
    }
    // All of it is done before the next picture, since nothing is awaited that comes later.
    const how = { solve: (there) => this.solvedHere(there), parts: PARTS, known: wanted.known };
    const found = how.solve(values);
    this.onShow(await (pose ? model.goPose(pose, found, values, how) : model.go(values, found, how)));
  }

  /** The followed mode at once, the others when the slider rests. */
  goAhead(values, pose, known) {
    this.model.goAhead(values, pose ?? known?.values().next().value);
    this.target = { values, pose };
    this.onShow();
    this.rest();
  }

  rest() {
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.catchUp(), REST);
  }

  /** All modes where the followed one is; if that has gone on meanwhile, once more when it rests. */
  async catchUp() {
    const { model, target } = this;
    if (this.isBusy || !target) return;
    const { mode } = model.ahead;
    const how = this.how();
    this.isBusy = true;
    const found = await how.solve(target.values);
    const isPassed = () => target !== this.target;
    const happened = isPassed() ? {} : await model.catchUp(target.values, found, { ...how, mode, pose: target.pose });
    this.isBusy = false;
    if (isPassed()) {
      this.rest();
      return;
    }
    model.ahead = this.target = null;
    this.onShow(happened);
  }

  /** The values and the home mode of the file, numbered as at first. */
  home() {
    this.stop();
    this.begun();
    this.rebase();
    this.onShow({ isAnew: true });
  }

  begun() {
    const { model } = this;
    model.begin(model.start.found, model.start.numbered);
  }

  /** The values of the file: where the present mode leads there. */
  reset() {
    this.goTo([...this.live.values]);
  }

  /** Go where a link leads: from the values of the file, along a straight line. */
  async open({ values, mode, at }) {
    const { model } = this;
    this.stop();
    this.begun();
    if (values.some((x, i) => x !== model.values[i])) {
      const how = this.how();
      model.ahead = { values, mode: null, isOpening: true };
      if (this.isSlow) this.onShow({ isAnew: true });
      await model.go(values, await how.solve(values), how);
      model.ahead = null;
    }
    if (at) model.name(poseOf(at), mode);
    else if (mode !== null) model.follow(mode);
    this.rebase();
    this.onShow({ isAnew: true });
  }

  turnTo(which) {
    byId("values").hidden = which !== "values";
    byId("coordinates").hidden = which === "values";
    this.rebase();
    this.show(this.model.values, this.model.current);
  }

  /** Sliders of the pose begin in their middle. */
  rebase() {
    this.pose = null;
    this.middle = null;
  }

  show(values, mode) {
    this.sliders.values.show(values);
    if (!mode || byId("coordinates").hidden) return;
    const { R, T } = this.expressed.from(mode);
    const numbers = this.pose ?? [...T, ...toAngles(R)];
    const reach = (k) => (k < 3 ? SHIFT * this.scene.size : TURN);
    if (!this.pose || !this.middle) {
      this.middle = numbers;
      this.sliders.pose.use(numbers.map((x, k) => [x - reach(k), x + reach(k)]));
    }
    this.sliders.pose.show(numbers);
  }
}
