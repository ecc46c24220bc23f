// A constraint: its strokes at the pose that is shown.
import { Group, Vector3 } from "three";
import { ball, flat, rodCapacity, setRods, solid } from "./solids.js";

const RADII = { leg: 0.006, perpendicular: 0.0065, arc: 0.006, ray: 0.0028, square: 0.0028, guide: 0.0028 };
const DASHED = new Set(["ray", "guide"]);
const DASH = 0.035;
const MOST_DASHES = 80;
/** The cylinder of a leg, from the base, and how much thicker it is than the rod. */
const CYLINDER = 0.5;
const THICKER = 1.75;

export class Bond {
  /** `thick` has the radii of the leg and of the arm of its crank where the file states their diameters, else 0. */
  constructor(constraint, size, colours) {
    const [leg, arm] = [constraint.diameter, constraint.arm].map((diameter) => (diameter ?? 0) / 2 / size);
    this.thick = { leg, arm };
    this.isLeg = constraint.kind === "DPP";
    this.isAngle = constraint.kind.startsWith("A");
    this.group = new Group();
    this.main = solid(colours.main);
    this.mark = flat(colours.mark);
    this.meshes = new Map();
    this.pickable = [];
  }

  /** Show the strokes of a series; their points come with `move`. */
  use(strokes, userData) {
    this.strokes = strokes;
    for (const mesh of this.meshes.values()) mesh.removeFromParent();
    this.meshes.clear();
    this.pickable.length = 0;
    strokes.forEach((stroke, k) => {
      const segments = stroke.style === "leg" ? 2 : pointsOf(stroke) - 1;
      const room = DASHED.has(stroke.style) ? MOST_DASHES : segments;
      const isMain = ["leg", "perpendicular", "arc"].includes(stroke.style);
      const mesh = rodCapacity(room, isMain ? this.main : this.mark);
      if (isMain) {
        mesh.userData = userData;
        this.pickable.push(mesh);
      }
      this.meshes.set(k, mesh);
      this.group.add(mesh);
      if (this.radius(stroke)) this.addEnds(k, this.radius(stroke), userData);
    });
  }

  /** The stated radius of a stroke, or 0: of a leg, or of the arm beside it, its only other solid line. */
  radius({ style }) {
    if (style === "leg") return this.thick.leg;
    return this.isLeg && style === "perpendicular" ? this.thick.arm : 0;
  }

  /** The round ends of a thick leg or arm. */
  addEnds(k, radius, userData) {
    for (const end of [0, 1]) {
      const mesh = ball(new Vector3(), radius, this.main);
      mesh.userData = userData;
      this.pickable.push(mesh);
      this.meshes.set(`${k} ${end}`, mesh);
      this.group.add(mesh);
    }
  }

  move(index, toScene) {
    this.strokes.forEach((stroke, k) => {
      const points = stroke.points[index].map(toScene);
      const radius = RADII[stroke.style];
      const mesh = this.meshes.get(k);
      const stated = this.radius(stroke);
      if (DASHED.has(stroke.style)) setRods(mesh, dashes(points[0], points[1]), radius);
      else if (stated) {
        setRods(mesh, [points], stated);
        points.forEach((point, end) => this.meshes.get(`${k} ${end}`).position.copy(point));
      } else if (stroke.style === "leg") setRods(mesh, telescope(points[0], points[1], radius), radius);
      else setRods(mesh, pairs(points), radius);
    });
  }

  recolour(main, mark) {
    this.main.color.copy(main);
    this.mark.color.copy(mark);
  }
}

/** How many points a stroke has at every pose: poses are numbered, but not always from 0. */
function pointsOf({ points }) {
  for (const k in points) return points[k].length;
  return 2;
}

function pairs(points) {
  return points.slice(1).map((b, k) => [points[k], b]);
}

function telescope(platform, base, radius) {
  const joint = base.clone().lerp(platform, CYLINDER);
  return [[base, joint, radius * THICKER], [joint, platform, radius]];
}

function dashes(a, b) {
  const length = a.distanceTo(b);
  if (length < 1e-6) return [];
  const count = Math.min(Math.max(Math.round(length / DASH / 2), 1), MOST_DASHES);
  const at = (t) => new Vector3().lerpVectors(a, b, t);
  return Array.from({ length: count }, (_, k) => [at(k / count), at((k + 0.55) / count)]);
}
