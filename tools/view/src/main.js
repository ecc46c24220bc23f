// The page of `gsp view`: reads the scene in the page and lets people look at it.
import { Chart } from "./chart.js";
import { constraintText, elementText } from "./measurements.js";
import { short } from "./numbers.js";
import { Panel } from "./panel.js";
import { Stage } from "./stage.js";
import { conditionScale, isDark, onSystemTheme, rampCss, setTheme } from "./theme.js";

const byId = (id) => document.getElementById(id);
const scene = JSON.parse(byId("scene").textContent);
const MODE_SECONDS = 1.4;
const MOTION_SECONDS = 10;

const state = { series: scene.first, index: scene.start, playing: false, chosen: null };
const series = () => scene.series[state.series];
let stage = null;
const scales = scene.series.map((each) => conditionScale(each.condition));

const panel = new Panel(scene, {
  onMode: (k) => go(k, 0),
  onBond: (k) => choose(k),
});
panel.colourModes(scales[0]);
const chart = new Chart(byId("chart"), (k) => go(k));

try {
  stage = new Stage(byId("canvas"), byId("labels"), scene);
} catch (error) {
  notice(`The picture needs WebGL, which this browser does not offer. All numbers are in the list. (${error.message})`);
}

function notice(text) {
  byId("notice").textContent = text;
  byId("notice").hidden = false;
}

/** Show a pose, of another series if given; the index goes round. */
function go(index, which = state.series) {
  const changed = which !== state.series;
  state.series = which;
  const count = series().T.length;
  state.index = count ? ((index % count) + count) % count : 0;
  if (changed) useSeries();
  show();
}

function useSeries() {
  const { title, note, T } = series();
  byId("series").value = String(state.series);
  byId("series-note").textContent = note;
  byId("slider").max = String(Math.max(T.length, 1));
  byId("slider").setAttribute("aria-label", title);
  chart.use(series());
  byId("player").hidden = T.length < 2;
  const scale = scales[state.series];
  byId("legend-low").textContent = short(scale.low, 3);
  byId("legend-high").textContent = short(scale.high, 3);
}

function show() {
  const { T, item, parameter } = series();
  byId("slider").value = String(state.index + 1);
  const at = parameter ? `${parameter.name} ${short(parameter.values[state.index], 5)}` : `${item} ${state.index + 1} of ${T.length}`;
  byId("where").textContent = at;
  byId("slider").setAttribute("aria-valuetext", at);
  chart.move(state.index);
  panel.show(series(), state.index);
  stage?.show(series(), state.index);
  recolour();
}

function recolour() {
  const byCondition = byId("colour").value === "condition";
  byId("legend").hidden = !byCondition;
  const scale = scales[state.series];
  stage?.recolour((k) => (byCondition && k < series().T.length ? scale.colour(series().condition[k]) : null), state.chosen);
}

function choose(bond) {
  if (bond === state.chosen) return;
  state.chosen = bond;
  panel.choose(bond);
  recolour();
}

// Playing: modes one by one, motions in some seconds.
let started = 0;
let startedAt = 0;

function play(on) {
  state.playing = on && series().T.length > 1;
  byId("play").setAttribute("aria-pressed", String(state.playing));
  byId("play").setAttribute("aria-label", state.playing ? "pause" : "play");
  if (!state.playing) return;
  started = performance.now();
  startedAt = state.index;
  requestAnimationFrame(step);
}

function step(now) {
  if (!state.playing) return;
  const count = series().T.length;
  const rate = series().parameter ? count / MOTION_SECONDS : 1 / MODE_SECONDS;
  const index = (startedAt + Math.floor(((now - started) / 1000) * rate)) % count;
  if (index !== state.index) go(index);
  requestAnimationFrame(step);
}

async function save() {
  const picture = await stage.picture();
  const link = document.createElement("a");
  link.href = URL.createObjectURL(picture);
  const words = `${scene.title} ${byId("where").textContent}`.toLowerCase();
  link.download = `${words.replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "")}.png`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function theme(name) {
  setTheme(name);
  byId("theme").value = name;
  recolour();
}

function toggle(id) {
  byId(id).checked = !byId(id).checked;
  byId(id).dispatchEvent(new Event("change"));
}

byId("previous").addEventListener("click", () => { play(false); go(state.index - 1); });
byId("next").addEventListener("click", () => { play(false); go(state.index + 1); });
byId("play").addEventListener("click", () => play(!state.playing));
byId("slider").addEventListener("input", (event) => { play(false); go(Number(event.target.value) - 1); });
byId("series").addEventListener("change", (event) => { play(false); go(0, Number(event.target.value)); });
byId("colour").addEventListener("change", recolour);
byId("theme").addEventListener("change", (event) => theme(event.target.value));
byId("legend-ramp").style.background = rampCss;
onSystemTheme(recolour);

if (scene.series.length > 1) {
  byId("series-choice").hidden = false;
  scene.series.forEach(({ title, T }, k) => byId("series").add(new Option(`${title} (${T.length})`, String(k))));
}
if (stage) {
  byId("names").addEventListener("change", (event) => stage.setNames(event.target.checked));
  byId("ghosts").addEventListener("change", (event) => stage.setGhosts(event.target.checked));
  byId("frames").addEventListener("change", (event) => stage.setFrames(event.target.checked));
  byId("save").addEventListener("click", save);
  for (const button of document.querySelectorAll("[data-view]")) {
    button.addEventListener("click", () => stage.look(button.dataset.view));
  }
  stage.setGhosts(false);
  byId("names").checked = scene.names;
  stage.setNames(scene.names);
  new ResizeObserver(() => stage.resize()).observe(byId("canvas"));
} else {
  byId("display").hidden = true;
}

// The pointer: what it is on is named, and its constraint marked.
const tooltip = byId("tooltip");
let pending = null;

function point(event) {
  pending = event.buttons && event.pointerType === "mouse" ? null : event;
  if (!pending) tooltip.hidden = true;
  else requestAnimationFrame(measure);
}

function measure() {
  if (!pending) return;
  const { clientX, clientY } = pending;
  pending = null;
  const part = stage.under(clientX, clientY);
  const isBond = part && part.bond !== undefined;
  choose(isBond ? part.bond : null);
  const text = isBond
    ? constraintText(scene, series(), state.index, part.bond)
    : part?.element && elementText(scene, part.body, part.element, stage);
  tooltip.hidden = !text;
  if (!text) return;
  tooltip.textContent = text;
  const home = byId("canvas").getBoundingClientRect();
  const box = tooltip.getBoundingClientRect();
  const x = Math.max(4, Math.min(clientX - home.left + 14, home.width - box.width - 4));
  const y = clientY - home.top + 16 + box.height > home.height ? clientY - home.top - box.height - 12 : clientY - home.top + 16;
  tooltip.style.transform = `translate(${x}px, ${y}px)`;
}

if (stage) {
  byId("canvas").addEventListener("pointermove", point);
  byId("canvas").addEventListener("pointerdown", point);
  byId("canvas").addEventListener("pointerleave", () => { tooltip.hidden = true; choose(null); });
}

const KEYS = {
  ArrowLeft: () => { play(false); go(state.index - 1); },
  ArrowRight: () => { play(false); go(state.index + 1); },
  " ": () => play(!state.playing),
  Home: () => stage?.look("reset"),
  t: () => stage?.look("top"),
  f: () => stage?.look("front"),
  r: () => stage?.look("side"),
  n: () => toggle("names"),
  g: () => toggle("ghosts"),
  a: () => toggle("frames"),
  c: () => {
    byId("colour").value = byId("colour").value === "part" ? "condition" : "part";
    recolour();
  },
  d: () => theme(isDark() ? "light" : "dark"),
  s: () => stage && save(),
  "+": () => stage?.turn(0, 0, 1.15),
  "=": () => stage?.turn(0, 0, 1.15),
  "-": () => stage?.turn(0, 0, 1 / 1.15),
};
const TURNS = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const { target } = event;
  // Controls keep the keys that they use themselves.
  if (target instanceof HTMLSelectElement) return;
  if (target instanceof HTMLInputElement && (target.type === "range" || event.key === " ")) return;
  if (event.key === " " && target instanceof HTMLElement && target.closest("button, summary")) return;
  if (event.shiftKey && event.key in TURNS) {
    stage?.turn(...TURNS[event.key]);
    event.preventDefault();
    return;
  }
  const action = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (action) {
    action();
    event.preventDefault();
  }
});

useSeries();
stage?.resize();
if (!series().T.length) notice("There is no real pose: only the base is shown.");
go(state.index);
