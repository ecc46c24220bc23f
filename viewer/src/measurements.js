// The text about the part under the pointer.
import { Vector3 } from "three";
import { coordinate, rounded, short, vector } from "./numbers.js";

const SORTS = { P: "point", L: "line", H: "plane" };

export function constraintText(scene, series, index, k) {
  const { number, kind, platform, base, value } = scene.constraints[k];
  const isAngle = kind.startsWith("A");
  const unit = isAngle ? scene.units.angle : scene.units.length;
  const measured = series.measured[index][k];
  const asked = series.parameter ? "" : `\nasked for: ${short(value)} ${unit}`;
  const small = rounded(isAngle, scene);
  return `Constraint ${number}: ${isAngle ? "angle" : "distance"} of ${platform} and ${base} (${kind})\n`
    + `measured: ${coordinate(measured, small)} ${unit}${asked}`;
}

export function elementText(scene, body, element, stage) {
  const sort = SORTS[element.primitive];
  const lines = [`${sort} ${element.name} of the ${body}`];
  const centre = element.outline
    .reduce((sum, p) => sum.add(new Vector3(...p)), new Vector3())
    .divideScalar(element.outline.length);
  const where = element.primitive === "P" ? "at" : "drawn about";
  if (body === "platform") {
    lines.push(`${where} ${vector(centre.toArray(), scene.size)} in the platform's frame`);
    const world = centre.clone().divideScalar(scene.size);
    stage.platform.group.localToWorld(world).multiplyScalar(scene.size).add(stage.middle);
    lines.push(`and ${vector(world.toArray(), scene.size)} in that of the base`);
  } else {
    lines.push(`${where} ${vector(centre.toArray(), scene.size)}`);
  }
  if (element.direction) {
    const name = element.primitive === "L" ? "direction" : "normal";
    lines.push(`${name} ${vector(element.direction)}${body === "platform" ? " in the platform's frame" : ""}`);
  }
  return lines.join("\n");
}
