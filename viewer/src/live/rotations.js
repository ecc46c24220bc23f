// Rotations by rows: as three angles about the axes x, y, z of the base, one after the other; distances.

const DEGREE = Math.PI / 180;

/** The rotation by rx, then ry, then rz, in degrees (`--euler xyz`). */
export function fromAngles([rx, ry, rz]) {
  const [a, b, c] = [rx, ry, rz].map((x) => x * DEGREE);
  const [ca, sa, cb, sb, cc, sc] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b), Math.cos(c), Math.sin(c)];
  return Float64Array.of(
    cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa,
    sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa,
    -sb, cb * sa, cb * ca,
  );
}

/** The angles of a rotation, in degrees; where two of them turn about one axis, rx is 0. */
export function toAngles(R) {
  const sine = Math.min(Math.max(-R[6], -1), 1);
  const locked = Math.hypot(R[7], R[8]) < 1e-9;
  const angles = locked
    ? [0, Math.asin(sine), Math.atan2(-R[1], R[4])]
    : [Math.atan2(R[7], R[8]), Math.asin(sine), Math.atan2(R[3], R[0])];
  return angles.map((x) => x / DEGREE);
}

/** R times v, and from the base back. */
export function turned(R, v) {
  return [0, 3, 6].map((k) => R[k] * v[0] + R[k + 1] * v[1] + R[k + 2] * v[2]);
}

export function turnedBack(R, v) {
  return [0, 1, 2].map((k) => R[k] * v[0] + R[k + 3] * v[1] + R[k + 6] * v[2]);
}

/** The angle between two rotations, in radians. */
export function angleBetween(A, B) {
  let square = 0;
  for (let k = 0; k < 9; k += 1) square += (A[k] - B[k]) ** 2;
  return 2 * Math.asin(Math.min(1, Math.sqrt(square / 8)));
}

/** How far a pose is from another: shift in parts of a length, and angle, as one number. */
export function distance(a, b, length) {
  const shift = Math.hypot(a.T[0] - b.T[0], a.T[1] - b.T[1], a.T[2] - b.T[2]) / length;
  return Math.hypot(shift, angleBetween(a.R, b.R));
}
