// Ways home from many poses as live pages find them, for tests: JSON in, JSON out.
//
//     node viewer/ways.mjs < {"module": base64, "live": {...}, "size": number, "start": index,
//       "modes": [[12 numbers], ...], "poses": [[12 numbers], ...]}
import { readFileSync } from "node:fs";
import { openKernel, unpacked } from "./src/live/kernel.js";
import { Model } from "./src/live/model.js";
import { WaysHome } from "./src/live/way_home.js";

const { module, live, size, start, modes, poses } = JSON.parse(readFileSync(0, "utf-8"));
const pose = (x) => ({ R: Float64Array.from(x.slice(0, 9)), T: x.slice(9) });
const kernel = await openKernel(await unpacked(module), live);
const model = new Model(kernel, size, live.values, start + 1);
const solved = kernel.solve(live.values);
const ways = new WaysHome(model, live.ways);
const began = performance.now();
const found = poses.map((x) => {
  model.begin(solved, modes.map(pose));
  const { R, T } = pose(x);
  model.values = kernel.measure(R, T, live.values);
  if (model.values === null) return { reason: "unreached" };
  model.modes = [model.mode(1, { R, T }, true)];
  model.followed = 1;
  const { rows, ...said } = ways.find();
  return { ...said, rows: rows?.map((row) => [...row.R, ...row.T, ...row.values]) };
});
process.stdout.write(JSON.stringify({ found, milliseconds: (performance.now() - began) / poses.length }));
