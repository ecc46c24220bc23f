"""Assembly modes along a trajectory of values: where each goes, and where it meets another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.folds import Fold, prove_fold
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError, IncompleteError, NotFiniteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import Coordinate, choose, moved
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.following import Branches, FollowOptions, MovingPlatform, Stop
from gspcli.motion.moving_geometry import MovingGeometry
from gspcli.solver import SolveResult, solve

Array = NDArray[np.float64]

#: Points of norm one at the same pose agree to this.
_SAME = 1e-7
#: A fold further from the end of a branch than this, in Study points of norm one, is another one.
_NEAR = 0.3
#: Lines at a smaller angle are called nearly parallel (radians), and a platform further away than
#: so many of its typical lengths far; only in words.
_PARALLEL = 1e-2
_FAR = 10.0


@dataclass(frozen=True, eq=False)
class Event:
    """Where a mode ends or begins.

    Attributes
    ----------
    kind
        ``fold``: proved, the mode and its partner meet and both vanish; ``undecided``: the mode was
        followed up to here, and neither continued nor proved to end.
    reason
        Of what is undecided, what is seen there: that lines of a DLL become parallel, that the
        platform goes far away, or nothing but that the pose is nearly singular.
    begins
        Whether the mode begins here instead of ending.
    mode
        Its number.
    row
        The row (from 0) before the event.
    low, high
        Between which t it is: for a fold proved, else where following stopped and the next row.
    R, T
        The pose, shapes (3, 3) and (3,); of a fold the singular one.
    partner
        The number of the mode that vanishes with it, if that is among those followed.
    partner_R, partner_T
        The pose of the partner at the row before (after, if it begins); None if not found.
    """

    kind: Literal["fold", "undecided"]
    reason: str
    begins: bool
    mode: int
    row: int
    low: float
    high: float
    R: Array
    T: Array
    partner: int | None = None
    partner_R: Array | None = None
    partner_T: Array | None = None


@dataclass(frozen=True, eq=False)
class Track:
    """Assembly modes along a trajectory.

    Attributes
    ----------
    instance
        Geometry and units.
    t, values
        The rows, shapes (r,) and (r, 6); the values change linearly between them.
    modes
        The numbers of the modes as `solve` orders them at the first row; those that are born later
        are numbered on. Shape (m,).
    R, T
        Poses, shapes (m, r, 3, 3) and (m, r, 3); NaN where a mode does not exist or was not
        followed.
    certified
        Whether every part of every mode is proved to be one branch with no other near it.
    events
        Where modes end, and with ``everything`` where they begin.
    complete
        Whether, with ``everything``, the modes at the last row are exactly the real poses there.
    segments
        Of how many proved (or followed) parts the modes are made.
    poses_at_end
        With ``everything``: all real poses (R, T) at the last row, found without following.
    coordinates, places
        The coordinates that move, c of them, and where they are at each row, shape (r, c).
    """

    instance: Instance
    t: Array
    values: Array
    modes: NDArray[np.int64]
    R: Array
    T: Array
    certified: bool
    events: tuple[Event, ...]
    complete: bool | None
    segments: int
    poses_at_end: tuple[Array, Array] | None = None
    coordinates: tuple[Coordinate, ...] = ()
    places: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def instances(self) -> Iterator[tuple[slice, Instance]]:
        """Yield runs of rows with the instance there, whose values are not used."""
        if not self.coordinates:
            yield slice(None), self.instance
            return
        for k, place in enumerate(self.places):
            yield slice(k, k + 1), moved(self.instance, self.coordinates, place)

    @cached_property
    def conditions(self) -> Array:
        """Condition numbers of the poses, shape (m, r); NaN where there is none."""
        conditions = np.full(self.T.shape[:2], np.nan)
        there = ~np.isnan(self.T[..., 0])
        for rows, instance in self.instances():
            here = np.zeros(there.shape, bool)
            here[:, rows] = there[:, rows]
            conditions[here] = condition_numbers(
                Arrangement.of(instance), self.R[here], self.T[here]
            )
        return conditions

    @cached_property
    def quaternions(self) -> Array:
        """Unit quaternions of the rotations, shape (m, r, 4), continuous along each mode.

        The first one of a mode has the sign of `quaternion_from_rotation`.
        """
        quaternions = np.full((*self.T.shape[:2], 4), np.nan)
        there = ~np.isnan(self.T[..., 0])
        quaternions[there] = quaternion_from_rotation(self.R[there])
        turns = np.einsum("mri,mri->mr", quaternions[:, 1:], quaternions[:, :-1])
        signs = np.where(turns < 0, -1.0, 1.0).cumprod(axis=1)
        quaternions[:, 1:] *= signs[..., None]
        return quaternions

    @property
    def ends(self) -> tuple[Event, ...]:
        """The events at which a mode ends."""
        return tuple(event for event in self.events if not event.begins)


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
    rows = _checked(values, "values", (None, 6))
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
    run = _Run(platform, times, rows, FollowOptions(certify=certify, jobs=jobs))
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
        Shape (r, 6).
    R, T
        Poses at the first row, shapes (n, 3, 3) and (n, 3); they are numbered from 1.
    options
        How to follow.
    """
    rows = _checked(values, "values", (None, 6))
    times = np.arange(1.0, len(rows) + 1)
    R, T = np.asarray(R, float), np.asarray(T, float)
    run = _Run(MovingPlatform(_over(instance, rows)), times, rows, options or FollowOptions())
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


@dataclass(frozen=True, eq=False)
class _Run:
    """Following along one trajectory."""

    platform: MovingPlatform | MovingGeometry
    t: Array
    values: Array
    options: FollowOptions

    def follow(self, R: Array, T: Array, numbers: NDArray[np.int64]) -> Track:
        """Follow modes from the first row."""
        platform = self.platform
        branches = platform.follow(
            platform.internal(self.values)[None],
            np.zeros(len(R), np.int64),
            platform.points(R, T),
            self.options,
        )
        poses = platform.poses(branches.points)
        folds = [
            self._fold(branches, k) if branches.stop[k] == Stop.STEP else None
            for k in range(len(R))
        ]
        events = tuple(
            self._event(branches, folds, numbers, k)
            for k in range(len(R))
            if branches.stop[k] != Stop.END
        )
        return Track(
            platform.instance,
            self.t,
            self.values[:, :6],
            numbers,
            *poses,
            self.options.certify,
            events,
            None,
            int(branches.segments.sum()),
            coordinates=platform.chosen,
            places=self.values[:, 6:],
        )

    @property
    def reversed(self) -> _Run:
        """The same from the last row to the first."""
        return _Run(self.platform, -self.t[::-1], self.values[::-1].copy(), self.options)

    def time(self, row: int, part: float) -> float:
        """Return t at a part of the step after a row."""
        if row + 1 == len(self.t):
            return float(self.t[row])
        return float(self.t[row] + part * (self.t[row + 1] - self.t[row]))

    def _value(self, row: int, part: float) -> Array:
        if row + 1 == len(self.t):
            return self.platform.internal(self.values[row])
        first, last = self.platform.internal(self.values[row : row + 2])
        value: Array = first + part * (last - first)
        return value

    def _fold(self, branches: Branches, k: int) -> tuple[int, Fold] | None:
        """Return the row before it and the fold at which a branch ends, if one can be proved."""
        row, part, point = int(branches.reached[k]), float(branches.fraction[k]), branches.last[k]
        jacobian = self.platform.jacobian(point, self._value(row, part))
        direction = np.linalg.svd(np.vstack((jacobian, point)))[2][-1]
        # Just before a row, the fold may be after it.
        for before, begin in ((row, part), (row + 1, 0.0)):
            if before + 1 >= len(self.t):
                return None
            rows = self.values[before], self.values[before + 1]
            fold = prove_fold(self.platform.system, rows, begin, point, direction)
            if fold is None or fold.bends > 0 or not begin <= fold.high <= fold.low + 1e-9:
                continue
            if fold.low <= 1 and np.linalg.norm(_unit(fold.point, point) - point) < _NEAR:
                return before, fold
        return None

    def _event(
        self,
        branches: Branches,
        folds: list[tuple[int, Fold] | None],
        numbers: NDArray[np.int64],
        k: int,
    ) -> Event:
        """Return what became of a branch that ended early."""
        row, part = int(branches.reached[k]), float(branches.fraction[k])
        found = folds[k]
        mode = int(numbers[k])
        if found is None:
            point = branches.last[k]
            R, T = self.platform.poses(point)
            row = max(row, 0)
            low, high, reason = self.time(row, part), self.time(row, 1.0), self._reason(row, R, T)
            return Event("undecided", reason, False, mode, row, low, high, R, T)
        before, fold = found
        partner = next(
            (
                int(numbers[j])
                for j, other in enumerate(folds)
                if j != k and other is not None and other[0] == before and _same(other[1], fold)
            ),
            None,
        )
        R, T = self.platform.poses(fold.point)
        other = self._partner(branches, k, fold)
        times = self.time(before, fold.low), self.time(before, fold.high)
        return Event(
            "fold", "", False, mode, before, *times, R, T, partner, *(other or (None, None))
        )

    def _reason(self, row: int, R: Array, T: Array) -> str:
        """Return what is seen at a pose where following stopped."""
        arrangement = Arrangement.of(self.platform.instance_at(self.values[row]))
        w, v = arrangement.placed(R, T).w, arrangement.v
        sines = np.linalg.norm(np.cross(w, v), axis=-1)
        for k, kind in enumerate(arrangement.kinds):
            if kind is DLL and sines[k] < _PARALLEL:
                return f"the lines of constraint {k + 1} become parallel"
        distance = float(
            np.linalg.norm(T + R @ arrangement.platform_centre - arrangement.base_centre)
        )
        if distance > _FAR * arrangement.length:
            unit = self.platform.instance.units.length
            return f"the platform goes far away, to {distance:.3g} {unit}"
        return "the pose is nearly singular"

    def _partner(self, branches: Branches, k: int, fold: Fold) -> tuple[Array, Array] | None:
        """Return the pose at the row before of the branch that meets this one in a fold."""
        row, part, point = int(branches.reached[k]), float(branches.fraction[k]), branches.last[k]
        mirrored = 2 * _unit(fold.point, point) - point
        here = self._value(row, part)
        back = np.stack((here, self._value(row, 0.0)))[None]
        found = self.platform.follow(back, np.zeros(1, np.int64), mirrored[None], self.options)
        start = found.points[0, 0]
        if found.stop[0] != Stop.END or np.linalg.norm(start - point) < _SAME:
            return None
        R, T = self.platform.poses(found.points[0, -1])
        return R, T


def _unit(point: Array, like: Array) -> Array:
    """Return the multiple of norm one of a Study point, with the sign of another."""
    unit: Array = point / np.linalg.norm(point)
    return unit if unit @ like > 0 else -unit


def _same(first: Fold, second: Fold) -> bool:
    """Whether two folds are the same: their times overlap, and so do their points."""
    overlap = first.low <= second.high and second.low <= first.high
    a = _unit(first.point, first.point)
    return overlap and bool(np.linalg.norm(a - _unit(second.point, a)) < _SAME)


def _with_births(run: _Run, forward: Track, last: tuple[Array, Array]) -> Track:
    """Add the modes that are born on the way, followed back from the last row."""
    platform = run.platform
    points = platform.points(*last)
    arrived = ~np.isnan(forward.T[:, -1, 0])
    known = platform.points(forward.R[arrived, -1], forward.T[arrived, -1])
    # Study points are known up to sign.
    overlap = np.abs(points @ known.T)
    distance = np.sqrt(np.maximum(0.0, 2 - 2 * overlap))
    fresh = np.flatnonzero(~(distance < _SAME).any(axis=1))
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
