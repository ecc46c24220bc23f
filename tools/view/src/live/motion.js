// What moves the platform: sliders of values and of the pose, the map, the link; one move a frame.
import { poseOf } from "./link.js";
import { fromAngles, toAngles } from "./rotations.js";
import { Sliders } from "./sliders.js";

const byId = (id) => document.getElementById(id);
const POSE = ["x", "y", "z", "rx", "ry", "rz"];
/** How far sliders of the pose go to each side, in sizes of the scene and degrees. */
const SHIFT = 0.5;
const TURN = 45;

export class Motion {
  /** `show(happened)` shows the model after a move. */
  constructor(model, scene, live, worker, show) {
    Object.assign(this, { model, scene, live, worker, onShow: show });
    this.wanted = null;
    this.id = 0;
    const value = ({ number, platform, base, kind }, k) => ({
      name: String(number), title: `${platform}–${base}`, kind, unit: live.units[k], id: `value-${number}`,
    });
    const coordinate = (name, k) => ({
      name, title: "", kind: "", unit: k < 3 ? scene.units.length : "°", id: `pose-${name}`,
    });
    this.sliders = {
      values: new Sliders(byId("values"), scene.constraints.map(value), (values) => this.goTo(values)),
      pose: new Sliders(byId("coordinates"), POSE.map(coordinate), (numbers) => this.want({ numbers })),
    };
    this.sliders.values.use(live.ranges, live.limits);
    for (const input of document.querySelectorAll("input[name=moved]")) {
      input.addEventListener("change", () => this.turnTo(input.value));
    }
    worker.addEventListener("message", ({ data }) => data.solved && data.id === this.id && this.settle(data.solved));
  }

  /** Solve the values of the file and number the modes as `gsp solve` did. */
  async begin(given) {
    const { model } = this;
    const found = model.kernel.slow ? await this.solved(model.start.values) : model.kernel.solve(model.start.values);
    model.begin(found, given);
    this.onShow();
  }

  solved(values) {
    this.id += 1;
    const { id, worker } = this;
    return new Promise((resolve) => {
      const receive = ({ data }) => {
        if (!data.solved || data.id !== id) return;
        worker.removeEventListener("message", receive);
        resolve(data.solved);
      };
      worker.addEventListener("message", receive);
      worker.postMessage({ solve: { values, id } });
    });
  }

  goTo(values) {
    this.want({ values });
  }

  /** One move a frame, the last that was asked for. */
  want(target) {
    if (!this.wanted) requestAnimationFrame(() => this.move());
    this.wanted = target;
  }

  move() {
    const { model, wanted } = this;
    this.wanted = null;
    const pose = wanted.numbers && { T: wanted.numbers.slice(0, 3), R: fromAngles(wanted.numbers.slice(3)) };
    const values = pose ? Array.from(model.kernel.measure(pose.R, pose.T)) : wanted.values;
    this.pose = pose ? wanted.numbers : null;
    if (model.kernel.slow) this.goAhead(values, pose);
    else if (pose) this.onShow(model.goPose(pose, model.kernel.solve(values), values));
    else this.onShow(model.go(values, model.kernel.solve(values)));
  }

  /** The followed mode at once, the others when the worker has them. */
  goAhead(values, pose) {
    const { model } = this;
    model.goAhead(values, pose);
    this.onShow();
    clearTimeout(this.resting);
    this.resting = setTimeout(() => {
      this.id += 1;
      this.asked = { values, pose };
      this.worker.postMessage({ solve: { values, id: this.id } });
    }, 80);
  }

  settle(found) {
    if (!this.asked) return;
    const { values, pose } = this.asked;
    this.asked = null;
    this.onShow(this.model.catchUp(values, found, pose));
  }

  /** The values and the home mode of the file, numbered as at first. */
  home() {
    const { model } = this;
    model.begin(model.start.found, model.start.numbered);
    this.rebase();
    this.onShow();
  }

  /** The values of the file: where the present mode leads there. */
  reset() {
    this.goTo([...this.live.values]);
  }

  /** Go where a link leads: from the values of the file, along a straight line. */
  open({ values, mode, at }) {
    const { model } = this;
    model.begin(model.start.found, model.start.numbered);
    const isHome = values.every((x, i) => x === model.values[i]);
    const there = () => {
      if (at) model.name(poseOf(at), mode);
      else if (mode !== null) model.follow(mode);
      this.rebase();
      this.onShow();
    };
    if (isHome) there();
    else if (model.kernel.slow) {
      this.solved(values).then((found) => { model.go(values, found); there(); });
    } else {
      model.go(values, model.kernel.solve(values));
      there();
    }
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
    const numbers = this.pose ?? [...mode.T, ...toAngles(mode.R)];
    const reach = (k) => (k < 3 ? SHIFT * this.scene.size : TURN);
    if (!this.pose || !this.middle) {
      this.middle = numbers;
      this.sliders.pose.use(numbers.map((x, k) => [x - reach(k), x + reach(k)]));
    }
    this.sliders.pose.show(numbers);
  }
}
