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
import { WaysHome } from "./way_home.js";
import { accountSpoken, accountText, eventText, foldText, noModeText, wayText } from "./words.js";
import { approaching } from "./folds.js";
import { cueOf, forgetColours, modeColour, modePaint } from "./mode_colours.js";
import { explain, showMeanings } from "../terms.js";
import { printPicture } from "../printing.js";

const byId = (id) => document.getElementById(id);
const json = (id) => JSON.parse(byId(id).textContent);
const scene = json("scene");
const live = json("live");
const module = byId("module").textContent.trim();
/** Milliseconds of rest before the state is said aloud, and for which an event is shown. */
const SPOKEN = 700;
const EVENT = 6000;
/** Milliseconds of rest before a way home is looked for. */
const WAY = 200;
/** Which modes are drawn beside the followed one; of more than so many only the nearest at first. */
const OTHERS = ["none", "near", "all"];
const MANY = 16;

let stage = null;
let chosen = null;
let spoken = 0;
let forgotten = 0;
let looked = 0;

function notice(text) {
  byId("notice").textContent = text;
  byId("notice").hidden = !text;
}

function openStage() {
  try {
    return new LiveStage(byId("canvas"), byId("labels"), scene, { drives: live.drives, numbers: kernel.index }, modePaint);
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
  motion.sliders.values.choose(bond === null ? null : kernel.index[bond]);
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

/** Show the present state; `happened` is what the last move did, `isAnew` if it was no move. */
function show(happened = {}) {
  const { modes, ahead } = model;
  const mode = ahead ? ahead.mode : model.current;
  const values = ahead?.values ?? model.values;
  const fold = mode && !ahead ? approaching(mode, modes, scene.size) : null;
  const near = new Set(fold ? [mode.number, fold.other.number] : []);
  const shown = ahead ? [mode].filter(Boolean) : modes;
  scene.constraints.forEach((constraint, k) => {
    if (!live.drives[k]) constraint.value = values[kernel.index[k]];
  });
  list.show(shown, mode?.number ?? null, near);
  stage?.together(() => {
    stage.showModes(shown, mode, values, mode && kernel.measure(mode.R, mode.T, values));
    stage.fade(happened.met ?? []);
    recolour();
  });
  motion.show(values, mode);
  map.show(values);
  tell(mode, values, fold, happened);
  link.write();
}

function tell(mode, values, fold, happened) {
  const { account, kernel, ahead } = model;
  const said = ahead ? { kind: "busy", text: "solving …", more: "" } : accountText(account, kernel.isProof);
  say("status-text", said.text);
  say("status-more", said.more);
  byId("status-proof").hidden = !said.isProved;
  byId("status").className = said.kind;
  byId("busy").hidden = !ahead;
  say("modes-heading", `Assembly modes: ${account.real} real of ${account.expected}`);
  byId("followed").hidden = !mode;
  byId("no-mode").hidden = mode !== null;
  say("no-mode", mode ? "" : noModeText(account, ahead));
  if (mode) {
    byId("followed-chip").style.background = modeColour(mode.number);
    byId("followed-chip").dataset.cue = cueOf(mode.number);
    say("followed-name", `Mode ${mode.number}${mode.number === list.home ? ", home" : ""}`);
    const clearance = kernel.clearance(mode.R, mode.T, values);
    fillList(byId("pose"), [
      ...poseFacts(scene, Array.from(mode.T), mode.q, mode.condition < Infinity ? mode.condition : null),
      ["pose clearance", clearance > 0 ? `at least ${short(clearance, 3)} ${scene.units.length}` : "none proved"],
    ]);
  }
  lookForWay();
  const event = eventText(happened, words);
  if (event || happened.isAnew) {
    say("event", event);
    byId("event").title = event;
    clearTimeout(forgotten);
    forgotten = setTimeout(() => say("event", ""), EVENT);
  }
  say("warning", fold ? foldText(mode, fold, scene) : "");
  speak();
}

/** Write a text where it is another one: what stays the same is not laid out again. */
function say(id, text) {
  const part = byId(id);
  if (part.textContent !== text) part.textContent = text;
}

/** Which way leads home, beside the button: when it rests. */
function lookForWay() {
  clearTimeout(looked);
  looked = setTimeout(() => {
    if (model.ahead || motion.way) return;
    const found = ways.find();
    say("way-said", wayText(found, words));
    byId("way-said").dataset.kind = found?.kind ?? found?.reason ?? "";
    byId("way-home").disabled = !found?.rows;
  }, WAY);
}

/** What has changed, for those who listen: when it rests. */
function speak() {
  clearTimeout(spoken);
  spoken = setTimeout(() => {
    const { current, account, kernel } = model;
    const mode = current ? `mode ${current.number}, condition ${short(current.condition, 3)}` : "no mode is followed";
    const parts = [accountSpoken(account, kernel.isProof), mode, byId("event").textContent, byId("warning").textContent];
    byId("spoken").textContent = parts.filter(Boolean).join("; ");
  }, SPOKEN);
}

function follow(number) {
  if (model.ahead) return;
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

function others(which) {
  byId("others").value = which;
  stage.setOthers(which);
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
const names = live.names ?? scene.constraints.map(({ number, platform, base }) => `${number}: ${platform}–${base}`);
if (live.names) document.querySelector("input[name=moved][value=values] + span").textContent = "Motors";
const list = new ModeList(byId("mode-list"), scene.size, live.home, { paint: modeColour, onMode: follow });
const ways = new WaysHome(model, live.ways);
const words = {
  isMotors: Boolean(live.names), isLegs: live.kinds.every((kind) => kind === "DPP"),
  ranges: live.ways.within.some(Boolean), cones: live.ways.cones === null ? null : live.ways.cones.length > 0,
};
const motion = new Motion(model, ways, scene, live, worker, show);
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
  w: () => motion.goHome(),
  g: () => others(OTHERS[(OTHERS.indexOf(byId("others").value) + 1) % OTHERS.length]),
});
if (stage) {
  const canvas = byId("canvas");
  const shown = () => ({ series: stage.live, index: stage.index });
  namePartsUnder(canvas, byId("tooltip"), stage, scene, { shown, onBond: choose });
  followClicked(canvas);
  stage.resize();
  byId("others").addEventListener("change", (event) => others(event.target.value));
  others(scene.series[0].T.length > MANY ? "near" : "all");
  printPicture(stage, display);
}
showMeanings();
explain(document);
byId("home").addEventListener("click", () => motion.home());
byId("way-home").addEventListener("click", () => motion.goHome());
byId("reset").addEventListener("click", () => {
  motion.reset();
  stage?.look("reset");
});

const given = scene.series[0].T.map((T, k) => ({ T, R: rotation(scene.series[0].q[k]) }));
await motion.begin(given);
link.read();
document.documentElement.dataset.ready = "true";
