"""Verify that a controller's step never changes the branch in silence, and record it.

    python -m tools.verify.controllers.walks [NAME ...] [--steps 400000] [--jobs 2] [--work FOLDER]
        [--check [--sample N]]

`gsp export --to c` writes programs for the machines of ``data/platforms``, for two more with rails
and arms (`RAILS`), and for one random platform each of `TYPES` types, all kinds among them. They
are compiled and run. Half of the walks go through the values of poses that move smoothly about
home. The others go straight in a random direction of values, where most branches end in a fold. A
step counts if the program says PROVED. What must hold:

- the branch that the kernel follows with proof along the same rows, as `gsp track` does, has the
  same pose at each row. Of machines with cranks and slides it follows moving coordinates, on fewer
  walks;
- of machines with cranks and slides, at all rows of all walks, Newton's method reaches the same
  pose wherever it converges quickly, in steps an eighth as long, without proofs and from the same
  pose. Each rod is on the same knee there, and the inverse kinematics of the program returns the
  numbers of the drives;
- at the last proved row of some walks the pose is one of all real poses that `gsp solve` finds.

``different`` and ``unsolved`` count what does not hold, and the exit code is then 1. ``beyond`` are
proved steps that the judge did not reach. ``refused`` are the steps that the program refused
although the judge followed the branch to their end. The record is
``data/verification/controllers.csv``; with names only their rows are renewed.
"""

from __future__ import annotations

import csv
import tempfile
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import gspcli
from gspcli.catalogue.types import all_types, type_by_number
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import coordinates
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Geometry, Point
from gspcli.geometry.quaternions import rotation_from_quaternion, rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.geometry.readings import values_of
from gspcli.motion import MovingPlatform
from gspcli.motion.following.row_instances import at_values
from tools.recording import ROOT, csv_text, sampled
from tools.verify.campaigns import TaskRow, conclude, exit_after, options, results
from tools.verify.controllers.compiled import CompiledController, Walks, poses_of
from tools.verify.driven_machines import machines, upside_down

Array = NDArray[np.float64]
RECORD = ROOT / "data" / "verification" / "controllers.csv"
PLATFORMS = ROOT / "data" / "platforms"
TYPES = 50
#: Machines with cranks and slides beside those of ``data/platforms``, without their ranges.
RAILS = ("6-PUS", "6-PUS inverted", "mixed")
#: Those whose straight walks are longer.
LONG = RAILS[1:]
#: Rows of a walk, and the size of a step in the values of poses: radians, and parts of the size.
ROWS, STEP = 101, 0.01
#: How much longer the straight steps of some machines are: their folds are farther away.
LONGER = 4
#: How often the motions of walks are tried by half where cranks or slides do not reach.
HALVINGS = 6
#: How far poses move from home.
FAR = 0.3
#: Poses of a branch are the same if they differ by less, as R and as T by the size.
SAME = 1e-6
#: Of how many walks the last row is solved completely, and of how many a crank's are judged.
SOLVED, CRANKED = 3, 4
#: Below this transmission a drive is at a dead point: two knees are one there.
DEAD = 1e-5
#: Of Newton's method: corrections below this part of the size are rounding.
CONVERGED = 1e-12
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
    shipped = sorted(p.stem for p in PLATFORMS.glob("*.yaml"))
    count = len(list(all_types()))
    return [*shipped, *RAILS] + [str(1 + k * (count - 1) // (TYPES - 1)) for k in range(TYPES)]


def platform(
    name: str, rng: np.random.Generator, home: float | None = None
) -> tuple[Instance, tuple[Array, Array]]:
    """Return the platform of a name and a pose of it, parallel at a height if one is given."""
    if name.isdigit():
        return random_instance(type_by_number(int(name)), rng)
    if name in RAILS:
        made = machines()[name.removesuffix(" inverted")]()
        instance = _unlimited(made.instance)
        if name.endswith("inverted"):
            return _inverted(instance), (made.R.T, -made.R.T @ made.T)
        return instance, (made.R, made.T)
    instance = gspcli.load(PLATFORMS / f"{name}.yaml")
    if home is not None:
        return instance, (np.eye(3), np.array([0.0, 0.0, home]))
    mode = gspcli.solve(instance).home
    assert mode is not None
    return instance, (mode.R, mode.T)


def _unlimited(instance: Instance) -> Instance:
    """Return a machine without ranges, so that its walks come to folds and dead points."""

    def free(point: Geometry) -> Geometry:
        if not isinstance(point, Point):
            return point
        if point.crank is not None:
            return replace(point, crank=replace(point.crank, limits=None))
        if point.slide is not None:
            return replace(point, slide=replace(point.slide, limits=None))
        return point

    rows = [
        replace(row, platform=free(row.platform), base=free(row.base), limits=None)
        for row in instance.constraints
    ]
    return replace(instance, constraints=tuple(rows))


def _inverted(instance: Instance) -> Instance:
    """Return a machine of distances of points whose base is the platform."""
    return replace(instance, constraints=upside_down(instance), home=None)


def examine(steps: int, name: str) -> Row:
    """Walk with the platform of a name."""
    rng = np.random.default_rng((SEED, *name.encode()))
    instance, (R, T) = platform(name, rng)
    kinds = " ".join(row.kind.name for row in instance.constraints)
    row = Row(name, kinds)
    with tempfile.TemporaryDirectory() as folder:
        program = CompiledController(instance, Path(folder))
    walks = max(2, steps // (ROWS - 1))
    values, start = walk_values(instance, program, R, T, walks, rng, longer=name in LONG)
    if not np.ptp(values, axis=1).any():
        # A coupling of struts that are all of one length.
        return row
    found = program.follow(start, values)
    _count(row, found)
    if _motors(instance):
        _judge_motors(row, instance, values, found)
        _judge_closely(row, instance, program, values, found)
    else:
        _judge(row, instance, values, found)
        _solve(row, instance, values, found)
    return row


def _motors(instance: Instance) -> list[str]:
    """Return the names of the cranks and slides."""
    return [one.name for one in coordinates(instance)]


def walk_values(
    instance: Instance,
    program: CompiledController,
    R: Array,
    T: Array,
    walks: int,
    rng: np.random.Generator,
    *,
    longer: bool = False,
) -> tuple[Array, Array]:
    """Return the values of walks, shape (n, r, 6), and the poses where they begin, shape (n, 7).

    Longer ones stay where cranks and slides reach, but go straight away farther.
    """
    size = max(
        float(np.abs(row.value.value)) for row in instance.constraints if row.kind.is_distance
    )
    size = max(size, float(np.linalg.norm(T)))
    weights = rng.normal(size=(walks, 3, 6)) / 2
    s = np.arange(ROWS) * STEP / FAR
    waves = np.stack([np.sin(s), 1 - np.cos(s), np.sin(2 * s) / 2], axis=0)
    twists = FAR * np.einsum("nwk,wr->nrk", weights, waves)
    for _ in range(HALVINGS if longer else 1):
        poses = poses_of(rotation_from_vector(twists[..., :3]) @ R, T + size * twists[..., 3:])
        values, stuck = _values_along(program, poses)
        # Arms and rails that are short reach less.
        twists[stuck] /= 2
    away = slice(None, None, 2)
    steps = np.diff(values, axis=1)
    pace = np.linalg.norm(steps, axis=2).mean()
    direction = rng.normal(size=(len(values[away]), 1, 6))
    direction *= pace / np.linalg.norm(direction, axis=2, keepdims=True)
    if longer:
        # Angles of cranks and ways of slides have different units; and folds are farther away.
        direction *= LONGER * 6**0.5 * np.abs(steps).mean(axis=(0, 1)) / pace
    values[away] = values[away, :1] + np.arange(ROWS)[:, None] * direction
    return _in_ranges(instance, values), poses[:, 0]


def _values_along(program: CompiledController, poses: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the values of poses, and which walks stay where a crank or slide does not reach."""
    walks, rows, _ = poses.shape
    values, ever = np.empty((walks, rows, 6)), np.zeros(walks, bool)
    near = None
    for k in range(rows):
        values[:, k], status = program.inverse(poses[:, k], near)
        near = values[:, k]
        stuck = status != 0
        values[stuck, k] = values[stuck, max(k - 1, 0)]
        ever |= stuck
    return values, ever


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


def _judge_closely(
    row: Row, instance: Instance, program: CompiledController, values: Array, found: Walks
) -> None:
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
                if (moved < CONVERGED).all():
                    break
            # A long first step, or one that does not converge, is not certain of its branch.
            alive[here[~((first < 0.02) & (moved < CONVERGED))]] = False
        here = np.flatnonzero(alive)
        poses = found.poses[here, k]
        turned = np.abs(rotation_from_quaternion(poses[:, 3:]) - R[here]).max(axis=(1, 2))
        away = np.linalg.norm(poses[:, :3] - T[here], axis=1)
        elsewhere = (turned > SAME) | (away > SAME * size)
        near = drives.gains(R[here], T[here], q[here, k])
        elsewhere |= _on_another_knee(drives, program, poses, values[here, k], near)
        row.judged += len(here)
        row.different += int(elsewhere.sum())


def _on_another_knee(
    drives: Drives, program: CompiledController, poses: Array, values: Array, near: Array
) -> NDArray[np.bool_]:
    """Return where a rod is on another knee, or the inverse kinematics not the values.

    Parameters
    ----------
    poses, values
        Of the program, shapes (n, 7) and (n, 6).
    near
        The gains at the poses of the judge, shape (n, 6).
    """
    q = drives.from_readings(values)
    own = drives.gains(rotation_from_quaternion(poses[:, 3:]), poses[:, :3], q)
    sure = drives.transmission(near) > DEAD
    wrong = ((np.sign(own) != np.sign(near)) & sure).any(axis=1)
    back, status = program.inverse(poses, values)
    sizes = np.where([sort == "crank" for sort in drives.sorts], 1.0, np.nanmax(drives.rods))
    off = (np.abs(drives.from_readings(back) - q) / sizes).max(axis=1)
    wrong |= ((status != 0) | (off > SAME)) & sure.all(axis=1)
    return np.asarray(wrong, bool)


def _judge_motors(row: Row, instance: Instance, values: Array, found: Walks) -> None:
    """Compare some walks with branches along which the cranks and slides move."""
    drives = Drives.of(instance)
    rods = np.array([one.value.value for one in instance.constraints])
    moved = drives.moved[drives.index]
    for walk in range(0, min(2 * CRANKED, len(values))):
        proved = int((found.status[walk, 1:] == 0).sum())
        if not proved:
            continue
        numbers = values[walk, : proved + 1]
        moving = {name: numbers[:, drives.names.index(name)] for name in _motors(instance)}
        start = found.poses[walk, 0]
        rows = np.where(moved, rods, numbers)
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
    line.add_argument("names", nargs="*", metavar="NAME", help="only these platforms")
    line.add_argument("--steps", type=int, default=400_000, help="about this many a platform")
    arguments = line.parse_args()
    everything = names()
    unknown = sorted({*arguments.names} - {*everything})
    if unknown:
        line.error(f"no such platform: {', '.join(unknown)}")
    chosen = [name for name in everything if not arguments.names or name in arguments.names]
    if arguments.check:
        chosen = sampled(chosen, arguments.sample)
    rows = results(
        chosen,
        partial(examine, arguments.steps),
        Row.of_entry,
        arguments,
        name=f"controllers-{arguments.steps}",
        label="walks",
    )
    wrong = [f"{row.name}: {row.problems} problems" for row in rows if row.problems]
    records = {row.name: asdict(row) for row in rows}
    if arguments.names and not arguments.check:
        with RECORD.open(encoding="utf-8", newline="") as file:
            records = {**{row["name"]: row for row in csv.DictReader(file)}, **records}
    text = csv_text([records[name] for name in everything if name in records])
    proved = sum(row.proved for row in rows)
    summary = f"{proved} proved steps of {len(rows)} platforms, no silent change of branch"
    return conclude(RECORD, text, wrong, summary, check=arguments.check)


if __name__ == "__main__":
    exit_after(main)
