// Vectors as plain arrays.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const times = (s, a) => [s * a[0], s * a[1], s * a[2]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const norm = (a) => Math.hypot(...a);
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const middle = (points) => times(1 / points.length, points.reduce(add));
export const unit = (a, otherwise) => (norm(a) > 1e-9 ? times(1 / norm(a), a) : otherwise);

/** A unit vector at right angles to another: horizontal, unless that one is vertical. */
export const perpendicular = (a) => unit([-a[1], a[0], 0], [1, 0, 0]);
