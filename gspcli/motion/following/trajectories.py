"""Assembly modes along a trajectory of values: the path of each, and folds of two modes.

The numbers of modes are those of the real poses for the values that the instance states. If a
trajectory begins at other values, the modes are followed with proof from the stated values to the
first row and keep their numbers. A mode at the first row that is not reached in this way is new.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.defaults import SEED
from gspcli.errors import ArgumentError, IncompleteError, NotFiniteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import real_array
from gspcli.geometry.coordinates import Coordinate, choose, drive_corrections
from gspcli.geometry.home_mode import distances
from gspcli.geometry.instance import Instance
from gspcli.geometry.readings import values_of
from gspcli.motion.following.branch_follower import (
    FollowOptions,
    MovingPlatform,
    Stop,
    along_rows,
    at_values,
    over_rows,
)
from gspcli.motion.following.branch_runs import SAME, Run
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.tracks import Track
from gspcli.records import dataclass
from gspcli.solver import SolveResult, solve
from gspcli.ties import first_smallest

Array = NDArray[np.float64]
Platform = MovingPlatform | MovingGeometry


def track(
    instance: Instance,
    values: ArrayLike,
    *,
    coordinates: Mapping[str, ArrayLike] | None = None,
    t: ArrayLike | None = None,
    modes: Sequence[int] | None = None,
    near: tuple[ArrayLike, ArrayLike] | None = None,
    everything: bool = False,
    certify: bool = True,
    seed: int = SEED,
    jobs: int = 1,
) -> Track:
    """Follow assembly modes while the values change linearly from row to row.

    Parameters
    ----------
    instance
        Geometry, units, and the values whose modes give the numbers of modes.
    values
        Shape (r, 6), in the units and order of the instance; DPH and DHP distances are signed.
        Offsets are added to them.
    coordinates
        The readings of drives that move, by their names: ``slide.B1`` in length units, ``crank.B1``
        in angle units; each of shape (r,).
    t
        Increasing, shape (r,); the numbers of the rows from 1 if None.
    modes
        Which modes to follow, by their numbers as `solve` has them for the values of the instance
        (see above). All real poses at the first row if None.
    near
        Instead, a pose (R, T): the mode nearest to it.
    everything
        Whether to compare with all real poses at the last row, and to follow back modes that begin
        on the way, to their beginnings.
    certify
        Whether to prove each part.
    seed, jobs
        As for `solve`.

    Raises
    ------
    ArgumentError
        If an argument has a wrong shape or number.
    NotFiniteError, IncompleteError
        If the poses at an end of the trajectory are infinitely many or could not all be found.

    Examples
    --------
    >>> import gspcli
    >>> import numpy as np
    >>> platform = gspcli.example("workspace-study")
    >>> T = np.array([[0, 0, 400], [10, 0, 400], [10, 0, 410]])
    >>> R = np.tile(np.eye(3), (3, 1, 1))
    >>> followed = gspcli.track(platform, gspcli.measure(platform, R, T), near=(R[0], T[0]))
    >>> followed.certified, followed.ends, gspcli.motion.departures(followed, R, T)
    (True, (), [])
    """
    rows = values_of(instance, _checked(values, "values", (None, 6)))
    moving = coordinates or {}
    chosen = choose(instance, list(moving))
    columns = [_checked(column, name, (len(rows),)) for name, column in moving.items()]
    added, scales = drive_corrections(instance, chosen)
    columns = [column * scales[k] + added[k] for k, column in enumerate(columns)]
    rows = np.column_stack((rows, *columns))
    times = np.arange(1.0, len(rows) + 1) if t is None else _checked(t, "t", (len(rows),))
    if not (np.diff(times) > 0).all():
        raise ArgumentError("t must increase from row to row", "t")
    platform: MovingPlatform | MovingGeometry
    if chosen:
        platform = MovingGeometry(over_rows(instance, rows), chosen)
    else:
        platform = MovingPlatform(over_rows(instance, rows))
    first = row_modes(instance, platform, rows[0], seed=seed, jobs=jobs)
    R, T, numbers = first.R, first.T, first.numbers
    if not chosen:
        platform = MovingPlatform(along_rows(instance, rows, R))
    if near is not None:
        followed = [_nearest(instance, first, near)]
    elif modes is not None:
        followed = [_of_number(first, mode) for mode in modes]
    else:
        followed = list(range(len(R)))
    run = Run(instance, platform, times, rows, FollowOptions(certify=certify, jobs=jobs))
    forward = run.follow(R[followed], T[followed], numbers[followed])
    forward = replace(forward, known=first.known)
    if not everything:
        return forward
    last = row_modes(instance, platform, rows[-1], seed=seed, jobs=jobs)
    return _with_births(run, forward, last)


def track_from(
    instance: Instance,
    values: ArrayLike,
    R: ArrayLike,
    T: ArrayLike,
    *,
    options: FollowOptions | None = None,
) -> Track:
    """Follow given modes while the values change; as `track`, but nothing is solved.

    Parameters
    ----------
    instance
        Geometry and units; its values are not used.
    values
        Shape (r, 6), with the offsets of the instance added.
    R, T
        Poses at the first row, shapes (n, 3, 3) and (n, 3); they are numbered from 1.
    options
        How to follow.
    """
    rows = _checked(values, "values", (None, 6))
    times = np.arange(1.0, len(rows) + 1)
    R, T = np.asarray(R, float), np.asarray(T, float)
    platform = MovingPlatform(over_rows(instance, rows))
    run = Run(instance, platform, times, rows, options or FollowOptions())
    return run.follow(R, T, np.arange(1, len(R) + 1))


def _checked(given: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    array = real_array(given, name)
    fits = array.ndim == len(shape) and all(
        n in (None, m) for n, m in zip(shape, array.shape, strict=True)
    )
    if not fits or not array.size:
        expected = ", ".join("rows" if n is None else str(n) for n in shape)
        raise ArgumentError(f"found shape {array.shape}, expected ({expected})", name)
    if not np.isfinite(array).all():
        index = np.argwhere(~np.isfinite(array))[0].tolist()
        raise ArgumentError(
            f"found {array[tuple(index)]}, expected a finite number", f"{name}{index}"
        )
    return array


def _of_number(first: RowModes, mode: int) -> int:
    """Return the index of a mode among those at the first row."""
    found = np.flatnonzero(first.numbers == mode)
    if len(found):
        return int(found[0])
    there = ", ".join(map(str, first.numbers.tolist())) or "none"
    if not 1 <= mode <= first.known:
        message = f"found mode {mode}, expected one of those at the first row: {there}"
    else:
        message = (
            f"mode {mode} cannot be followed from the values of the instance to the first row; "
            f"found there: {there}"
        )
    raise ArgumentError(message)


def _nearest(instance: Instance, first: RowModes, pose: tuple[ArrayLike, ArrayLike]) -> int:
    if not len(first.R):
        raise ArgumentError("there is no real pose at the first row to be near to")
    goal = np.asarray(pose[0], float), np.asarray(pose[1], float)
    moved, turned = distances(first.R, first.T, *goal)
    return int(first_smallest(np.hypot(moved / Arrangement.of(instance).length, turned)))


def _with_births(run: Run, forward: Track, last: RowModes) -> Track:
    """Add the modes that begin on the way, followed back from the last row.

    Their numbers are those of modes followed from the stated values to the last row. If such a
    number is in use, the mode gets the next free one.
    """
    platform = run.platform
    points = platform.points(last.R, last.T)
    arrived = ~np.isnan(forward.T[:, -1, 0])
    known = platform.points(forward.R[arrived, -1], forward.T[arrived, -1])
    # Study points are known up to sign.
    overlap = np.abs(points @ known.T)
    distance = np.sqrt(np.maximum(0.0, 2 - 2 * overlap))
    fresh = np.flatnonzero(~(distance < SAME).any(axis=1))
    complete = len(points) - len(fresh) == int(arrived.sum())
    numbers = last.numbers[fresh]
    unknown = (numbers > last.known) | np.isin(numbers, forward.modes)
    first = int(forward.modes.max(initial=forward.known)) + 1
    numbers[unknown] = np.arange(first, first + unknown.sum())
    back = run.reversed.follow(last.R[fresh], last.T[fresh], numbers)
    rows = len(run.t)
    began = [
        replace(event, begins=True, row=rows - 2 - event.row, low=-event.high, high=-event.low)
        for event in back.events
    ]
    # A mode that can be followed back to the first row should have been followed from there.
    complete &= len(began) == len(fresh) and all(e.kind == "fold" for e in began)
    return replace(
        forward,
        modes=np.concatenate((forward.modes, numbers)),
        R=np.concatenate((forward.R, back.R[:, ::-1])),
        T=np.concatenate((forward.T, back.T[:, ::-1])),
        events=(*forward.events, *began),
        complete=complete,
        segments=forward.segments + back.segments,
        poses_at_end=(last.R, last.T),
    )


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
        raise NotFiniteError(f"the poses for the values {_listed(values)} are infinitely many")
    if result.verdict != "complete":
        raise IncompleteError(f"the poses for the values {_listed(values)} could not all be found")
    return result.R[result.real].real, result.T[result.real].real


def _listed(values: Array) -> str:
    return ", ".join(f"{value:.6g}" for value in values)
