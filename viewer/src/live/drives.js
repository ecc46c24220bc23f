// Cranks and slides: where they bring a point of their body, and what is drawn of arm and rail
// (gspcli/geometry/machine.py, gspcli/pictures/arms.py).
import { turned } from "./rotations.js";
import { add, times } from "./vectors.js";

/** The number of a drive in radians or lengths, of what a slider says. */
export const numberOf = ({ factor, offset, unit }, reading) => (reading * factor + offset) * unit;

/** Half of what is drawn of a rail without a range, in sizes of the scene. */
const RAIL = 0.2;

/** The place of the point in the frame of its body, for a number in radians or lengths. */
export function pointAt({ sort, middle, across, beside }, q) {
  if (sort === "slide") return add(middle, times(q, beside));
  return add(middle, add(times(Math.cos(q), across), times(Math.sin(q), beside)));
}

/** The stroke of the arm from the axis to the point, or of the rail along the range. */
export function armAt(drive, q, { R, T }, size) {
  const { sort, middle, beside, body, range } = drive;
  const [low, high] = range ?? [-RAIL * size, RAIL * size];
  const points = sort === "slide"
    ? [low, high].map((x) => add(middle, times(x, beside)))
    : [middle, pointAt(drive, q)];
  const place = body === "platform" ? (p) => add(turned(R, p), T) : (p) => p;
  return { style: sort === "slide" ? "guide" : "perpendicular", points: points.map(place) };
}
