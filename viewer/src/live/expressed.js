// Poses as the file and the command express them: of the tool in the work frame, or relative to home.
import { turned, turnedBack } from "./rotations.js";

const columns = (R) => [0, 1, 2].map((k) => [R[k], R[k + 3], R[k + 6]]);
const rowsOf = (parts) => Float64Array.from([0, 1, 2].flatMap((k) => parts.map((column) => column[k])));

/** Frames A in the base and B in the platform: a pose P is expressed as A⁻¹ P B. */
export class Expressed {
  constructor({ base, platform }) {
    Object.assign(this, { base, platform });
  }

  /** How a pose of the platform is expressed. */
  from({ R, T }) {
    const { base, platform } = this;
    const at = turned(R, platform.T).map((x, k) => x + T[k] - base.T[k]);
    const turn = columns(platform.R).map((column) => turnedBack(base.R, turned(R, column)));
    return { R: rowsOf(turn), T: turnedBack(base.R, at) };
  }

  /** The pose of the platform that is expressed so. */
  to({ R, T }) {
    const { base, platform } = this;
    // The columns of B⁻¹ are the rows of B.
    const rows = [0, 3, 6].map((k) => platform.R.slice(k, k + 3));
    const turn = rowsOf(rows.map((row) => turned(base.R, turned(R, row))));
    const tool = turned(turn, platform.T);
    return { R: turn, T: turned(base.R, T).map((x, k) => x + base.T[k] - tool[k]) };
  }
}
