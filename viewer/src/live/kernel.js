// The kernel in WebAssembly (viewer/module/): all poses of a platform for other values, what poses
// measure, proved steps. The same in the page, in its worker and in Node.

/** A module from base64, compressed. */
export async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function doubles(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}

/** A unit quaternion, scalar first, of a rotation by rows. */
export function quaternion(R) {
  const squares = [
    1 + R[0] + R[4] + R[8],
    1 + R[0] - R[4] - R[8],
    1 - R[0] + R[4] - R[8],
    1 - R[0] - R[4] + R[8],
  ];
  const k = squares.indexOf(Math.max(...squares));
  const rows = [
    [squares[0], R[7] - R[5], R[2] - R[6], R[3] - R[1]],
    [R[7] - R[5], squares[1], R[1] + R[3], R[2] + R[6]],
    [R[2] - R[6], R[1] + R[3], squares[2], R[5] + R[7]],
    [R[3] - R[1], R[2] + R[6], R[5] + R[7], squares[3]],
  ];
  const size = Math.hypot(...rows[k]);
  return rows[k].map((x) => x / size);
}

/** A rotation by rows of a quaternion. */
export function rotation([w, x, y, z]) {
  return Float64Array.of(
    w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y),
    2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x),
    2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z,
  );
}

/** Kinds of values that are numbers of motors which move points. */
const MOTORS = new Set(["crank", "slide"]);
/** Rods of one motor ask for the same number up to this. */
const TOGETHER = 1e-6;

// A value of the file from that of a pose, or the other way; of both sides of a plane the present one.
function onSide(value, side, present) {
  if (side === null) return value;
  return side === 0 ? value * (Math.sign(present) || 1) : value * side;
}

class Kernel {
  constructor(exports, live) {
    this.exports = exports;
    this.sides = live.sides;
    this.limits = live.limits;
    // Of each constraint the value, or the number of the motor that moves its point; these may share one.
    this.index = live.index ?? live.values.map((_, i) => i);
    this.counts = live.counts;
    this.stated = live.stated;
    this.still = live.values;
    this.moving = live.kinds.flatMap((kind, i) => (MOTORS.has(kind) ? [i] : []));
    this.isProof = live.proof !== null;
    const numbers = doubles(live.numbers);
    const at = exports.gsp_room(numbers.length);
    new Float64Array(exports.memory.buffer, at, numbers.length).set(numbers);
    exports.gsp_open();
    this.expected = exports.gsp_expected();
    this.at = exports.gsp_exchange();
  }

  // Memory may have grown: views are made when they are needed.
  exchange() {
    return new Float64Array(this.exports.memory.buffer, this.at, 64);
  }

  /** Begin at a pose; of the two numbers of a motor that lead there, with the nearer one to these values. */
  start(R, T, values) {
    this.exchange().set([...T, ...quaternion(R), ...this.each(values)]);
    return this.exports.gsp_start();
  }

  /** One number a constraint. */
  each(values) {
    return this.index.map((i) => values[i]);
  }

  /** How many poses there can be: fewer where some motors stand as in the file. */
  most(values) {
    if (!this.counts) return this.expected;
    return this.counts[this.moving.reduce((sum, i, k) => sum + (values[i] === this.still[i] ? 0 : 2 ** k), 0)];
  }

  /** Whether poses can have these values: distances are not negative, angles end. */
  isPossible(values) {
    return values.every((x, i) => {
      const [low, high] = this.limits[i];
      return Number.isFinite(x) && (low === null || x >= low) && (high === null || x <= high);
    });
  }

  /** All real poses for six values. */
  solve(values) {
    // Beyond their ends the equations and the error of a sine are of other values.
    const expected = this.most(values);
    if (!this.isPossible(values)) {
      return { complete: false, isPossible: false, expected, proved: 0, poses: [] };
    }
    this.exchange().set(this.each(values));
    const real = this.exports.gsp_solve(expected);
    const [proved, complete] = this.exchange();
    const at = this.exports.gsp_poses();
    const numbers = new Float64Array(this.exports.memory.buffer, at, 12 * real).slice();
    const poses = Array.from({ length: real }, (_, k) => ({
      R: numbers.subarray(12 * k, 12 * k + 9),
      T: numbers.subarray(12 * k + 9, 12 * k + 12),
      proved: true,
    }));
    // For the numbers of the file gsp solve has proved how many there are.
    const { stated } = this;
    if (stated && poses.length === stated.real && values.every((x, i) => x === this.still[i])) {
      return { complete: true, isPossible: true, expected: stated.poses, proved: stated.poses, poses };
    }
    return { complete: complete > 0 && this.isProof, isPossible: true, expected, proved, poses };
  }

  /**
   * The values of a pose, of motors near some values; null if a rod does not reach it, or if one motor
   * would have to be at two places.
   */
  measure(R, T, near) {
    const status = this.start(R, T, near);
    if (status && this.moving.length) return null;
    const found = this.exchange().slice(0, 6);
    const values = near.map((_, i) => {
      const x = found[this.index.indexOf(i)];
      return onSide(x, this.sides[i], x);
    });
    const isOne = this.index.every((i, k) => !this.moving.includes(i) || Math.abs(found[k] - values[i]) < TOGETHER);
    return isOne ? values : null;
  }

  /** Largest by smallest singular value of the Jacobian matrix, as gsp solve has it. */
  condition(R, T, values) {
    return this.start(R, T, values) ? Infinity : this.exports.gsp_condition();
  }

  /** The sign of det J, which no regular way changes: 1 or -1, 0 if it is not certain. */
  sign(R, T, values) {
    return this.start(R, T, values) ? 0 : this.exports.gsp_sign();
  }

  /** So far the nearest singular pose is at least, as gsp clearance measures it; 0 if unknown. */
  clearance(R, T, values) {
    return this.start(R, T, values) ? 0 : this.exports.gsp_clearance();
  }

  /** Where a pose is for other values, if that is proved (status 0). */
  follow(R, T, from, to) {
    if (this.start(R, T, from)) return { status: 3, R, T };
    // Distances to planes keep their side.
    const here = this.exchange().slice(0, 6);
    this.exchange().set(this.index.map((i, k) => onSide(to[i], this.sides[i], here[k])));
    const status = this.exports.gsp_forward();
    const found = this.exchange();
    return { status, R: rotation(found.slice(3, 7)), T: found.slice(0, 3) };
  }
}

/** The kernel for the platform of a page. */
export async function openKernel(module, live) {
  const { instance } = await WebAssembly.instantiate(module, {
    wasi_snapshot_preview1: { proc_exit() {} },
    env: { emscripten_notify_memory_growth() {} },
  });
  instance.exports._initialize?.();
  return new Kernel(instance.exports, live);
}
