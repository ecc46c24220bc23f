// Beside the page: counts real modes for a map, and solves what takes longer than a frame.
import { openKernel, unpacked } from "./kernel.js";
import { squares } from "./map_order.js";

/** Milliseconds between looking for other work, and between reports. */
const SLICE = 12;
let opened = null;
let kernel = null;
let job = null;

self.onmessage = async ({ data }) => {
  if (data.open) {
    opened = unpacked(data.open.module).then((module) => openKernel(module, data.open.live));
    return;
  }
  kernel = await opened;
  if (data.solve) {
    const began = performance.now();
    const solved = kernel.solve(data.solve.values);
    self.postMessage({ solved, id: data.solve.id, milliseconds: performance.now() - began });
  } else {
    const isFresh = job === null;
    job = { ...data.map, squares: squares(data.map.cells, data.map.coarse) };
    if (isFresh) fill();
  }
};

/** Fill the map a little, and come again. */
function fill() {
  const done = [];
  const end = performance.now() + SLICE;
  let next = job.squares.next();
  while (!next.done) {
    const [column, row, side] = next.value;
    const found = kernel.solve(at(job, column + 0.5, row + 0.5));
    done.push(column, row, side, found.complete ? found.poses.length : -1);
    if (performance.now() > end) break;
    next = job.squares.next();
  }
  self.postMessage({ id: job.id, squares: done, filled: next.done === true });
  if (next.done) job = null;
  else setTimeout(fill, 0);
}

/** The values at a place of the map, in cells from its lower left corner. */
function at({ values, which, ranges, cells }, column, row) {
  const [x, y] = [column, row].map((k, n) => {
    const [low, high] = ranges[which[n]];
    return low + ((high - low) * k) / cells;
  });
  const there = [...values];
  there[which[0]] = x;
  there[which[1]] = y;
  return there;
}
