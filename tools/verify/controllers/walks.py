"""Verify that a controller's step never changes the branch in silence, and record it.

    python -m tools.verify.controllers.walks [--steps 400000] [--jobs 2] [--work FOLDER]
        [--check [--sample N]]

The programs that `gsp export --to c` writes for the machines of ``data/platforms`` and for one
random platform each of `TYPES` types, all kinds among them, are compiled and walk: half of the
walks through the values of poses that move smoothly about home, half straight away in a random
direction of values, where most branches end in a fold. A step counts if the program says PROVED.
What must hold:

- the branch that the kernel follows with proof along the same rows (as `gsp track` does; of
  machines with cranks and slides as it follows moving coordinates, on fewer walks) has the same
  pose at each row;
- of machines with cranks and slides, at all rows of all walks: Newton's method in steps an eighth
  as long, without proofs and from the same pose, comes to the same pose wherever it converges
  quickly;
- at the last proved row of some walks the pose is one of all real poses that `gsp solve` finds.

``different`` and ``unsolved`` count what does not hold, and the exit code is then 1. ``beyond`` are
proved steps that the judge did not reach. ``refused`` are the steps that the program refused
although the judge followed the branch to their end. The record is
``data/verification/controllers.csv``.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import gspcli
from gspcli.catalogue.types import all_types, type_by_number
from gspcli.defaults import SEED
from gspcli.errors import INTERRUPTED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import coordinates
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_quaternion, rotation_from_vector
from gspcli.geometry.readings import values_of
from gspcli.motion import MovingPlatform
from gspcli.motion.following.row_instances import at_values
from gspcli.solver.instances.generate import random_instance
from tools.recording import ROOT, csv_text, sampled
from tools.verify.campaigns import TaskRow, conclude, options, results
from tools.verify.controllers.compiled import CompiledController, Walks, poses_of

Array = NDArray[np.float64]
RECORD = ROOT / "data" / "verification" / "controllers.csv"
PLATFORMS = ROOT / "data" / "platforms"
TYPES = 50
#: Rows of a walk, and the size of a step in the values of poses: radians, and parts of the size.
ROWS, STEP = 101, 0.01
#: How far poses move from home.
FAR = 0.3
#: Poses of a branch are the same if they differ by less, as R and as T by the size.
SAME = 1e-6
#: Of how many walks the last row is solved completely, and of how many a crank's are judged.
SOLVED, CRANKED = 3, 4
#: Into how many parts a row is divided where Newton's method judges.
SHORT = 8


@dataclass
class Row(TaskRow):
    """What happened to the walks of one platform."""

    name: str
    kinds: str
    walks: int = 0
    steps: int = 0
    proved: int = 0
    judged: int = 0
    different: int = 0
    beyond: int = 0
    singular: int = 0
    tries_spent: int = 0
    out_of_range: int = 0
    refused: int = 0
    solved: int = 0
    unsolved: int = 0

    @property
    def problems(self) -> int:
        """How much does not hold."""
        return self.different + self.unsolved


def names() -> list[str]:
    """Return the machines, and the numbers of types evenly spread."""
    machines = sorted(p.stem for p in PLATFORMS.glob("*.yaml"))
    count = len(list(all_types()))
    return machines + [str(1 + k * (count - 1) // (TYPES - 1)) for k in range(TYPES)]


def platform(
    name: str, rng: np.random.Generator, home: float | None = None
) -> tuple[Instance, tuple[Array, Array]]:
    """Return the platform of a name and a pose of it, parallel at a height if one is given."""
    if name.isdigit():
        return random_instance(type_by_number(int(name)), rng)
    instance = gspcli.load(PLATFORMS / f"{name}.yaml")
    if home is not None:
        return instance, (np.eye(3), np.array([0.0, 0.0, home]))
    mode = gspcli.solve(instance).home
    assert mode is not None
    return instance, (mode.R, mode.T)


def examine(steps: int, name: str) -> Row:
    """Walk with the platform of a name."""
    rng = np.random.default_rng((SEED, *name.encode()))
    instance, (R, T) = platform(name, rng)
    kinds = " ".join(row.kind.name for row in instance.constraints)
    row = Row(name, kinds)
    with tempfile.TemporaryDirectory() as folder:
        program = CompiledController(instance, Path(folder))
    walks = max(2, steps // (ROWS - 1))
    values, start = walk_values(instance, program, R, T, walks, rng)
    if not np.ptp(values, axis=1).any():
        # A coupling of struts that are all of one length.
        return row
    found = program.follow(start, values)
    _count(row, found)
    if _motors(instance):
        _judge_motors(row, instance, values, found)
        _judge_closely(row, instance, values, found)
    else:
        _judge(row, instance, values, found)
        _solve(row, instance, values, found)
    return row


def _motors(instance: Instance) -> list[str]:
    """Return the names of the cranks and slides."""
    return [one.name for one in coordinates(instance) if one.is_drive]


def walk_values(
    instance: Instance,
    program: CompiledController,
    R: Array,
    T: Array,
    walks: int,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """Return the values of walks, shape (n, r, 6), and the poses where they begin, shape (n, 7)."""
    size = max(
        float(np.abs(row.value.value)) for row in instance.constraints if row.kind.is_distance
    )
    size = max(size, float(np.linalg.norm(T)))
    weights = rng.normal(size=(walks, 3, 6)) / 2
    s = np.arange(ROWS) * STEP / FAR
    waves = np.stack([np.sin(s), 1 - np.cos(s), np.sin(2 * s) / 2], axis=0)
    twists = FAR * np.einsum("nwk,wr->nrk", weights, waves)
    rotations = rotation_from_vector(twists[..., :3]) @ R
    places = T + size * twists[..., 3:]
    poses = poses_of(rotations, places)
    values = np.empty((walks, ROWS, 6))
    near = None
    for k in range(ROWS):
        values[:, k], status = program.inverse(poses[:, k], near)
        near = values[:, k]
        # Where a crank does not reach the walk stays.
        stuck = status != 0
        values[stuck, k] = values[stuck, max(k - 1, 0)]
    away = slice(None, None, 2)
    pace = np.linalg.norm(np.diff(values, axis=1), axis=2).mean()
    direction = rng.normal(size=(len(values[away]), 1, 6))
    direction *= pace / np.linalg.norm(direction, axis=2, keepdims=True)
    values[away] = values[away, :1] + np.arange(ROWS)[:, None] * direction
    return _in_ranges(instance, values), poses[:, 0]


def _in_ranges(instance: Instance, values: Array) -> Array:
    """Return walks that go at most twice as far as ranges; struts of one length keep it.

    Values of cranks and slides are no values of constraints.
    """
    if _motors(instance):
        return values
    changes = values - values[:, :1]
    for k, row in enumerate(instance.constraints):
        if row.limits is None:
            continue
        low, high = (limit.value for limit in row.limits)
        if low == high:
            changes[..., k] = 0
            continue
        far = np.abs(changes[..., k]).max(axis=1)
        room = np.maximum(high - values[:, 0, k], values[:, 0, k] - low)
        part = np.minimum(1, 2 * room / np.where(far > 0, far, 1))
        changes *= np.where(far > 0, part, 1)[:, None, None]
    return values[:, :1] + changes


def _count(row: Row, found: Walks) -> None:
    status = found.status[:, 1:]
    row.walks = len(status)
    row.steps = int((status >= 0).sum())
    row.proved = int((status == 0).sum())
    row.out_of_range = int((status == 2).sum())
    row.singular = int((status == 3).sum())
    row.tries_spent = int((status == 4).sum())


def _judge(row: Row, instance: Instance, values: Array, found: Walks) -> None:
    """Compare with the branches that the kernel follows with proof along the same rows."""
    platform, size = MovingPlatform(instance), Arrangement.of(instance).length
    R = rotation_from_quaternion(found.poses[:, 0, 3:])
    starts = platform.points(R, found.poses[:, 0, :3])
    branches = platform.follow(platform.internal(values), np.arange(len(values)), starts)
    R, T = platform.poses(branches.points)
    for walk, reached in enumerate(branches.reached):
        proved = int((found.status[walk, 1:] == 0).sum())
        both = min(proved, int(reached))
        here = slice(1, both + 1)
        _compare(row, size, found.poses[walk, here], R[walk, here], T[walk, here])
        row.beyond += proved - both
        refused = proved + 1 < ROWS and found.status[walk, proved + 1] in (3, 4)
        row.refused += int(refused and reached > proved)


def _compare(row: Row, size: float, poses: Array, R: Array, T: Array) -> None:
    turned = np.abs(rotation_from_quaternion(poses[:, 3:]) - R).max(axis=(1, 2), initial=0)
    moved = np.linalg.norm(poses[:, :3] - T, axis=1)
    row.judged += len(poses)
    row.different += int(((turned > SAME) | (moved > SAME * size)).sum())


def _judge_closely(row: Row, instance: Instance, values: Array, found: Walks) -> None:
    """Compare all walks with Newton's method in short steps, where it is certain of itself."""
    drives, size = Drives.of(instance), Arrangement.of(instance).length
    q = drives.from_readings(values)
    rods = np.where(drives.driven, drives.rods, np.nan)
    R = rotation_from_quaternion(found.poses[:, 0, 3:])
    T = found.poses[:, 0, :3].copy()
    alive = np.ones(len(values), bool)
    for k in range(1, ROWS):
        alive &= found.status[:, k] == 0
        for part in np.arange(1, SHORT + 1) / SHORT:
            here = np.flatnonzero(alive)
            now = q[here, k - 1] + part * (q[here, k] - q[here, k - 1])
            length = np.where(drives.driven, rods, now[:, drives.index])
            first = np.array([])
            for attempt in range(6):
                _, _, r = drives.ends(R[here], T[here], now)
                off = np.linalg.norm(r, axis=-1) - length
                J = drives.jacobian(R[here], T[here], now)
                twist = np.linalg.solve(J, -off[..., None])[..., 0]
                R[here] = rotation_from_vector(twist[:, :3]) @ R[here]
                T[here] += twist[:, 3:]
                moved = np.abs(twist * np.repeat([1, 1 / size], 3)).max(axis=1)
                first = first if attempt else moved
            # A long first step, or one that does not converge, is not certain of its branch.
            alive[here[~((first < 0.02) & (moved < 1e-12))]] = False
        here = np.flatnonzero(alive)
        poses = found.poses[here, k]
        turned = np.abs(rotation_from_quaternion(poses[:, 3:]) - R[here]).max(axis=(1, 2))
        away = np.linalg.norm(poses[:, :3] - T[here], axis=1)
        row.judged += len(here)
        row.different += int(((turned > SAME) | (away > SAME * size)).sum())


def _judge_motors(row: Row, instance: Instance, values: Array, found: Walks) -> None:
    """Compare some walks with branches along which the cranks and slides move."""
    rods = np.array([one.value.value for one in instance.constraints])
    for walk in range(0, min(2 * CRANKED, len(values))):
        proved = int((found.status[walk, 1:] == 0).sum())
        if not proved:
            continue
        moving = dict(zip(_motors(instance), values[walk, : proved + 1].T, strict=True))
        start = found.poses[walk, 0]
        rows = np.tile(rods, (proved + 1, 1))
        near = rotation_from_quaternion(start[3:]), start[:3]
        track = gspcli.track(instance, rows, coordinates=moving, near=near)
        reached = int((~np.isnan(track.T[0, 1:, 0])).sum())
        _compare(
            row,
            Arrangement.of(instance).length,
            found.poses[walk, 1 : reached + 1],
            track.R[0, 1 : reached + 1],
            track.T[0, 1 : reached + 1],
        )
        row.beyond += proved - reached


def _solve(row: Row, instance: Instance, values: Array, found: Walks) -> None:
    """Look for the last poses of some walks among all that their values have."""
    for walk in range(min(SOLVED, len(values))):
        proved = int((found.status[walk, 1:] == 0).sum())
        at = at_values(instance, values_of(instance, values[walk, proved]))
        result = gspcli.solve(at)
        if result.verdict != "complete":
            continue
        pose = found.poses[walk, proved]
        R, size = rotation_from_quaternion(pose[3:]), Arrangement.of(instance).length
        near = [
            np.abs(one.R.real - R).max() < SAME
            and np.linalg.norm(one.T.real - pose[:3]) < SAME * size
            for one in result.real_solutions
        ]
        row.solved += 1
        row.unsolved += int(sum(near) != 1)


def main() -> int:
    """Write the record, or check it."""
    line = options(__doc__)
    line.add_argument("--steps", type=int, default=400_000, help="about so many for each platform")
    arguments = line.parse_args()
    chosen = sampled(names(), arguments.sample) if arguments.check else names()
    rows = results(
        chosen,
        partial(examine, arguments.steps),
        Row.of_entry,
        arguments,
        name=f"controllers-{arguments.steps}",
        label="walks",
    )
    wrong = [f"{row.name}: {row.problems} problems" for row in rows if row.problems]
    text = csv_text([asdict(row) for row in rows])
    proved = sum(row.proved for row in rows)
    summary = f"{proved} proved steps of {len(rows)} platforms, no silent change of branch"
    return conclude(RECORD, text, wrong, summary, check=arguments.check)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
