"""Assembly modes along a trajectory: all their poses, their ends, and where a file has others.

The numbers of modes are those of the real poses for the values that the instance states. If a
trajectory begins at other values, the modes are followed with proof from the stated values to the
first row and keep their numbers. A mode at the first row that is not reached in this way is new.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.branches.curves import Fold, follow_closely, prove_fold
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError, IncompleteError, NotFiniteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import real_array
from gspcli.geometry.coordinates import Coordinate, choose, drive_corrections, moved
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.home_mode import distances
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import condition_numbers, printed_conditions
from gspcli.geometry.quaternions import quaternion_from_rotation, vector_from_rotation
from gspcli.geometry.readings import values_of
from gspcli.geometry.tolerances import NEARLY_PARALLEL_SINE
from gspcli.motion.following.branch_follower import (
    Branches,
    FollowOptions,
    MovingGeometry,
    MovingPlatform,
    Stop,
    along_rows,
    at_values,
    over_rows,
)
from gspcli.records import Tabular, dataclass
from gspcli.solver import SolveResult, solve
from gspcli.ties import first_smallest
from gspcli.wording import counted

Array = NDArray[np.float64]
#: Columns of a pose.
POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")
_NOTHING: Mapping[str, Array] = MappingProxyType({})
#: Two poses are different if an angle (radians) or a shift (in lengths of the platform) is larger
#: than this.
_LEAST = 1e-6
#: Near singular poses rounding errors of values move a pose further: by its condition number times
#: this, and not by more than that.
_ROUNDING, _MOST = 1e3 * float(np.finfo(float).eps), 1e-3


@dataclass(frozen=True, eq=False)
class Event:
    """The end or the beginning of a mode."""

    #: ``fold``: it is proved that the mode and its partner meet and vanish. ``undecided``: the mode
    #: was followed up to here, and was neither continued nor proved to end.
    kind: Literal["fold", "undecided"]
    #: For an undecided event what was observed at its pose: lines of a DLL become parallel, the
    #: platform goes far away, or the pose is nearly singular.
    reason: str
    #: Whether the mode begins here instead of ending.
    begins: bool
    #: Its number.
    mode: int
    #: The row (from 0) before the event.
    row: int
    #: An interval of t: for a fold it is proved to contain the fold, otherwise it leads from the
    #: last point of the mode to the next row.
    low: float
    high: float
    #: The pose, shapes (3, 3) and (3,); of a fold the singular one. Not finite where the platform
    #: goes to infinity.
    R: Array
    T: Array
    #: The number of the mode that vanishes with it, if that mode was followed.
    partner: int | None = None
    #: The pose of the partner at the row before (after, if it begins); None if not found.
    partner_R: Array | None = None
    partner_T: Array | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the event as plain data; rows are counted from 1."""
        return {
            "kind": self.kind,
            "reason": self.reason,
            "begins": self.begins,
            "mode": self.mode,
            "partner": self.partner,
            "row": self.row + 1,
            "t": [self.low, self.high],
            "R": _finite(self.R),
            "T": _finite(self.T),
            "partner_R": None if self.partner_R is None else self.partner_R.tolist(),
            "partner_T": None if self.partner_T is None else self.partner_T.tolist(),
        }


@dataclass(frozen=True, eq=False)
class Track(Tabular):
    """Assembly modes along a trajectory."""

    #: Geometry and units, as given.
    instance: Instance
    #: The instance with points for lines of a DLL that stay parallel all along.
    followed: Instance
    #: The rows, shapes (r,) and (r, 6); the values, with the offsets of the instance added, change
    #: linearly between them.
    t: Array
    values: Array
    #: The numbers of the modes as `solve` orders them for the values of the instance
    #: (`gspcli.motion.following.tracks`); modes that are new at the first row, or begin later, have
    #: the next numbers. Shape (m,).
    modes: NDArray[np.int64]
    #: Poses, shapes (m, r, 3, 3) and (m, r, 3); NaN where a mode does not exist or was not
    #: followed.
    R: Array
    T: Array
    #: Whether every part of every mode is proved to be one branch with no other branch near it.
    certified: bool
    #: The ends of modes, and with ``everything`` also their beginnings.
    events: tuple[Event, ...]
    #: Whether, with ``everything``, the modes at the last row are exactly the real poses there.
    complete: bool | None
    #: The number of proved (or followed) parts of all modes.
    segments: int
    #: With ``everything``: all real poses (R, T) at the last row, found without following.
    poses_at_end: tuple[Array, Array] | None = None
    #: The number of real poses for the values of the instance; modes with larger numbers are new.
    known: int = 0
    #: The c coordinates that move, and their numbers at each row, shape (r, c).
    coordinates: tuple[Coordinate, ...] = ()
    places: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def __post_init__(self) -> None:
        for array in (self.t, self.values, self.modes, self.R, self.T, self.places):
            array.setflags(write=False)

    def __repr__(self) -> str:
        how = "proved" if self.certified else "not proved"
        kinds = self.instance.name or self.instance.type.id
        size = f"{counted(len(self.modes), 'mode')}, {counted(len(self.t), 'row')}"
        return f"<Track of {kinds}: {size}, {how}, {counted(len(self.events), 'event')}>"

    def instances(self) -> Iterator[tuple[slice, Instance]]:
        """Yield runs of rows, each with the instance that is followed; its values are not used."""
        if not self.coordinates:
            yield slice(None), self.followed
            return
        for k, place in enumerate(self.places):
            yield slice(k, k + 1), moved(self.followed, self.coordinates, place)

    @cached_property
    def readings(self) -> Array:
        """The numbers of `places` as in files: cranks and slides as readings, shape (r, c)."""
        added, times = drive_corrections(self.instance, self.coordinates)
        if not added.any() and (times == 1).all():
            return self.places
        return (self.places - added) / times

    @cached_property
    def conditions(self) -> Array:
        """Condition numbers of the poses, shape (m, r); NaN where there is none.

        The unit of length is the size of the given instance, at all rows.
        """
        length = Arrangement.of(self.instance).length
        conditions = np.full(self.T.shape[:2], np.nan)
        there = ~np.isnan(self.T[..., 0])
        for rows, instance in self.instances():
            here = np.zeros(there.shape, bool)
            here[:, rows] = there[:, rows]
            conditions[here] = condition_numbers(
                Arrangement.of(instance), self.R[here], self.T[here], length
            )
        return conditions

    @cached_property
    def quaternions(self) -> Array:
        """Unit quaternions of the rotations, shape (m, r, 4), continuous along each mode.

        The first one of a mode has the sign of `quaternion_from_rotation`.
        """
        return continuous_quaternions(self.R)

    def rows(
        self, more: Mapping[str, Array] = _NOTHING, frame: PoseFrame = IDENTITY
    ) -> list[dict[str, Any]]:
        """Return a row for each pose, as plain data.

        Parameters
        ----------
        more
            Further columns, each of shape (m, r).
        frame
            The frame in which poses are expressed.
        """
        keys = ("t", "mode", *POSE, "condition", *more)
        conditions = printed_conditions(self.conditions)
        R, T = frame.from_platform(self.R, self.T)
        quaternions = self.quaternions if R is self.R else continuous_quaternions(R)
        numbers = np.dstack((T, quaternions, conditions, *more.values()))
        there = ~np.isnan(self.T[..., 0])
        modes = self.modes.tolist()
        return [
            dict(zip(keys, (t, mode, *pose), strict=True))
            for t, poses, known in zip(
                self.t.tolist(), numbers.swapaxes(0, 1).tolist(), there.T.tolist(), strict=True
            )
            for mode, pose, here in zip(modes, poses, known, strict=True)
            if here
        ]

    def to_json(
        self, rows: list[dict[str, Any]] | None = None, frame: PoseFrame = IDENTITY
    ) -> dict[str, Any]:
        """Return the track as plain data of schema ``gsp.track/1``, without ranges and cones.

        Parameters
        ----------
        rows
            Those of `rows`, perhaps with more columns.
        frame
            The frame in which their poses are expressed; R and T of events are the platform's.
        """
        return {
            "schema": "gsp.track/1",
            **self.instance.to_json(),
            "certified": self.certified,
            "complete": self.complete,
            "modes": self.modes.tolist(),
            "new": self.new,
            "coordinates": {
                one.name: self.readings[:, k].tolist() for k, one in enumerate(self.coordinates)
            },
            "parts": self.segments,
            **({} if frame.is_identity else {"frames": frame.to_json()}),
            "poses": self.rows(frame=frame) if rows is None else rows,
            "events": [event.to_json() for event in self.events],
        }

    @property
    def new(self) -> list[int]:
        """The numbers of modes at the first row that do not occur for the instance's values."""
        there = ~np.isnan(self.T[:, 0, 0]) if self.T.shape[1] else np.zeros(0, bool)
        return [mode for mode in self.modes[there].tolist() if mode > self.known]

    @property
    def ends(self) -> tuple[Event, ...]:
        """The events at which a mode ends."""
        return tuple(event for event in self.events if not event.begins)


def continuous_quaternions(R: Array) -> Array:
    """Return unit quaternions of rotations, shape (m, r, 4), continuous along each mode."""
    quaternions = np.full((*R.shape[:2], 4), np.nan)
    there = ~np.isnan(R[..., 0, 0])
    quaternions[there] = quaternion_from_rotation(R[there])
    turns = np.einsum("mri,mri->mr", quaternions[:, 1:], quaternions[:, :-1])
    signs = np.where(turns < 0, -1.0, 1.0).cumprod(axis=1)
    quaternions[:, 1:] *= signs[..., None]
    return quaternions


def _finite(part: Array) -> Any:
    """Return a part of a pose; None for a pose at infinity."""
    return part.tolist() if np.isfinite(part).all() else None


@dataclass(frozen=True)
class Departure:
    """A row at which a mode is not at the pose of the file."""

    #: The number of the mode.
    mode: int
    #: The row of the file, from 0.
    row: int
    #: The number of the row there.
    t: float
    #: Between the origins of the platform at the two poses, in the unit of length.
    distance: float
    #: The angle between the two orientations, in radians.
    turn: float

    def to_json(self, in_radians: float) -> dict[str, Any]:
        """Return the departure as plain data; rows are counted from 1.

        Parameters
        ----------
        in_radians
            The unit of angles.
        """
        return {
            "mode": self.mode,
            "row": self.row + 1,
            "t": self.t,
            "distance": self.distance,
            "turn": self.turn / in_radians,
        }


def departures(track: Track, R: ArrayLike, T: ArrayLike) -> list[Departure]:
    """Return the rows at which modes are not at the poses whose values they were followed along.

    Values that change linearly between two poses which are far apart can lead a mode to another
    pose with the same values. Only modes that begin at the first pose are compared. If no mode
    begins there, the mode that begins nearest to it is compared.

    Parameters
    ----------
    track
        The followed modes. Its rows are those of the poses, or have equally many rows between two
        of these.
    R, T
        The n poses, shapes (n, 3, 3) and (n, 3).

    Returns
    -------
    list
        In the order of the modes, then of the rows. Rows at which a mode does not exist are left
        out: `Track.ends` has these modes.
    """
    R, T = np.asarray(R, float), np.asarray(T, float)
    if not len(track.modes) or not len(T):
        return []
    step = max(1, (len(track.t) - 1) // max(1, len(T) - 1))
    there_R, there_T = track.R[:, ::step], track.T[:, ::step]
    with np.errstate(invalid="ignore"):
        distances = np.linalg.norm(there_T - T, axis=-1)
        turns = np.linalg.norm(
            vector_from_rotation(np.swapaxes(R, -1, -2) @ np.nan_to_num(there_R)), axis=-1
        )
        length = Arrangement.of(track.instance).length
        apart = np.maximum(distances / length, turns)
        allowed = np.clip(_ROUNDING * track.conditions[:, ::step], _LEAST, _MOST)
        other = apart > allowed
    begin = np.flatnonzero(~other[:, 0] & ~np.isnan(distances[:, 0]))
    if not len(begin):
        first = np.where(np.isnan(apart[:, 0]), np.inf, apart[:, 0])
        begin = np.array([int(first.argmin())])
    return [
        Departure(
            int(track.modes[mode]),
            row,
            float(track.t[row * step]),
            float(distances[mode, row]),
            float(turns[mode, row]),
        )
        for mode in begin.tolist()
        for row in np.flatnonzero(other[mode]).tolist()
    ]


#: Points of norm one at the same pose agree to this.
SAME = 1e-7
#: A platform farther away than this many typical lengths is called "far away" in a reason.
_FAR = 10.0
#: The reason of an undecided end at which nothing else is seen.
NEARLY_SINGULAR = "the pose is nearly singular"


@dataclass(frozen=True, eq=False)
class Run:
    """Following along one trajectory."""

    instance: Instance
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
        folds = [self._carried_on(branches, k) for k in range(len(R))]
        self._shared(branches, folds)
        poses = platform.poses(branches.points)
        events = tuple(
            self._event(branches, folds, numbers, k)
            for k in range(len(R))
            if branches.stop[k] != Stop.END
        )
        return Track(
            self.instance,
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
    def reversed(self) -> Run:
        """The run from the last row to the first."""
        return Run(
            self.instance, self.platform, -self.t[::-1], self.values[::-1].copy(), self.options
        )

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

    def _carried_on(self, branches: Branches, k: int) -> tuple[int, Fold] | None:
        """Continue a branch where doubles do not suffice; return the fold at its end, if any.

        The new points are added to the branch.
        """
        closely = False
        while branches.stop[k] == Stop.STEP:
            row = int(branches.reached[k])
            fold = self._fold(branches, k)
            if fold is not None and self._reaches(branches, k, fold):
                return row, fold
            # More digits do not help at parallel lines and at poses far away.
            seen = self._seen(row, *self.platform.poses(branches.last[k]))
            if closely or not self.options.certify or (fold is None and seen is not None):
                return None
            self._follow_closely(branches, k)
            closely = branches.reached[k] == row
        return None

    def _shared(self, branches: Branches, folds: list[tuple[int, Fold] | None]) -> None:
        """Enter the folds that other modes reach for modes that stopped before they were proved."""
        proved = [found for found in folds if found is not None]
        for k in np.flatnonzero(branches.stop == Stop.STEP).tolist():
            for row, fold in proved if folds[k] is None else ():
                near = row == branches.reached[k] and branches.fraction[k] <= fold.high
                if near and self._reaches(branches, k, fold):
                    folds[k] = row, fold
                    break

    def _follow_closely(self, branches: Branches, k: int) -> None:
        """Follow a branch in arcs, to the next row if that is possible, and from there as usual."""
        platform, row = self.platform, int(branches.reached[k])
        rows, part = (self.values[row], self.values[row + 1]), float(branches.fraction[k])
        way = follow_closely(platform.system, rows, branches.last[k], part, float(branches.near[k]))
        if way is None:
            return
        branches.last[k], branches.fraction[k], branches.near[k], count = way
        branches.segments[k] += count
        branches.tries[k] += count
        if branches.fraction[k] < 1:
            return
        rest = platform.follow(
            platform.internal(self.values[row + 1 :])[None],
            np.zeros(1, np.int64),
            branches.last[k][None],
            self.options,
            branches.near[[k]],
        )
        branches.points[k, row + 1 :] = rest.points[0]
        branches.segments[k] += rest.segments[0]
        branches.tries[k] += rest.tries[0]
        branches.reached[k] = row + 1 + max(rest.reached[0], 0)
        branches.stop[k] = Stop.STEP if rest.stop[0] == Stop.START else rest.stop[0]
        branches.fraction[k] = rest.fraction[0]
        # Where the row itself is as far as doubles go, the pose of the arcs is the nearer one.
        if rest.reached[0] > 0 or rest.fraction[0] > 0 or rest.stop[0] == Stop.END:
            branches.last[k], branches.near[k] = rest.last[0], rest.near[0]

    def _fold(self, branches: Branches, k: int) -> Fold | None:
        """Return a proved fold near the end of a branch, if there is one before the next row."""
        row, part, point = int(branches.reached[k]), float(branches.fraction[k]), branches.last[k]
        if row + 1 >= len(self.t):
            return None
        jacobian = self.platform.jacobian(point, self._value(row, part))
        direction = np.linalg.svd(np.vstack((jacobian, point)))[2][-1]
        rows = self.values[row], self.values[row + 1]
        fold = prove_fold(self.platform.system, rows, part, point, direction)
        if fold is None or fold.bends > 0 or not part <= fold.high <= 1:
            return None
        return fold

    def _reaches(self, branches: Branches, k: int, fold: Fold) -> bool:
        """Whether it is proved that a branch reaches a fold and no other fold before it."""
        part, near = float(branches.fraction[k]), float(branches.near[k])
        return bool(fold.sides(branches.last[k][None], part, near)[0])

    def _event(
        self,
        branches: Branches,
        folds: list[tuple[int, Fold] | None],
        numbers: NDArray[np.int64],
        k: int,
    ) -> Event:
        """Return the event at the end of a branch that ended early."""
        row, part = int(branches.reached[k]), float(branches.fraction[k])
        found = folds[k]
        mode = int(numbers[k])
        if found is None:
            point = branches.last[k]
            R, T = self.platform.poses(point)
            row = max(row, 0)
            low, high = self.time(row, part), self.time(row, 1.0)
            reason = self._seen(row, R, T) or NEARLY_SINGULAR
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

    def _seen(self, row: int, R: Array, T: Array) -> str | None:
        """Return the reason in words, from the pose at which following stopped, if there is one."""
        if not (np.isfinite(R).all() and np.isfinite(T).all()):
            return "the platform goes far away, to infinity"
        arrangement = Arrangement.of(self.platform.instance_at(self.values[row]))
        w, v = arrangement.placed(R, T).w, arrangement.v
        sines = np.linalg.norm(np.cross(w, v), axis=-1)
        for k, kind in enumerate(arrangement.kinds):
            if kind is DLL and sines[k] < NEARLY_PARALLEL_SINE:
                return f"the lines of constraint {k + 1} become parallel"
        distance = float(
            np.linalg.norm(T + R @ arrangement.platform_centre - arrangement.base_centre)
        )
        if distance > _FAR * arrangement.length:
            unit = self.instance.units.length
            return f"the platform goes far away, to {distance:.3g} {unit}"
        return None

    def _partner(self, branches: Branches, k: int, fold: Fold) -> tuple[Array, Array] | None:
        """Return the pose at the row before of the branch that meets this one in a fold."""
        row, part, point = int(branches.reached[k]), float(branches.fraction[k]), branches.last[k]
        mirrored = 2 * _unit(fold.point, point) - point
        here = self._value(row, part)
        back = np.stack((here, self._value(row, 0.0)))[None]
        found = self.platform.follow(back, np.zeros(1, np.int64), mirrored[None], self.options)
        start = found.points[0, 0]
        if found.stop[0] != Stop.END or (
            np.linalg.norm(start - point) < np.linalg.norm(start - mirrored)
        ):
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
    return overlap and bool(np.linalg.norm(a - _unit(second.point, a)) < SAME)


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
    platform = _moving(instance, rows, chosen)
    first = row_modes(instance, platform, rows[0], seed=seed, jobs=jobs)
    R, T, numbers = first.R, first.T, first.numbers
    platform = _moving(instance, rows, chosen, R)
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


def _moving(
    instance: Instance, rows: Array, chosen: Sequence[Coordinate], R: Array | None = None
) -> Platform:
    """Return a platform for following along rows of modes with the rotations R at the first."""
    if chosen:
        return MovingGeometry(over_rows(instance, rows), chosen)
    return MovingPlatform(over_rows(instance, rows) if R is None else along_rows(instance, rows, R))


def _same_poses(
    platform: Platform, first: tuple[Array, Array], second: tuple[Array, Array]
) -> NDArray[np.bool_]:
    """Return which of n poses are which of m poses, shape (n, m)."""
    # Study points are known up to sign.
    overlap = np.abs(platform.points(*first) @ platform.points(*second).T)
    return np.asarray(np.sqrt(np.maximum(0.0, 2 - 2 * overlap)) < SAME)


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
    arrived = ~np.isnan(forward.T[:, -1, 0])
    there = forward.R[arrived, -1], forward.T[arrived, -1]
    fresh = np.flatnonzero(~_same_poses(run.platform, (last.R, last.T), there).any(axis=1))
    complete = len(last.T) - len(fresh) == int(arrived.sum())
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
    """The real poses at a row."""

    #: The poses, shapes (n, 3, 3) and (n, 3), in the order of their numbers.
    R: Array
    T: Array
    #: Their numbers, shape (n,).
    numbers: NDArray[np.int64]
    #: The number of real poses for the stated values; modes with larger numbers are new.
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
    between = _moving(instance, rows, platform.chosen, R)
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
    same_pose = _same_poses(between, first, (R, T))
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
