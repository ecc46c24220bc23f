// The axes of a body, with their names.
import { Color, Group, Vector3 } from "three";
import { arrowHead, flat, rods } from "./solids.js";

const AXES = [["x", "#c8503c"], ["y", "#3c8f50"], ["z", "#3c6fc8"]];
const SIZE = 0.25;

/** Add axes, which are not seen at first, to what they move with. */
export function buildFrame(home, origin, labels) {
  const frame = new Group();
  frame.position.copy(origin);
  AXES.forEach(([name, hex], k) => {
    const direction = new Vector3().setComponent(k, 1);
    const paint = flat(new Color(hex));
    const tip = direction.clone().multiplyScalar(SIZE);
    frame.add(rods([[new Vector3(), tip]], 0.005, paint), arrowHead(tip, direction, 0.05, paint));
    const beyond = direction.clone().multiplyScalar(SIZE * 1.12);
    labels.add(name, "axis", () => (frame.visible ? frame.localToWorld(beyond.clone()) : null), "beside");
  });
  frame.visible = false;
  home.add(frame);
  return frame;
}
