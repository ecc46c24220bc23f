"""Assembly modes along a trajectory of values: where each goes, and where it meets another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.defaults import SEED
from gspcli.errors import ArgumentError, IncompleteError, NotFiniteError
from gspcli.geometry.coordinates import choose
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.readings import values_of
from gspcli.motion.following.branch_follower import FollowOptions, MovingPlatform
from gspcli.motion.following.branch_runs import SAME, Run
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.parallel_lines import along_parallel_lines
from gspcli.motion.following.tracks import Track
from gspcli.solver import SolveResult, solve

Array = NDArray[np.float64]


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
        Geometry and units; its values are not used.
    values
        Shape (r, 6), in the units and order of the instance; DPH and DHP distances are signed.
        Offsets are added to them.
    coordinates
        Of primitives that move, by their names (`gspcli.geometry.coordinates`), such as
        ``base.B1.x`` in length units or ``crank.B1`` in angle units; each of shape (r,).
    t
        Increasing, shape (r,); the numbers of the rows from 1 if None.
    modes
        Which real poses at the first row to follow, by their number from 1 in the order of `solve`.
        All of them if None.
    near
        Instead, a pose (R, T): the mode nearest to it.
    everything
        Whether to compare with all real poses at the last row, and to follow those that were born
        on the way back to where they begin.
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
    """
    rows = values_of(instance, _checked(values, "values", (None, 6)))
    moving = coordinates or {}
    chosen = choose(instance, list(moving))
    columns = [_checked(column, name, (len(rows),)) for name, column in moving.items()]
    rows = np.column_stack((rows, *columns))
    times = np.arange(1.0, len(rows) + 1) if t is None else _checked(t, "t", (len(rows),))
    if not (np.diff(times) > 0).all():
        message = "t must increase from row to row"
        raise ArgumentError(message, "t")
    platform: MovingPlatform | MovingGeometry
    if chosen:
        platform = MovingGeometry(_over(instance, rows), chosen)
    else:
        platform = MovingPlatform(_over(instance, rows))
    R, T = _all_poses(platform, rows[0], seed, jobs)
    if not chosen:
        same = along_parallel_lines(at_values(instance, rows[0]), rows[:, :6], R)
        platform = MovingPlatform(_over(same, rows))
    numbers = np.arange(1, len(R) + 1)
    if near is not None:
        followed = [_nearest(R, T, near)]
    elif modes is not None:
        for mode in modes:
            if not 1 <= mode <= len(R):
                message = f"found mode {mode}, expected one of the {len(R)} at the first row"
                raise ArgumentError(message)
        followed = [mode - 1 for mode in modes]
    else:
        followed = list(range(len(R)))
    run = Run(instance, platform, times, rows, FollowOptions(certify=certify, jobs=jobs))
    forward = run.follow(R[followed], T[followed], numbers[followed])
    if not everything:
        return forward
    return _with_births(run, forward, _all_poses(platform, rows[-1], seed, jobs))


def track_from(
    instance: Instance,
    values: ArrayLike,
    R: ArrayLike,
    T: ArrayLike,
    *,
    options: FollowOptions | None = None,
) -> Track:
    """Follow given modes while the values change; as `track`, without solving anything.

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
    platform = MovingPlatform(_over(instance, rows))
    run = Run(instance, platform, times, rows, options or FollowOptions())
    return run.follow(R, T, np.arange(1, len(R) + 1))


def _over(instance: Instance, rows: Array) -> Instance:
    """Return the instance for following along rows: a value of zero stands for zero at all rows."""
    values = rows[:, :6]
    return at_values(instance, values[np.abs(values).argmax(axis=0), np.arange(6)])


def at_values(instance: Instance, values: Array) -> Instance:
    """Return an instance with other values; a signed distance to a plane becomes a side."""
    constraints = []
    for constraint, value in zip(instance.constraints, values[:6].tolist(), strict=True):
        side = constraint.side
        if constraint.kind.has_sides:
            side = Side.NEGATIVE if value < 0 else Side.POSITIVE
            value = abs(value)
        constraints.append(replace(constraint, value=Number.of(value), side=side))
    return replace(instance, constraints=tuple(constraints))


def _checked(given: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    array = np.asarray(given, float)
    fits = array.ndim == len(shape) and all(
        n in (None, m) for n, m in zip(shape, array.shape, strict=True)
    )
    if not fits or not array.size:
        expected = ", ".join("rows" if n is None else str(n) for n in shape)
        message = f"found shape {array.shape}, expected ({expected})"
        raise ArgumentError(message, name)
    if not np.isfinite(array).all():
        index = np.argwhere(~np.isfinite(array))[0].tolist()
        message = f"found {array[tuple(index)]}, expected a finite number"
        raise ArgumentError(message, f"{name}{index}")
    return array


def _all_poses(
    platform: MovingPlatform | MovingGeometry, row: Array, seed: int, jobs: int
) -> tuple[Array, Array]:
    """Return the real poses at a row, in the order of `solve`."""
    values = row[:6]
    instance = at_values(platform.instance_at(row), values)
    result: SolveResult = solve(instance, seed=seed, jobs=jobs)
    if result.verdict == "infinite":
        message = f"the poses for the values {_listed(values)} are infinitely many"
        raise NotFiniteError(message)
    if result.verdict != "complete":
        message = f"the poses for the values {_listed(values)} could not all be found"
        raise IncompleteError(message)
    return result.R[result.real].real, result.T[result.real].real


def _listed(values: Array) -> str:
    return ", ".join(f"{value:.6g}" for value in values)


def _nearest(R: Array, T: Array, pose: tuple[ArrayLike, ArrayLike]) -> int:
    if not len(R):
        message = "there is no real pose at the first row to be near to"
        raise ArgumentError(message)
    length = np.ptp(T, axis=0).max() or 1.0
    difference = np.abs(R - np.asarray(pose[0])).max(axis=(1, 2))
    return int(
        np.maximum(difference, np.abs(T - np.asarray(pose[1])).max(axis=1) / length).argmin()
    )


def _with_births(run: Run, forward: Track, last: tuple[Array, Array]) -> Track:
    """Add the modes that are born on the way, followed back from the last row."""
    platform = run.platform
    points = platform.points(*last)
    arrived = ~np.isnan(forward.T[:, -1, 0])
    known = platform.points(forward.R[arrived, -1], forward.T[arrived, -1])
    # Study points are known up to sign.
    overlap = np.abs(points @ known.T)
    distance = np.sqrt(np.maximum(0.0, 2 - 2 * overlap))
    fresh = np.flatnonzero(~(distance < SAME).any(axis=1))
    complete = len(points) - len(fresh) == int(arrived.sum())
    first = int(forward.modes.max(initial=0)) + 1
    numbers = np.arange(first, first + len(fresh))
    back = run.reversed.follow(last[0][fresh], last[1][fresh], numbers)
    rows = len(run.t)
    began = [
        replace(
            event,
            begins=True,
            row=rows - 2 - event.row,
            low=-event.high,
            high=-event.low,
        )
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
        poses_at_end=last,
    )
