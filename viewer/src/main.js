// The page of `gsp view`: reads the scene in the page and lets people look at it.
import { Chart } from "./chart.js";
import { Display } from "./display.js";
import { short } from "./numbers.js";
import { Panel } from "./panel.js";
import { printPicture } from "./printing.js";
import { namePartsUnder } from "./pointer.js";
import { Stage } from "./stage.js";
import { explain, showMeanings } from "./terms.js";
import { conditionScale, rampCss } from "./theme.js";

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

byId("previous").addEventListener("click", () => { play(false); go(state.index - 1); });
byId("next").addEventListener("click", () => { play(false); go(state.index + 1); });
byId("play").addEventListener("click", () => play(!state.playing));
byId("slider").addEventListener("input", (event) => { play(false); go(Number(event.target.value) - 1); });
byId("series").addEventListener("change", (event) => { play(false); go(0, Number(event.target.value)); });
byId("colour").addEventListener("change", recolour);
byId("legend-ramp").style.background = rampCss;

if (scene.series.length > 1) {
  byId("series-choice").hidden = false;
  scene.series.forEach(({ title, T }, k) => byId("series").add(new Option(`${title} (${T.length})`, String(k))));
}
const display = new Display(stage, scene, {
  recolour,
  words: () => `${scene.title} ${byId("where").textContent}`,
});
if (stage) {
  const shown = () => ({ series: series(), index: state.index });
  namePartsUnder(byId("canvas"), byId("tooltip"), stage, scene, { shown, onBond: choose });
  printPicture(stage, display);
}
showMeanings();
explain(document);
display.listen({
  ArrowLeft: () => { play(false); go(state.index - 1); },
  ArrowRight: () => { play(false); go(state.index + 1); },
  " ": () => play(!state.playing),
  c: () => {
    byId("colour").value = byId("colour").value === "part" ? "condition" : "part";
    recolour();
  },
});

useSeries();
stage?.resize();
if (!series().T.length) notice("There is no real pose: only the base is shown.");
go(state.index);
