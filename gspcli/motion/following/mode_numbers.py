"""The modes at a row of a trajectory, with the numbers that `solve` gives them.

The numbers are those of the real poses for the values that the instance states. If a trajectory
begins at other values, the modes are followed with proof from the stated values to the first row
and keep their numbers. A mode at the first row that is not reached in this way is new.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import IncompleteError, NotFiniteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import Coordinate
from gspcli.geometry.instance import Instance
from gspcli.motion.following.branch_follower import FollowOptions, MovingPlatform, Stop
from gspcli.motion.following.branch_runs import SAME
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.row_instances import along_rows, at_values, over_rows
from gspcli.records import dataclass
from gspcli.solver import SolveResult, solve

Array = NDArray[np.float64]
Platform = MovingPlatform | MovingGeometry


@dataclass(frozen=True, eq=False)
class RowModes:
    """The real poses at a row.

    Attributes
    ----------
    R, T
        The poses, shapes (n, 3, 3) and (n, 3), in the order of their numbers.
    numbers
        Their numbers, shape (n,).
    known
        The number of real poses for the stated values; modes with larger numbers are new.
    """

    R: Array
    T: Array
    numbers: NDArray[np.int64]
    known: int


def row_modes(
    instance: Instance, platform: Platform, row: Array, *, seed: int, jobs: int
) -> RowModes:
    """Return the real poses at a row of values and coordinates, numbered as `solve` does.

    Raises
    ------
    NotFiniteError, IncompleteError
        If the poses at the row are infinitely many or could not all be found.
    """
    start = _stated_row(instance, platform.chosen, row)
    if np.array_equal(start, row) and not _open_sides(instance).any():
        R, T = _real(solve(instance, seed=seed, jobs=jobs), row)
        return RowModes(R, T, np.arange(1, len(R) + 1), len(R))
    R, T = _real_poses_at(platform, row, seed, jobs)
    found = solve(instance, seed=seed, jobs=jobs)
    numbers = np.zeros(len(R), np.int64)
    known = found.counts.real if found.verdict == "complete" else 0
    if known and len(R):
        numbers = _carried(instance, platform, found, np.stack((start, row)), (R, T), jobs)
    fresh = np.flatnonzero(numbers == 0)
    numbers[fresh] = known + 1 + np.arange(len(fresh))
    order = np.argsort(numbers)
    return RowModes(R[order], T[order], numbers[order], known)


def _stated_row(instance: Instance, chosen: Sequence[Coordinate], row: Array) -> Array:
    """Return the values and drives that an instance states; open sides are those of a row."""
    arrangement = Arrangement.of(instance)
    signs = np.where(arrangement.sides < 0, -1.0, 1.0)
    signs = np.where(_open_sides(instance) & (row[:6] < 0), -1.0, signs)
    return np.concatenate((signs * arrangement.values, np.zeros(len(chosen))))


def _open_sides(instance: Instance) -> NDArray[np.bool_]:
    """Return which constraints leave their side open, shape (6,)."""
    arrangement = Arrangement.of(instance)
    return np.asarray(arrangement.sided & (arrangement.sides == 0))


def _carried(
    instance: Instance,
    platform: Platform,
    found: SolveResult,
    rows: Array,
    first: tuple[Array, Array],
    jobs: int,
) -> NDArray[np.int64]:
    """Return the numbers of poses at the second row; 0 if no mode of the first row arrives."""
    real, sides = found.real, found.sides[found.real]
    R, T = found.R[real].real, found.T[real].real
    begins = (~_open_sides(instance) | (sides * np.sign(rows[0, :6]) >= 0)).all(axis=1)
    numbers = np.flatnonzero(begins) + 1
    R, T = R[begins], T[begins]
    between: Platform
    if platform.chosen:
        between = MovingGeometry(over_rows(instance, rows), platform.chosen)
    else:
        between = MovingPlatform(along_rows(instance, rows, R))
    if not np.array_equal(rows[0], rows[1]):
        # Folds are not searched for: the ends of modes on the way are not needed.
        followed = between.follow(
            between.internal(rows)[None],
            np.zeros(len(R), np.int64),
            between.points(R, T),
            FollowOptions(jobs=jobs),
        )
        there = followed.stop == Stop.END
        numbers = numbers[there]
        R, T = between.poses(followed.points[there, -1])
    if not len(R):
        return np.zeros(len(first[0]), np.int64)
    # Study points are known up to sign.
    overlap = np.abs(between.points(*first) @ between.points(R, T).T)
    same_pose = np.sqrt(np.maximum(0.0, 2 - 2 * overlap)) < SAME
    return np.where(same_pose.any(axis=1), numbers[same_pose.argmax(axis=1)], 0)


def _real_poses_at(platform: Platform, row: Array, seed: int, jobs: int) -> tuple[Array, Array]:
    """Return the real poses at a row, in the order of `solve`."""
    values = row[:6]
    instance = at_values(platform.instance_at(row), values)
    result: SolveResult = solve(instance, seed=seed, jobs=jobs)
    return _real(result, values)


def _real(result: SolveResult, row: Array) -> tuple[Array, Array]:
    values = row[:6]
    if result.verdict == "infinite":
        message = f"the poses for the values {_listed(values)} are infinitely many"
        raise NotFiniteError(message)
    if result.verdict != "complete":
        message = f"the poses for the values {_listed(values)} could not all be found"
        raise IncompleteError(message)
    return result.R[result.real].real, result.T[result.real].real


def _listed(values: Array) -> str:
    return ", ".join(f"{value:.6g}" for value in values)
