// How it is shown: views, names, frames, all poses, light or dark, a picture to keep; and the keys for it.
import { isDark, onSystemTheme, setTheme } from "./theme.js";

const byId = (id) => document.getElementById(id);
const TURNS = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };

export class Display {
  /** `recolour` paints again; `words` gives what a picture is of. The stage is null without WebGL. */
  constructor(stage, scene, { recolour, words }) {
    Object.assign(this, { stage, recolour, words });
    byId("theme").addEventListener("change", (event) => this.theme(event.target.value));
    onSystemTheme(recolour);
    if (!stage) {
      byId("display").hidden = true;
      return;
    }
    byId("names").addEventListener("change", (event) => stage.setNames(event.target.checked));
    byId("ghosts")?.addEventListener("change", (event) => stage.setGhosts(event.target.checked));
    byId("frames").addEventListener("change", (event) => stage.setFrames(event.target.checked));
    byId("save").addEventListener("click", () => this.save());
    for (const button of document.querySelectorAll("[data-view]")) {
      button.addEventListener("click", () => stage.look(button.dataset.view));
    }
    stage.setGhosts(byId("ghosts")?.checked ?? true);
    byId("names").checked = scene.names;
    stage.setNames(scene.names);
    new ResizeObserver(() => stage.resize()).observe(byId("canvas"));
  }

  theme(name) {
    setTheme(name);
    byId("theme").value = name;
    this.recolour();
  }

  async save() {
    const picture = await this.stage.picture();
    const link = document.createElement("a");
    link.href = URL.createObjectURL(picture);
    link.download = `${this.words().toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "")}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  /** What keys do, on both pages. */
  keys() {
    const { stage } = this;
    return {
      Home: () => stage?.look("reset"),
      t: () => stage?.look("top"),
      f: () => stage?.look("front"),
      r: () => stage?.look("side"),
      n: () => toggle("names"),
      g: () => toggle("ghosts"),
      a: () => toggle("frames"),
      d: () => this.theme(isDark() ? "light" : "dark"),
      s: () => stage && this.save(),
      "+": () => stage?.turn(0, 0, 1.15),
      "=": () => stage?.turn(0, 0, 1.15),
      "-": () => stage?.turn(0, 0, 1 / 1.15),
    };
  }

  /** Obey keys, those of `more` too, where no control uses them itself. */
  listen(more) {
    const actions = { ...this.keys(), ...more };
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
      if (isUsed(event)) return;
      const turn = event.shiftKey && TURNS[event.key];
      const action = turn
        ? () => this.stage?.turn(...turn)
        : actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
      if (!action) return;
      action();
      event.preventDefault();
    });
  }
}

/** Whether a control keeps the key. */
function isUsed({ target, key }) {
  if (target instanceof HTMLSelectElement) return true;
  if (target instanceof HTMLInputElement) {
    if (["range", "number", "text", "radio"].includes(target.type) || key === " ") return true;
  }
  return key === " " && target instanceof HTMLElement && target.closest("button, summary") !== null;
}

function toggle(id) {
  byId(id).checked = !byId(id).checked;
  byId(id).dispatchEvent(new Event("change"));
}
