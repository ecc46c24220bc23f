"""Judge nearest poses that controllers go to, and record it.

    python -m tools.verify.controllers.nearest [--count 20000] [--jobs 2] [--check [--sample N]]

`gsp export --to c` writes the programs of five machines, which are compiled and asked for random
poses about home, each from home. All that follows is computed with vectors and plane geometry, not
with the formulas of gsp:

- all answers keep ranges, cones and the knees of motors, without tolerance;
- where one line of values leads to the answer, Newton's method in 16 steps along it ends at the
  same pose, and the sign of the determinant stays. With a different end or sign the line is
  followed again in 1024 steps. ``dead_points`` counts lines on which a motor passes its dead point
  and comes back;
- where several lines do, the sign of the determinant is that of home.

SciPy's SLSQP searches nearer poses from ten starts for some requests, as `tools.verify.nearest`
does. ``farther`` counts answers of one line that are more than 1 % farther than a pose to which
`gspcli.NearestPoses` proves a straight way. The record is
``data/verification/nearest-requests.csv``.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gspcli.defaults import SEED
from gspcli.geometry.primitives import Crank
from gspcli.geometry.quaternions import rotation_from_vector, vector_from_rotation
from gspcli.motion.paths.nearest_poses import NearestPoses
from tools.recording import ROOT, add_workers, csv_text, parser, sampled, workers_of
from tools.verify.campaigns import conclude
from tools.verify.controllers.compiled import CompiledController, Requests, poses_of, rotations_of
from tools.verify.driven_machines import Equations, Machine, PlaneGeometry
from tools.verify.nearest import FARTHER, SHIFT, TURN, by_slsqp, kept, machine_of

RECORD = ROOT / "data" / "verification" / "nearest-requests.csv"
MACHINES = ("rubin-camera", "workspace-study-cones", "reachy-mini-head", "hexaglide", "t-top 60")
#: Steps of Newton's method along a line, and if these are too long.
STEPS, FINER = 16, 1024
#: The ends of a line are the same, in radians and parts of the length.
SAME = 1e-6
#: Requests that SLSQP looks at.
COMPARED = 3


@dataclass(frozen=True)
class Row:
    """The results of the requests to one machine.

    Attributes
    ----------
    one_line, several, stays
        To how many answers one proved line leads, or several do; how often there is none.
    outside
        How many answers violate a limit.
    singular, dead_points
        How many lines are not found to be regular or end elsewhere; on how many a motor passes its
        dead point and comes back.
    compared, farther
        How many were sought by SLSQP, and how many answers of one line are farther.
    """

    machine: str
    requests: int
    one_line: int
    several: int
    stays: int
    outside: int
    singular: int
    dead_points: int
    compared: int
    farther: int


def examine(count: int, name: str) -> Row:
    """Ask for random poses about home, and judge the answers."""
    machine = machine_of(name)
    instance, home = machine.instance, poses_of(machine.R, machine.T)
    nearest = NearestPoses(instance, machine.R, machine.T)
    rng = np.random.default_rng((SEED, *name.encode()))
    R = rotation_from_vector(TURN * rng.normal(size=(count, 3))) @ machine.R
    T = machine.T + SHIFT * nearest.length * rng.normal(size=(count, 3))
    with tempfile.TemporaryDirectory() as folder:
        program = CompiledController(instance, Path(folder))
        asked = program.nearest(home, poses_of(R, T))
        start, _ = program.inverse(home[None])
    found_R, found_T = rotations_of(asked.poses)
    within = PlaneGeometry(machine).reached(found_R, found_T)
    if any(
        getattr(x, "cone", None) for row in instance.constraints for x in (row.platform, row.base)
    ):
        within &= [kept(instance, *pose) for pose in zip(found_R, found_T, strict=True)]
    regular, passing = _ways(machine, asked, asked.values - start)
    compared = farther = 0
    for k in range(0, count, max(1, count // COMPARED)):
        best = by_slsqp(nearest, R[k], T[k], rng)
        if not np.isfinite(best) or asked.lines[k] != 1:
            continue
        turn = nearest.length * np.linalg.norm(vector_from_rotation(found_R[k] @ R[k].T))
        compared += 1
        farther += bool(np.hypot(np.linalg.norm(found_T[k] - T[k]), turn) > FARTHER * best)
    stays, one_line, several = (int((asked.lines == k).sum()) for k in range(3))
    return Row(
        name,
        count,
        one_line,
        several,
        stays,
        int((~within).sum()),
        int((~regular).sum()),
        passing,
        compared,
        farther,
    )


def _ways(
    machine: Machine, asked: Requests, turned: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], int]:
    """Return which ways are regular, shape (n,), and how many pass dead points.

    Of the angles `turned` only whole turns count.
    """
    equations, geometry = Equations(machine), PlaneGeometry(machine)
    R, T = rotations_of(asked.poses)
    begin = geometry.numbers(machine.R[None], machine.T[None])[0]
    change = geometry.numbers(R, T) - begin
    for k in range(6):
        if isinstance(geometry.drive(k)[0], Crank):
            turns = (geometry.unit * turned[:, k] - change[:, k]) / (2 * np.pi)
            change[:, k] += 2 * np.pi * np.round(turns)
    home = equations.side(machine.R[None], machine.T[None], begin[None])
    good = equations.side(R, T, begin + change) == home
    left = np.flatnonzero(asked.lines == 1)
    passing = 0
    for steps, gains in ((STEPS, True), (FINER, False)):
        last = equations.followed(machine.R, machine.T, begin, change[left], steps)
        off = np.abs(last.R - R[left]).max(axis=(1, 2), initial=0)
        far = np.abs(last.T - T[left]).max(axis=1, initial=0) / np.abs(equations.rods).max()
        signs = last.regular & last.knees if gains else last.regular
        good[left] = signs & (off < SAME) & (far < SAME)
        passing = int(good[left].sum()) if not gains else 0
        left = left[~good[left]]
    return good, passing


def main() -> int:
    """Judge, compare or write; return the exit code."""
    options = parser(__doc__, sample=True)
    options.add_argument("--count", type=int, default=20_000, help="requests to each machine")
    add_workers(options)
    arguments = options.parse_args()
    chosen = sampled(MACHINES, arguments.sample if arguments.check else None)
    rows = list(workers_of(arguments).in_order(partial(examine, arguments.count), chosen))
    wrong = [f"{row.machine}: {row.outside} outside" for row in rows if row.outside]
    wrong += [f"{row.machine}: {row.singular} singular" for row in rows if row.singular]
    requests, one, several, stays, passing, compared, farther = (
        sum(getattr(row, name) for row in rows)
        for name in (
            *("requests", "one_line", "several", "stays"),
            *("dead_points", "compared", "farther"),
        )
    )
    summary = f"{requests} requests: all answers within the limits; one line to {one}, several to "
    summary += f"{several}, none to {stays}; {passing} lines pass dead points; {farther} of "
    summary += f"{compared} are farther than {FARTHER} times the best of SLSQP"
    return conclude(
        RECORD, csv_text(list(map(asdict, rows))), wrong, summary, check=arguments.check
    )


if __name__ == "__main__":
    sys.exit(main())
