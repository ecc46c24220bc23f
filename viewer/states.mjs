// All poses for many sets of values by the kernel of live pages, for tests: JSON in, JSON out.
//
//     node viewer/states.mjs < {"module": base64, "live": {...}, "states": [[6 values], ...]}
import { readFileSync } from "node:fs";
import { openKernel, unpacked } from "./src/live/kernel.js";

const { module, live, states } = JSON.parse(readFileSync(0, "utf-8"));
const kernel = await openKernel(await unpacked(module), live);
const begin = performance.now();
const found = states.map((values) => {
  const { complete, proved, poses } = kernel.solve(values);
  return { complete, proved, poses: poses.map(({ R, T }) => [...R, ...T]) };
});
const milliseconds = (performance.now() - begin) / states.length;
const measured = found.map(({ poses }, k) =>
  poses.map((x) => {
    const given = [x.slice(0, 9), x.slice(9), states[k]];
    return [
      ...(kernel.measure(...given) ?? states[k].map(() => null)),
      Math.min(kernel.condition(...given), 1e300),
      kernel.clearance(...given),
    ];
  }),
);
process.stdout.write(JSON.stringify({ found, measured, milliseconds }));
