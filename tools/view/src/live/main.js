// The page of `gsp view --live`: solves the platform again while one moves values or the pose.
import { Display } from "../display.js";
import { fillList, poseFacts } from "../facts.js";
import { short } from "../numbers.js";
import { namePartsUnder } from "../pointer.js";
import { openKernel, rotation, unpacked } from "./kernel.js";
import { Link } from "./link.js";
import { LiveStage } from "./live_stage.js";
import { ModeMap } from "./map.js";
import { ModeList } from "./mode_list.js";
import { Model } from "./model.js";
import { Motion } from "./motion.js";
import { accountText, eventText, foldText } from "./words.js";
import { approaching } from "./folds.js";
import { forgetColours, modeColour, modePaint } from "./mode_colours.js";

const byId = (id) => document.getElementById(id);
const json = (id) => JSON.parse(byId(id).textContent);
const scene = json("scene");
const live = json("live");
const module = byId("module").textContent.trim();
/** Milliseconds of rest before the state is said aloud, and for which an event is shown. */
const SPOKEN = 700;
const EVENT = 6000;

let stage = null;
let chosen = null;
let spoken = 0;
let forgotten = 0;

function notice(text) {
  byId("notice").textContent = text;
  byId("notice").hidden = !text;
}

function openStage() {
  try {
    return new LiveStage(byId("canvas"), byId("labels"), scene, modePaint);
  } catch (error) {
    notice(`The picture needs WebGL, which this browser does not offer. All numbers are in the list. (${error.message})`);
    return null;
  }
}

function openWorker() {
  const source = new Blob([byId("worker").textContent], { type: "text/javascript" });
  const worker = new Worker(URL.createObjectURL(source));
  worker.postMessage({ open: { module, live } });
  return worker;
}

function choose(bond) {
  if (bond === chosen) return;
  chosen = bond;
  motion.sliders.values.choose(bond);
  recolour();
}

function recolour() {
  stage?.recolour((k) => (k in stage.live.numbers ? modePaint(stage.live.numbers[k]) : null), chosen);
}

/** After another theme. */
function repaint() {
  forgetColours();
  list.repaint();
  map.paint();
  recolour();
}

/** Show the present state; `happened` is what the last move did. */
function show(happened = {}) {
  const { modes, ahead } = model;
  const mode = ahead ? ahead.mode : model.current;
  const values = ahead?.values ?? model.values;
  const fold = mode && !ahead ? approaching(mode, modes, scene.size) : null;
  const near = new Set(fold ? [mode.number, fold.other.number] : []);
  const shown = ahead ? [mode].filter(Boolean) : modes;
  scene.constraints.forEach((constraint, k) => (constraint.value = values[k]));
  list.show(shown, mode?.number ?? null, near);
  stage?.together(() => {
    stage.showModes(shown, mode, mode && model.kernel.measure(mode.R, mode.T));
    stage.fade(happened.met ?? []);
    recolour();
  });
  motion.show(values, mode);
  map.show(values);
  tell(mode, fold, happened);
  link.write();
}

function tell(mode, fold, happened) {
  const { account, kernel, ahead } = model;
  const said = ahead ? { kind: "busy", text: "solving …" } : accountText(account, kernel.isProof);
  byId("status").textContent = said.text;
  byId("status").className = said.kind;
  byId("busy").hidden = !ahead;
  byId("modes-heading").textContent = `Assembly modes: ${account.real} real of ${account.expected}`;
  byId("followed").hidden = !mode;
  byId("no-mode").hidden = mode !== null;
  byId("no-mode").textContent = ahead ? "The followed mode could not be followed all the way." : account.real ? "No mode is followed. Choose one in the list." : "There is no real pose for these values.";
  if (mode) {
    byId("followed-chip").style.background = modeColour(mode.number);
    byId("followed-name").textContent = `Mode ${mode.number}`;
    const clearance = kernel.clearance?.(mode.R, mode.T);
    fillList(byId("pose"), [
      ...poseFacts(scene, Array.from(mode.T), mode.q, mode.condition < Infinity ? mode.condition : null),
      ...(clearance === undefined ? [] : [["clearance", clearance > 0 ? `at least ${short(clearance, 3)} ${scene.units.length}` : "none proved"]]),
    ]);
  }
  const event = eventText(happened);
  if (event) {
    byId("event").textContent = byId("event").title = event;
    clearTimeout(forgotten);
    forgotten = setTimeout(() => (byId("event").textContent = ""), EVENT);
  }
  byId("warning").textContent = fold ? foldText(mode, fold, scene) : "";
  speak();
}

/** What has changed, for those who listen: when it rests. */
function speak() {
  clearTimeout(spoken);
  spoken = setTimeout(() => {
    const { current, account, kernel } = model;
    const mode = current ? `mode ${current.number}, condition ${short(current.condition, 3)}` : "no mode is followed";
    const parts = [accountText(account, kernel.isProof).text, mode, byId("event").textContent, byId("warning").textContent];
    byId("spoken").textContent = parts.filter(Boolean).join("; ");
  }, SPOKEN);
}

function follow(number) {
  model.follow(number);
  motion.rebase();
  show();
}

function beside(step) {
  const { modes } = model;
  if (!modes.length) return;
  const k = modes.findIndex(({ number }) => number === model.followed);
  follow(modes[(k + step + modes.length) % modes.length].number);
}

/** A click, not a drag, on a ghost follows it. */
function followClicked(canvas) {
  let down = null;
  canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
  canvas.addEventListener("pointerup", (event) => {
    if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
    const number = stage.modeUnder(event.clientX, event.clientY);
    if (number !== null) follow(number);
  });
}

const kernel = await openKernel(await unpacked(module), live);
const model = new Model(kernel, scene.size, live.values, scene.start + 1);
stage = openStage();
const worker = openWorker();
const names = scene.constraints.map(({ number, platform, base }) => `${number}: ${platform}–${base}`);
const list = new ModeList(byId("mode-list"), scene.size, { paint: modeColour, onMode: follow });
const motion = new Motion(model, scene, live, worker, show);
const map = new ModeMap(worker, live, names, (values) => motion.goTo(values));
const link = new Link(model, map, { onState: (state) => motion.open(state) });
map.onChoose = () => link.write();
// A small picture has no room for names at first.
scene.names &&= window.innerWidth > 700;
const display = new Display(stage, scene, {
  recolour: repaint,
  words: () => `${scene.title} mode ${model.followed} at ${model.values.map((x) => short(x, 4)).join(" ")}`,
});
display.listen({
  ArrowLeft: () => beside(-1),
  ArrowRight: () => beside(1),
  h: () => motion.home(),
});
if (stage) {
  const canvas = byId("canvas");
  const shown = () => ({ series: stage.live, index: stage.index });
  namePartsUnder(canvas, byId("tooltip"), stage, scene, { shown, onBond: choose });
  followClicked(canvas);
  stage.resize();
}
byId("home").addEventListener("click", () => motion.home());
byId("reset").addEventListener("click", () => {
  motion.reset();
  stage?.look("reset");
});

const given = scene.series[0].T.map((T, k) => ({ T, R: rotation(scene.series[0].q[k]) }));
await motion.begin(given);
link.read();
document.documentElement.dataset.ready = "true";
