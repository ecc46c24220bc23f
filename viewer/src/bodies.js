// A body: its hull, and its points, lines and planes, in its own frame.
import { Group, Vector3 } from "three";
import { arrowHead, ball, flat, glass, plates, rods, sides, solid } from "./solids.js";

const POINT = 0.017;
const LINE = 0.006;
const EDGE = 0.0055;
const BORDER = 0.0028;
const NORMAL = 0.16;

/** How the part is named when it is pointed at; the numbers are added where they are known. */
export function buildBody(name, body, toScene, colours, shell = []) {
  const group = new Group();
  const skin = solid(colours.body);
  const thin = flat(colours.body);
  const pickable = [];
  const labels = [];
  const add = (mesh, element) => {
    mesh.userData = { body: name, element };
    group.add(mesh);
    pickable.push(mesh);
    return mesh;
  };

  const faces = body.faces.map((face) => face.map(toScene));
  const hull = glass(colours.body, name === "base" ? 0.16 : 0.3);
  const polygons = faces.filter((face) => face.length > 2);
  if (polygons.length) add(plates(polygons, hull), null).renderOrder = name === "base" ? 1 : 2;
  const edges = sides(faces);
  if (edges.length) group.add(rods(edges, EDGE, skin));

  // The outline that the file states.
  const skinOfShell = glass(colours.body, 0.3);
  if (shell.length) add(plates(shell.map((face) => face.map(toScene)), skinOfShell), null).renderOrder = 3;

  const sheet = glass(colours.body, 0.1);
  for (const element of body.elements) {
    const outline = element.outline.map(toScene);
    const centre = outline.reduce((sum, p) => sum.add(p), new Vector3()).divideScalar(outline.length);
    const direction = element.direction && new Vector3(...element.direction);
    let at = centre;
    if (element.primitive === "P") {
      add(ball(centre, POINT, skin), element);
    } else if (element.primitive === "L") {
      add(rods([[outline[0], outline[1]]], LINE, skin), element);
      group.add(arrowHead(outline[1].clone().addScaledVector(direction, 0.03), direction, 0.06, skin));
      at = outline[1];
    } else {
      add(plates([outline], sheet), element);
      group.add(rods(sides([outline]), BORDER, thin));
      const tip = centre.clone().addScaledVector(direction, NORMAL);
      group.add(rods([[centre, tip]], BORDER, thin), arrowHead(tip, direction, 0.05, thin));
      at = outline[2];
    }
    labels.push({ text: element.name, at, className: name });
  }
  return {
    group, pickable, labels,
    recolour(color) {
      for (const material of [skin, thin, hull, skinOfShell, sheet]) material.color.copy(color);
    },
  };
}

/** Dashes of an edge of a ghost, by its cue: how long they are, and what part of it is drawn. */
const DASHES = [null, { length: 0.06, drawn: 0.6 }, { length: 0.022, drawn: 0.5 }, { length: 0.14, drawn: 0.8 }];
const MOST_DASHES = 60;

/** The platform as a faint copy, one of so many, for showing all poses at a time; `cue` tells copies of one colour apart. */
export function buildGhost(body, toScene, color, count, cue = 0) {
  const group = new Group();
  const faces = body.faces.map((face) => face.map(toScene));
  const skin = glass(color, Math.min(0.12, 0.6 / count));
  const polygons = faces.filter((face) => face.length > 2);
  if (polygons.length) group.add(plates(polygons, skin));
  const lines = body.elements
    .filter((element) => element.primitive === "L")
    .map((element) => element.outline.map(toScene));
  const sheets = body.elements
    .filter((element) => element.primitive === "H")
    .map((element) => element.outline.map(toScene));
  const edge = glass(color, Math.min(0.5, 0.15 + 2 / count));
  const segments = [...sides([...faces, ...sheets]), ...lines].flatMap((edge) => dashed(edge, DASHES[cue]));
  if (segments.length) group.add(rods(segments, BORDER, edge));
  const materials = [skin, edge];
  const opacities = materials.map(({ opacity }) => opacity);
  group.userData.recolour = (c) => materials.forEach((material) => material.color.copy(c));
  group.userData.fade = (part) => materials.forEach((material, k) => (material.opacity = part * opacities[k]));
  return group;
}

/** An edge in dashes; whole without. */
function dashed([a, b], dashes) {
  if (!dashes) return [[a, b]];
  const count = Math.min(Math.max(Math.round(a.distanceTo(b) / dashes.length), 1), MOST_DASHES);
  const at = (t) => a.clone().lerp(b, t);
  return Array.from({ length: count }, (_, k) => [at(k / count), at((k + dashes.drawn) / count)]);
}
