// Numbers as people read them.

export function short(value, digits = 6) {
  if (value === null || value === undefined) return "∞";
  if (typeof value !== "number") return String(value);
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e7 || size < 1e-4) return value.toExponential(Math.min(digits, 3) - 1).replace("-", "−").replace("e+", "e");
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

/** A coordinate: rounding errors beside `size` are zero. */
export function coordinate(value, size) {
  return short(Math.abs(value) < 1e-12 * size ? 0 : value);
}

/** Beside what measured numbers are rounding errors: angles of nearly parallel directions have fewer digits. */
export const rounded = (isAngle, { size }) => (isAngle ? 1e4 : size);

export function vector(values, size = 1) {
  return `(${values.map((v) => coordinate(v, size)).join(", ")})`;
}
