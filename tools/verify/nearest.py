"""Judge the nearest poses within the limits of eleven machines, and record it.

    python -m tools.verify.nearest [--count 400] [--jobs 2] [--check [--sample N]]

Random poses about home are asked for (`gspcli.NearestPoses`). Two checks are independent of gsp.
All answers must keep ranges and cones: the distances of joints and the tilts of legs are computed
again, with vectors only, and compared without tolerance, but for fixed values. Cranks and slides
are where circles and rails meet balls (`tools.verify.driven_machines`). And for up to 20 poses of
each machine, SciPy's SLSQP searches nearer poses from ten starts; one counts if a straight way to
it is proved, too. No answer of a machine with legs may be more than 1 % farther than such a pose;
of the others the record says how many are. The record is ``data/verification/nearest.csv``.
"""

from __future__ import annotations

import sys
from dataclasses import asdict, dataclass
from functools import partial

import numpy as np

import gspcli
from gspcli.defaults import SEED
from gspcli.geometry.drive_numbers import is_driven, shares_drives
from gspcli.geometry.primitives import Plane
from gspcli.geometry.quaternions import rotation_from_vector, vector_from_rotation
from gspcli.motion.paths.nearest_poses import FARTHER as NO_WAY
from gspcli.motion.paths.nearest_poses import NearestPoses
from tools.recording import ROOT, add_workers, csv_text, parser, sampled, workers_of
from tools.verify.campaigns import conclude
from tools.verify.driven_machines import Machine, PlaneGeometry, machines

RECORD = ROOT / "data" / "verification" / "nearest.csv"
#: Machines with legs, and examples with motors.
LEGS = ("rubin-camera", "rubin-m2", "three-rps", "workspace-study", "workspace-study-cones")
MOTORS = ("reachy-mini-head", "hexaglide", "delta")
#: Machines with motors of `tools.verify.driven_machines`.
MADE = ("t-top 60", "6-PUS", "paradex")
MACHINES = (*LEGS, *MOTORS, *MADE)
#: Standard deviations of the poses asked for, from home: radians, and parts of the typical length.
TURN, SHIFT = 0.4, 0.2
#: A machine with motors gets this many times fewer poses: a proof can take half a second.
FEWER = 20
#: This many poses of a machine are sought by SLSQP, from this many starts. An answer is at most
#: this many times as far.
COMPARED, STARTS, FARTHER = 20, 10, 1.01


@dataclass(frozen=True)
class Row:
    """What was found for one machine.

    Attributes
    ----------
    within, outside
        How many given poses are the answer, and how many answers violate a limit.
    short, stays
        How many answers are not the nearest pose that was found, because no straight way to it is
        proved; and how often no way at all is proved.
    compared, farther
        How many were sought by SLSQP, with a proved way, and how many answers are farther.
    """

    machine: str
    wanted: int
    within: int
    outside: int
    short: int
    stays: int
    compared: int
    farther: int


def examine(count: int, name: str) -> Row:
    """Seek the nearest poses for random ones about home."""
    machine = machine_of(name)
    instance = machine.instance
    nearest = NearestPoses(instance, machine.R, machine.T)
    count = count if name in LEGS else max(count // FEWER, 1)
    judge = PlaneGeometry(machine) if is_driven(instance) else None
    length = nearest.length
    rng = np.random.default_rng((SEED, *name.encode()))
    within = outside = short = stays = compared = farther = 0
    for k in range(count):
        R = rotation_from_vector(TURN * rng.normal(size=3)) @ nearest.R
        T = nearest.T + SHIFT * length * rng.normal(size=3)
        found = nearest.of(R, T)
        within += not found.limits and bool(found.way)
        stays += not found.way
        short += bool(found.way) and NO_WAY in found.limits
        if judge is None:
            outside += not kept(instance, found.R, found.T)
        else:
            outside += not judge.reached(found.R[None], found.T[None])[0]
        if k % max(1, count // COMPARED) == 0:
            best = by_slsqp(nearest, R, T, rng)
            compared += np.isfinite(best)
            turn = found.turn * instance.units.angle.in_radians
            farther += bool(np.hypot(found.shift, length * turn) > FARTHER * best)
    return Row(name, count, within, outside, short, stays, int(compared), farther)


def machine_of(name: str) -> Machine:
    """Return a machine with the pose where it is."""
    if name in MADE:
        return machines()[name]()
    instance = gspcli.example(name)
    home = gspcli.solve(instance).home
    if home is None:  # of rods that share a motor the stated pose is one of many
        stated = instance.home
        assert stated is not None
        return Machine(name, instance, stated.R(instance.units.angle.in_radians), stated.T, (0, 0))
    return Machine(name, instance, home.R.real, home.T.real, (0, 0))


def kept(instance: gspcli.Instance, R: np.ndarray, T: np.ndarray) -> bool:
    """Return whether all legs keep their ranges and cones, from vectors alone.

    Other distances are those of points and planes.
    """
    for row in instance.constraints:
        platform = R @ np.array([x.value for x in row.platform.position]) + T
        base = np.array([x.value for x in row.base.position])
        leg = platform - base
        if row.kind.name == "DPP":
            value = float(np.sqrt(leg @ leg))
        elif isinstance(row.base, Plane):
            value = float(leg @ row.base.unit)
        else:
            raise ValueError(row.kind.name)
        if row.limits is not None:
            low, high = (limit.value for limit in row.limits)
            value = abs(value) if row.side.value == "both" else value
            # A fixed value is met by the pose of the values, not by its doubles.
            room = 1e-9 * (1 + abs(low)) if low == high else 0.0
            if not low - room <= value <= high + room:
                return False
        for joint, direction, turn in ((row.base, leg, np.eye(3)), (row.platform, -leg, R)):
            cone = getattr(joint, "cone", None)
            if cone is None:
                continue
            half = cone.half_angle.value * instance.units.angle.in_radians
            if direction @ (turn @ cone.unit) < np.cos(half) * np.sqrt(leg @ leg):
                return False
    return True


def by_slsqp(
    nearest: NearestPoses, R: np.ndarray, T: np.ndarray, rng: np.random.Generator
) -> float:
    """Return the least distance that SLSQP finds from ten starts; infinite if it finds none."""
    from scipy.optimize import minimize

    length, best = nearest.length, np.inf
    here = np.concatenate((length * vector_from_rotation(nearest.R @ R.T), nearest.T - T))
    # Rods that share a motor are parallel at one orientation: only the position is sought then.
    free = slice(3, 6) if shares_drives(nearest.instance) else slice(0, 6)

    def pose(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        y = here.copy()
        y[free] = z
        kept = nearest.R if free.start else rotation_from_vector(y[:3] / length) @ R
        return kept, T + y[3:]

    limits = {"type": "ineq", "fun": lambda z: nearest.slack(*pose(z)) / length}
    for k in range(STARTS):
        start = here * (rng.random() if k else 1.0)
        start = start + (0.2 * length * rng.normal(size=6) if k > 1 else 0.0)
        found = minimize(
            lambda z: z @ z / length**2,
            start[free],
            jac=lambda z: 2 * z / length**2,
            constraints=limits,
            method="SLSQP",
            options={"maxiter": 200, "ftol": 1e-12},
        )
        there = here.copy()
        there[free] = found.x
        distance = float(np.linalg.norm(there))
        if distance < best and nearest.way(*pose(found.x)):
            best = distance
    return best


def main() -> int:
    """Judge, compare or write; return the exit code."""
    options = parser(__doc__, sample=True)
    options.add_argument("--count", type=int, default=400, help="wanted poses of each machine")
    add_workers(options)
    arguments = options.parse_args()
    chosen = sampled(MACHINES, arguments.sample if arguments.check else None)
    work = partial(examine, arguments.count)
    rows = list(workers_of(arguments).in_order(work, chosen))
    wrong = [f"{row.machine}: {row.outside} outside" for row in rows if row.outside]
    wrong += [
        f"{row.machine}: {row.farther} too far"
        for row in rows
        if row.farther and row.machine in LEGS
    ]
    total, stays, short, compared, farther = (
        sum(getattr(row, name) for row in rows)
        for name in ("wanted", "stays", "short", "compared", "farther")
    )
    summary = f"{total} wanted poses: all answers within the limits, {stays} without a way, "
    summary += f"{short} not up to the nearest pose; {farther} of {compared} are farther than "
    summary += f"{FARTHER} times the best of SLSQP"
    text = csv_text(list(map(asdict, rows)))
    return conclude(RECORD, text, wrong, summary, check=arguments.check)


if __name__ == "__main__":
    sys.exit(main())
