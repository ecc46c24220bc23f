// Rods, balls, plates: the few solids of which everything is made, in units of the size of the scene.
import {
  BufferGeometry,
  ConeGeometry,
  CylinderGeometry,
  DoubleSide,
  Float32BufferAttribute,
  InstancedMesh,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  Quaternion,
  SphereGeometry,
  Vector3,
} from "three";

const ROD = new CylinderGeometry(1, 1, 1, 14, 1, false);
const BALL = new SphereGeometry(1, 24, 16);
const CONE = new ConeGeometry(1, 1, 18);
const UP = new Vector3(0, 1, 0);

export function solid(color) {
  return new MeshStandardMaterial({ color, roughness: 0.62, metalness: 0.05 });
}

export function flat(color) {
  return new MeshBasicMaterial({ color });
}

export function glass(color, opacity) {
  return new MeshStandardMaterial({
    color, opacity, transparent: true, side: DoubleSide, depthWrite: false, roughness: 0.9,
  });
}

export function ball(center, radius, material) {
  const mesh = new Mesh(BALL, material);
  mesh.position.copy(center);
  mesh.scale.setScalar(radius);
  return mesh;
}

const axis = new Vector3();
const turn = new Quaternion();
const middle = new Vector3();
const size = new Vector3();

/** The matrix that makes the unit rod one of a radius from a to b. */
export function rodMatrix(a, b, radius, target = new Matrix4()) {
  axis.subVectors(b, a);
  const length = axis.length();
  if (length < 1e-9) return target.makeScale(0, 0, 0).setPosition(a);
  turn.setFromUnitVectors(UP, axis.divideScalar(length));
  middle.addVectors(a, b).multiplyScalar(0.5);
  return target.compose(middle, turn, size.set(radius, length, radius));
}

export function rods(segments, radius, material) {
  const mesh = new InstancedMesh(ROD, material, Math.max(segments.length, 1));
  mesh.frustumCulled = false;
  setRods(mesh, segments, radius);
  return mesh;
}

const matrix = new Matrix4();

/** Put the rods of a mesh elsewhere; an error if there is no room for them. */
export function setRods(mesh, segments, radius) {
  if (segments.length > mesh.instanceMatrix.count) throw new Error(`${segments.length} rods in a mesh of ${mesh.instanceMatrix.count}`);
  segments.forEach(([a, b, r], k) => mesh.setMatrixAt(k, rodMatrix(a, b, r ?? radius, matrix)));
  mesh.count = segments.length;
  mesh.instanceMatrix.needsUpdate = true;
  mesh.boundingSphere = null;
}

export function rodCapacity(count, material) {
  const mesh = new InstancedMesh(ROD, material, count);
  mesh.frustumCulled = false;
  mesh.count = 0;
  return mesh;
}

export function arrowHead(tip, direction, length, material) {
  const mesh = new Mesh(CONE, material);
  mesh.quaternion.setFromUnitVectors(UP, direction);
  mesh.position.copy(tip).addScaledVector(direction, -length / 2);
  mesh.scale.set(length * 0.32, length, length * 0.32);
  return mesh;
}

/** Convex polygons as one surface. */
export function plates(polygons, material) {
  const positions = [];
  for (const corners of polygons) {
    for (let k = 1; k + 1 < corners.length; k += 1) {
      for (const corner of [corners[0], corners[k], corners[k + 1]]) positions.push(...corner);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
  geometry.computeVertexNormals();
  return new Mesh(geometry, material);
}

/** The sides of convex polygons, each once. */
export function sides(polygons) {
  const seen = new Map();
  for (const corners of polygons) {
    corners.forEach((a, k) => {
      const b = corners[(k + 1) % corners.length];
      seen.set([a.toArray().join(), b.toArray().join()].sort().join("|"), [a, b]);
    });
  }
  return [...seen.values()];
}
