"""A path from one pose to another: polygons, each straight part proved, and their time.

On straight ways of drives all cranks, slides and driven values change linearly. A mode is followed
along them by `MovingGeometry`, which proves that it exists, is regular and is the only one near.
Ranges are intervals, so a way keeps those that its ends keep; cones are proved by `limit_events`.
No drive passes a dead point: its transmission is proved not to be zero on the whole way.

Paths and ways between nodes of a map cost their length times the condition number.

Of straight ways of values the drives move linearly, so limits of speed and acceleration hold
exactly. On straight ways of poses the speeds and accelerations of drives, and of the turn of the
platform, are those at samples, with a margin. The platform stops at corners: on each straight part
its speed rises, stays and falls.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import field
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError, IncompleteError, NotFiniteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.home_mode import HomeMode, home_mode
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import condition_numbers, printed_conditions
from gspcli.geometry.readings import readings_of
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.following.branch_follower import FollowOptions, MovingGeometry, over_rows
from gspcli.motion.following.tracks import POSE, Run, Track, continuous_quaternions
from gspcli.motion.paths.between import (
    PathRows,
    cones_kept,
    keeps_working_modes,
    least_clearances,
    least_gaps,
    limit_events,
)
from gspcli.motion.paths.ways import PoseWays, ValueWays
from gspcli.motion.poses.inverse_kinematics import checked_poses, pose_parts, values_at
from gspcli.motion.poses.mode_filters import chosen_mode
from gspcli.records import Tabular, dataclass
from gspcli.solver import SolveResult, solve
from gspcli.solver.result import Solution
from gspcli.wording import counted

Array = NDArray[np.float64]
#: A mode by its number, ``home``, or a pose: (R, T), or a mode of a result.
End = int | str | tuple[ArrayLike, ArrayLike] | HomeMode | Solution


@dataclass(frozen=True, eq=False)
class PathEnd:
    """A pose with its values, and its name in messages."""

    #: Such as ``mode 3``.
    name: str
    #: Shape (6,), distances to planes signed, without offsets; of a mode the stated ones.
    values: Array
    #: The pose, shapes (3, 3) and (3,).
    R: Array
    T: Array

    @property
    def is_mode(self) -> bool:
        """Whether it is a mode of the stated values, with all drives where they are stated."""
        return self.name.startswith("mode ")


class Modes:
    """The real poses of a platform as ends of paths, solved when they are first needed.

    Parameters
    ----------
    instance
        The platform.
    solved
        Its poses, if they are known.
    """

    def __init__(self, instance: Instance, solved: SolveResult | None = None) -> None:
        self.instance = instance
        self._solved = solved

    def all(self) -> list[PathEnd]:
        """Return all modes, in the order of `solve`.

        Raises
        ------
        NotFiniteError, IncompleteError
            If they are infinitely many, or could not all be found.
        """
        if self._solved is None:
            self._solved = solve(self.instance)
        found = self._solved
        if found.verdict == "infinite":
            raise NotFiniteError(
                "the poses of the platform are infinitely many: give poses, not modes"
            )
        if found.verdict != "complete":
            raise IncompleteError(
                "the poses of the platform could not all be found: give poses, not modes"
            )
        R, T = found.R[found.real].real, found.T[found.real].real
        stated = Arrangement.of(self.instance).values
        values = np.where(values_at(self.instance, R, T) < 0, -stated, stated)
        return [
            PathEnd(f"mode {k}", *one) for k, one in enumerate(zip(values, R, T, strict=True), 1)
        ]

    def end(self, given: End, name: str) -> PathEnd:
        """Return an end as it is given.

        Parameters
        ----------
        given
            A number, ``home``, or a pose: (R, T), or a mode of a result.
        name
            Of the argument, for messages and for the name of a pose.
        """
        if isinstance(given, str) and given != "home":
            raise ArgumentError(
                f"found {given!r}, expected a number of solve, home, or a pose (R, T)", name
            )
        if isinstance(given, int | np.integer | str):
            modes = self.all()
            R = np.array([one.R for one in modes]).reshape(-1, 3, 3)
            T = np.array([one.T for one in modes]).reshape(-1, 3)
            number = None if isinstance(given, str) else int(given)
            return modes[chosen_mode(number, home_mode(self.instance, R, T), len(modes)) - 1]
        R, T = checked_poses(*pose_parts(given, name))
        if R.ndim != 2:
            raise ArgumentError(f"found {R.shape[:-2]} poses, expected one", name)
        return PathEnd(f"the {name}", values_at(self.instance, R, T), R, T)


Verdict = Literal["proved", "impossible", "not found"]
_EMPTY = np.zeros((0, 6))
#: Decimals of estimated costs: last digits must not choose a way.
_DECIMALS = 6
#: Moves that are smaller are rounding errors of equal poses, in lengths of the platform.
_STILL = 1e-12


@dataclass(frozen=True)
class PathPart:
    """A straight part of a path, or a rounded corner between two."""

    #: Its rows, from 0.
    first: int
    last: int
    #: How many pieces its proof has.
    pieces: int
    #: The way of the platform's points, as a root mean square, in the unit of length.
    length: float
    #: The largest condition number at its rows.
    condition: float
    #: A proved lower bound of the clearance of all its poses, between the rows, too; in the units
    #: of `gsp clearance`. 0 if nothing is proved.
    clearance: float
    #: A proved lower bound of the least gap between legs and bodies at all its poses, if one is
    #: asked for.
    gap: float | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the part as plain data; rows are counted from 1."""
        return {
            "rows": [self.first + 1, self.last + 1],
            "pieces": self.pieces,
            "length": self.length,
            "condition": self.condition if np.isfinite(self.condition) else None,
            "clearance": self.clearance,
            **({} if self.gap is None else {"gap": self.gap}),
        }


@dataclass(frozen=True, eq=False)
class PlannedPath(Tabular):
    """The answer of `gspcli.path`."""

    #: The platform.
    instance: Instance
    #: The ends in words, such as ``mode 3`` or ``the pose``.
    start: str
    goal: str
    #: ``proved``: the path is proved to be regular and to keep ranges and cones on the whole way.
    #: ``impossible``: it is proved that there is no such path. ``not found``: neither, in the time
    #: that was given.
    verdict: Verdict
    #: Why there is no path; empty if there is one.
    reason: str = ""
    #: Whether the values or position and angles change linearly between the rows.
    along: str = ""
    #: A number for each row: its part of the path, counted from 0, with the fraction; seconds if a
    #: speed was asked for. Shape (r,).
    t: Array = field(default_factory=lambda: np.zeros(0))
    #: The values at the rows, without offsets, shape (r, 6).
    values: Array = field(default_factory=lambda: _EMPTY)
    #: The poses, shapes (r, 3, 3) and (r, 3).
    R: Array = field(default_factory=lambda: np.zeros((0, 3, 3)))
    T: Array = field(default_factory=lambda: np.zeros((0, 3)))
    #: At the rows: condition numbers, and proved clearances, shapes (r,).
    conditions: Array = field(default_factory=lambda: np.zeros(0))
    clearances: Array = field(default_factory=lambda: np.zeros(0))
    #: The straight parts, and the rounded corners between them.
    parts: tuple[PathPart, ...] = ()
    #: What is known of the time; None without a speed.
    timing: Timing | None = None
    #: What the m drives of a machine with cranks or slides are at in the rows, lengths and radians,
    #: shape (r, m); else None.
    drives: Array | None = None
    #: The least gap between legs and bodies at the rows, shape (r,), if one is asked for.
    gaps: Array | None = None

    def __repr__(self) -> str:
        kinds = self.instance.name or self.instance.type.id
        found: str = self.verdict
        if self.parts:
            found += f", {counted(self.straight, 'straight part')}"
        return f"<PlannedPath of {kinds} from {self.start} to {self.goal}: {found}>"

    @property
    def straight(self) -> int:
        """The number of straight parts."""
        return len(self.parts)

    @property
    def length(self) -> float:
        """The way of the platform's points, as a root mean square, in the unit of length."""
        return sum(part.length for part in self.parts)

    @cached_property
    def straight_length(self) -> float:
        """How far the ends are from each other, by the same measure."""
        if not len(self.T):
            return 0.0
        ends = [0, -1]
        return float(steps(self.instance, self.R[ends], self.T[ends])[0])

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the columns of the drives: constraints, or cranks and slides."""
        return tuple("123456") if self.drives is None else Machine.of(self.instance).names

    def _readings(self) -> Array:
        if self.drives is None:
            return readings_of(self.instance, self.values)
        return Machine.of(self.instance).readings(self.drives)

    def rows(self, frame: PoseFrame = IDENTITY) -> list[dict[str, Any]]:
        """Return the rows as plain data: t, readings, pose, condition, clearance.

        Parameters
        ----------
        frame
            The frame in which poses are expressed.
        """
        if not len(self.t):
            return []
        R, T = frame.from_platform(self.R, self.T)
        keys = ("t", *self.columns, *POSE, "condition")
        # Those of cranks and slides take long: they are computed if they are asked for.
        known = self.drives is None or bool(self.clearances.any())
        clearances = [self.clearances] if known else []
        keys += ("clearance",) * len(clearances)
        gaps = [] if self.gaps is None else [self.gaps]
        keys += ("gap",) * len(gaps)
        numbers = np.column_stack(
            (
                self.t,
                self._readings(),
                T,
                continuous_quaternions(R[None])[0],
                printed_conditions(self.conditions),
                *clearances,
                *gaps,
            )
        )
        return [dict(zip(keys, row, strict=True)) for row in numbers.tolist()]

    def to_json(self, frame: PoseFrame = IDENTITY) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.path/1``.

        Parameters
        ----------
        frame
            The frame in which poses are expressed.
        """
        return {
            "schema": "gsp.path/1",
            **self.instance.to_json(),
            **({} if frame.is_identity else {"frames": frame.to_json()}),
            "from": self.start,
            "to": self.goal,
            "verdict": self.verdict,
            "reason": self.reason or None,
            "along": self.along or None,
            "length": self.length,
            "straight_length": self.straight_length,
            **({} if self.timing is None else {"timing": self.timing.to_json()}),
            "parts": [part.to_json() for part in self.parts],
            "rows": self.rows(frame),
        }


def steps(instance: Instance, R: Array, T: Array) -> Array:
    """Return how far the points of the platform move from row to row, shape (r - 1,).

    Root mean squares, in the unit of length; 0 where the poses differ by rounding errors only.
    """
    places = _places(instance, R, T)
    moved = np.sqrt((np.diff(places, axis=0) ** 2).sum(axis=2).mean(axis=1))
    return np.where(moved > _STILL * Arrangement.of(instance).length, moved, 0.0)


def cost(instance: Instance, R: Array, T: Array, power: float = 1.0) -> float:
    """Return the integral of a power of the condition number by the length of a path, in lengths.

    Parameters
    ----------
    instance
        The platform.
    R, T
        Poses along the path, shapes (r, 3, 3) and (r, 3).
    power
        Of the condition number; with 0 the cost is the length.
    """
    a = Arrangement.of(instance)
    regular = 1 / condition_numbers(Machine.of(instance).placed(R, T), R, T)
    if not regular.all():
        return np.inf
    # The harmonic mean between rows: 1 / condition is nearly linear.
    mean = 2 / (regular[1:] + regular[:-1])
    return float((steps(instance, R, T) * mean**power).sum() / a.length)


class WayCosts:
    """Estimated costs of ways between nodes, by the poses at their ends."""

    def __init__(self, instance: Instance) -> None:
        self.instance = instance
        self._arrangement = Arrangement.of(instance)
        self._places: list[Array] = []
        self._regular: list[float] = []

    def add(self, R: Array, T: Array) -> None:
        """Add nodes, shapes (n, 3, 3) and (n, 3)."""
        self._places += [*_places(self.instance, R, T)]
        conditions = condition_numbers(Machine.of(self.instance).placed(R, T), R, T)
        self._regular += (1 / conditions).tolist()

    def between(self, i: int, j: int) -> float:
        """Return the cost of a way between two nodes."""
        moved = self._places[j] - self._places[i]
        length = float(np.sqrt((moved**2).sum(axis=1).mean())) / self._arrangement.length
        return round(2 * length / max(self._regular[i] + self._regular[j], 1e-12), _DECIMALS)


def _places(instance: Instance, R: Array, T: Array) -> Array:
    """Return the points of the platform that count at poses, shape (n, m, 3)."""
    a = Arrangement.of(instance)
    own = a.y[a.distances] if len(a.distances) else a.y
    places: Array = own @ np.swapaxes(R, -1, -2) + T[:, None]
    return places


#: Rows of each straight part while paths are searched for and made smoother.
PROVED_ROWS = 12
#: Corners keep this part of a range away from its ends, so that rounding does not leave it.
_MARGIN = 1e-4
#: Digits of corners, relative to the sizes: files are short, and do not depend on last digits.
_DIGITS = 6


class GuideRows(NamedTuple):
    """Rows along a proved path."""

    part: NDArray[np.int64]
    """The straight part after each row, shape (r,); that of the last row is the last part."""
    fraction: Array
    """Where on its part each row is, shape (r,); the last row is at 1."""
    proofs: NDArray[np.int64]
    """How many pieces the proof of each straight part has, shape (parts,)."""
    rows: PathRows
    """The rows, with what holds between them."""


class RowsOnWay(NamedTuple):
    """Rows along a path before they are proved."""

    part: NDArray[np.int64]
    """The part after each row, shape (r,); that of the last row is the last part."""
    fraction: Array
    """Where on its part each row is, shape (r,); the last row is at 1."""
    numbers: Array
    """Values, or positions and angles, shape (r, 6)."""


class Guide(ABC):
    """Proves polygons between two poses, given by their corners.

    Attributes
    ----------
    along
        ``values``, ``drives`` or ``poses``.
    sizes
        How far corners may be moved, shape (6,).
    clear
        The clearance that every pose must have.
    gap
        The least gap between legs and bodies; None if gaps are not tested.
    """

    along: str
    sizes: Array

    def __init__(self, clear: float, gap: float | None) -> None:
        self.clear, self.gap = clear, gap

    def trace(self, corners: Array, rows: NDArray[np.int64]) -> GuideRows | None:
        """Return rows along a polygon, or None if it is not proved.

        Parameters
        ----------
        corners
            Shape (k + 1, 6).
        rows
            In how many steps each straight part is divided, shape (k,).
        """
        return self.through(on_polygon(corners, rows))

    @abstractmethod
    def through(self, given: RowsOnWay) -> GuideRows | None:
        """Return given rows with their poses, or None if the way through them is not proved."""

    def placed(self, corner: Array) -> Array:
        """Return a corner within the ranges, rounded."""
        return corner

    def widen(self, corners: Array) -> None:
        """Set how far values without a range may be moved, by those of a path."""
        del corners

    def unproved(self, corners: Array, rows: NDArray[np.int64]) -> tuple[Array, Array] | None:
        """Return poses along a polygon without a proof; None if they are found by following."""
        del corners, rows
        return None

    def _proved_rows(
        self, given: RowsOnWay, proofs: NDArray[np.int64], rows: PathRows
    ) -> GuideRows | None:
        """Return rows that are proved, or None if they do not keep clearance and gap."""
        clear, gap = self.clear, self.gap
        if clear and not (least_clearances(rows, clear)[1] >= clear).all():
            return None
        if gap is not None and not (least_gaps(rows, gap)[1] >= gap).all():
            return None
        return GuideRows(given.part, given.fraction, proofs, rows)


class ValueGuide(Guide):
    """Polygons of values.

    Parameters
    ----------
    ways
        Straight ways of values.
    first, last
        The Study points of both ends; None for an end that is not asked for.
    clear, gap
        As for `Guide`.
    """

    along = "values"

    def __init__(
        self,
        ways: ValueWays,
        first: Array,
        last: Array | None,
        clear: float = 0.0,
        gap: float | None = None,
    ) -> None:
        super().__init__(clear, gap)
        self.ways, self.first, self.last = ways, first, last
        self._low, self._high = ways.low.copy(), ways.high.copy()
        width = self._high - self._low
        finite = np.isfinite(width)
        self._low[finite] += _MARGIN * width[finite]
        self._high[finite] -= _MARGIN * width[finite]
        self.sizes = np.where(finite, width, 0.0)
        self._digits = _digits(self.sizes)

    def widen(self, corners: Array) -> None:
        """Set how far values without a range may be moved, by those of a path."""
        span = np.ptp(corners, axis=0)
        self.sizes = np.where(np.isfinite(self._high - self._low), self.sizes, span)
        self._digits = _digits(self.sizes)

    def through(self, given: RowsOnWay) -> GuideRows | None:
        """Return given rows with their poses, or None; see `Guide`."""
        part, values = given.part, given.numbers
        if not self.ways.kept(values).all():
            return None
        found = self.ways.follow(values[None], np.zeros(1, np.int64), self.first[None])
        points = found.points[0]
        if not found.there[0]:
            return None
        if self.last is not None and not self.ways.same(points[-1], self.last):
            return None
        R, T = self.ways.poses(points)
        proofs = _shared(int(found.parts[0]), np.bincount(part[:-1]))
        between = PathRows.of_values(self.ways, values, R, T)
        if not cones_kept(between):
            return None
        return self._proved_rows(given, proofs, between)

    def placed(self, corner: Array) -> Array:
        """Return a corner within the ranges, rounded."""
        inside = np.clip(corner, self._low, self._high)
        return np.array([round(x, d) for x, d in zip(inside, self._digits, strict=True)])


class PoseGuide(Guide):
    """Polygons of positions and angles.

    Parameters
    ----------
    ways
        Straight ways in position and angles.
    span
        How far positions may be moved.
    clear, gap
        As for `Guide`.
    """

    along = "poses"

    def __init__(
        self, ways: PoseWays, span: float, clear: float = 0.0, gap: float | None = None
    ) -> None:
        super().__init__(clear, gap)
        self.ways = ways
        self.sizes = np.array([span] * 3 + [1.0] * 3)
        self._digits = _digits(self.sizes)
        self._proved: dict[tuple[bytes, bytes], int] = {}

    def trace(self, corners: Array, rows: NDArray[np.int64]) -> GuideRows | None:
        """Return rows along a polygon, or None; see `Guide`."""
        proofs = []
        for first, last in pairwise(corners):
            key = first.tobytes(), last.tobytes()
            if key not in self._proved:
                proof = self.ways.prove(first, last)
                self._proved[key] = proof.cells if proof.sign else 0
            if not self._proved[key]:
                return None
            proofs.append(self._proved[key])
        return self._through(on_polygon(corners, rows), np.array(proofs))

    def through(self, given: RowsOnWay) -> GuideRows | None:
        """Return given rows with their poses, or None; see `Guide`."""
        proofs = np.zeros(int(given.part[-1]) + 1, np.int64)
        for part, (first, last) in zip(given.part.tolist(), pairwise(given.numbers), strict=False):
            proof = self.ways.prove(first, last)
            if not proof.sign:
                return None
            proofs[part] += proof.cells
        return self._through(given, proofs)

    def _through(self, given: RowsOnWay, proofs: NDArray[np.int64]) -> GuideRows | None:
        R, T = self.ways.poses(given.numbers)
        if np.isnan(self.ways.machine.along(R, T)).any():
            return None
        rows = PathRows.of_poses(self.ways, R, T, given.numbers)
        return self._proved_rows(given, proofs, rows)

    def placed(self, corner: Array) -> Array:
        """Return a corner, rounded."""
        return np.array([round(x, d) for x, d in zip(corner, self._digits, strict=True)])

    def unproved(self, corners: Array, rows: NDArray[np.int64]) -> tuple[Array, Array]:
        """Return poses along a polygon without a proof."""
        return self.ways.poses(on_polygon(corners, rows).numbers)

    def kept(self, R: Array, T: Array) -> NDArray[np.bool_]:
        """Return whether poses keep the limits, shape (n,)."""
        machine = self.ways.machine
        kept = machine.keeps(R, T)
        if self.gap is not None:
            low = ComparedShapes(self.ways.instance).bounds(R, T, machine.along(R, T)).low
            kept &= (low >= self.gap).all(axis=1)
        return kept


def _digits(sizes: Array) -> list[int]:
    positive = np.where(sizes > 0, sizes, 1.0)
    return [_DIGITS - int(x) for x in np.floor(np.log10(positive)).tolist()]


def on_polygon(corners: Array, rows: NDArray[np.int64]) -> RowsOnWay:
    """Return rows along a polygon, evenly on each straight part; arguments as for `Guide.trace`."""
    part = np.append(np.repeat(np.arange(len(rows)), rows), len(rows) - 1)
    fraction = np.append(np.concatenate([np.arange(n) / n for n in rows.tolist()]), 1.0)
    first, last = corners[part], corners[part + 1]
    found = first + (last - first) * fraction[:, None]
    found[-1] = corners[-1]
    return RowsOnWay(part, fraction, found)


def _shared(count: int, rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Share the pieces of a proof among the parts of a path by their rows."""
    ends = np.round(np.cumsum(rows) * (count / rows.sum())).astype(np.int64)
    return np.maximum(np.diff(np.concatenate(([0], ends))), 1)


class DriveGuide(Guide):
    """Straight ways of drives between two poses.

    Parameters
    ----------
    machine
        The drives of the platform.
    start, goal
        The ends.
    clear
        The clearance of the drives that every pose must have.
    gap
        The least gap between legs and bodies; None if gaps are not tested.
    """

    along = "drives"

    def __init__(
        self,
        machine: Machine,
        start: PathEnd,
        goal: PathEnd,
        clear: float = 0.0,
        gap: float | None = None,
    ) -> None:
        self.machine, self.start, self.goal = machine, start, goal
        super().__init__(clear, gap)
        drives = machine
        moved = np.flatnonzero(drives.moved).tolist()
        self._chosen = choose(machine.instance, [drives.names[k] for k in moved])
        self._moved = moved
        self.sizes = np.ones(drives.count)

    @property
    def corners(self) -> Array:
        """The numbers of the drives at both ends, in the units of the instance, (2, m)."""
        R, T = (np.stack([getattr(end, n) for end in (self.start, self.goal)]) for n in ("R", "T"))
        found: Array = self.machine.along(R, T) / self.machine.units
        return found

    def through(self, given: RowsOnWay) -> GuideRows | None:
        """Return given rows with their poses, or None if the way through them is not proved."""
        drives = self.machine
        q = given.numbers * drives.units
        followed = self._followed(given.numbers)
        if followed.events or np.isnan(followed.T).any() or limit_events(followed):
            return None
        R, T = followed.R[0], followed.T[0]
        geometry = MovingGeometry(followed.followed, self._chosen)
        ends = ValueWays.same(*(geometry.points(*one) for one in self._ends(R, T)))
        if not ends.all():
            return None
        rows = PathRows.of_drives(self.machine, geometry.rows, q, R, T)
        if not keeps_working_modes(rows):
            return None
        proofs = _shared(followed.segments, np.bincount(given.part[:-1]))
        return self._proved_rows(given, proofs, rows)

    def _ends(self, R: Array, T: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        first, last = self.start, self.goal
        wanted = np.stack((first.R, last.R)), np.stack((first.T, last.T))
        return (R[[0, -1]], T[[0, -1]]), wanted

    def _followed(self, numbers: Array) -> Track:
        """Follow the mode of the start along rows of drives, in the units of the instance."""
        instance, drives = self.machine.instance, self.machine
        a = Arrangement.of(instance)
        stated = np.where(a.sides < 0, -a.values, a.values)
        values = np.tile(stated, (len(numbers), 1))
        for k in range(drives.count):
            if not drives.moved[k]:
                values[:, drives.users(k)[0]] = numbers[:, k]
        rows = np.column_stack((values, numbers[:, self._moved]))
        geometry = MovingGeometry(over_rows(instance, rows), self._chosen)
        run = Run(instance, geometry, np.arange(1.0, len(rows) + 1), rows, FollowOptions())
        return run.follow(self.start.R[None], self.start.T[None], np.ones(1, np.int64))


#: What can be limited: each drive, the pivot, the turn of the platform.
DRIVES, PLATFORM, TURN = NAMES = ("drives", "platform", "turn")
#: The least rows of a part.
_CHANGING = 12
#: Shares of the acceleration that full speed may need on a bent way of the drives.
_BENT = (0.02, 0.1, 0.25, 0.5, 0.75, 0.9)
#: Speeds and accelerations are this much larger than what is computed exactly, or from samples.
_RATE_MARGIN, _SAMPLED = 1 + 1e-9, 1 + 1e-5
#: Samples of a move of a pose; the step of differences, in sizes of the platform.
_SAMPLES, _STEP = 400, 1e-4


@dataclass(frozen=True)
class PathLimits:
    """Limits of speeds and accelerations."""

    #: By name: of each of the ``drives`` (lengths, or angles in the unit of the instance), of the
    #: ``platform``'s pivot (lengths), of its ``turn`` (angles); a second, and a second squared.
    speed: Mapping[str, float]
    acceleration: Mapping[str, float]

    @classmethod
    def of(
        cls,
        speed: float | Mapping[str, float] | None,
        acceleration: float | Mapping[str, float] | None,
    ) -> PathLimits | None:
        """Return limits from numbers, which are of the drives, or by name; None without any.

        Raises
        ------
        ArgumentError
            If only one is given, a number is not positive, or something would be unlimited.
        """
        if speed is None and acceleration is None:
            return None
        both = {"speed": speed, "acceleration": acceleration}
        found = {}
        for name, given in both.items():
            if given is None:
                raise ArgumentError(
                    "found none: a path is timed by a speed and an acceleration", name
                )
            limits = dict(given) if isinstance(given, Mapping) else {DRIVES: float(given)}
            for what, number in limits.items():
                if what not in NAMES:
                    raise ArgumentError(
                        f"found {what!r}, expected {', '.join(NAMES[:-1])} or {TURN}", name
                    )
                if not (np.isfinite(number) and number > 0):
                    raise ArgumentError(
                        f"found {number} for {what}, expected a number above zero", name
                    )
            if DRIVES not in limits and not {PLATFORM, TURN} <= set(limits):
                raise ArgumentError(
                    "found no limit of the drives, nor of both the platform and its turn", name
                )
            found[name] = limits
        return cls(**found)

    @property
    def of_platform(self) -> bool:
        """Whether the platform is limited, too, not only the drives."""
        return bool({*self.speed, *self.acceleration} - {DRIVES})

    def arrays(self, drives: int, in_radians: float) -> tuple[Array, Array]:
        """Return the limits in the order of `largest_rates`, infinite where there is none."""
        units = [1.0] * drives + [1.0, in_radians]
        names = [DRIVES] * drives + [PLATFORM, TURN]
        speed, acceleration = (
            np.array([limits.get(n, np.inf) * u for n, u in zip(names, units, strict=True)])
            for limits in (self.speed, self.acceleration)
        )
        return speed, acceleration


@dataclass(frozen=True, eq=False)
class Timing:
    """The time of a path."""

    #: What was asked for.
    limits: PathLimits
    #: The moves, in values or in positions and angles.
    moves: Moves

    @property
    def seconds(self) -> float:
        """How long the path takes."""
        return self.moves.seconds

    def to_json(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {
            "seconds": self.seconds,
            "speed": dict(self.limits.speed),
            "acceleration": dict(self.limits.acceleration),
            "corners": len(self.moves.tops) - 1,
        }


def _value_line(way: Array, speed: Array, acceleration: Array) -> LineMove:
    """Return a straight part of drives that move linearly."""
    duration = float((np.abs(way) / speed).max()) * _RATE_MARGIN
    with np.errstate(divide="ignore"):
        rise = float((acceleration * duration / np.abs(way)).min()) / _RATE_MARGIN
    return LineMove(way, duration, rise)


def largest_rates(ways: PoseWays, place: Array, way: Array) -> tuple[Array, Array]:
    """Return the largest speeds and accelerations at samples of a straight way in one second.

    Parameters
    ----------
    ways
        The ways of poses of a platform.
    place, way
        Its beginning, and how far the parameters change, shape (6,) each.

    Returns
    -------
    speeds, accelerations
        Of the m drives in the units of the instance, of the pivot, and of the turn of the platform
        in radians, shapes (m + 2,). Infinite where a drive does not reach.
    """
    step = _STEP / max(float((np.abs(way) / ways.sizes).max()), 1e-300)
    middles = np.linspace(0.0, 1.0, _SAMPLES + 1)[:, None]
    t = (middles + step * np.array([-1.0, 0.0, 1.0])).ravel()[:, None]
    R, T = ways.poses(place + way * t)
    x = (ways.machine.along(R, T) / ways.machine.units).reshape(len(middles), 3, -1)
    R = R.reshape(-1, 3, 3, 3)
    before, after = (R[:, k].swapaxes(1, 2) @ R[:, k + 1] for k in range(2))
    first, second = (_spin(one) for one in (before, after))
    speeds = [
        np.abs(x[:, 2] - x[:, 0]) / (2 * step),
        np.full((len(middles), 1), np.linalg.norm(way[:3])),
        np.linalg.norm(first + second, axis=1)[:, None] / (2 * step),
    ]
    bends = [
        np.abs(x[:, 2] - 2 * x[:, 1] + x[:, 0]) / step**2,
        np.zeros((len(middles), 1)),
        np.linalg.norm(second - first, axis=1)[:, None] / step**2,
    ]
    both = (np.concatenate(parts, axis=1).max(axis=0) for parts in (speeds, bends))
    fastest, most = (np.where(np.isnan(one), np.inf, one * _SAMPLED) for one in both)
    return fastest, most


def _spin(turns: Array) -> Array:
    """Return the vectors of small rotations, ``(n, 3, 3) -> (n, 3)``."""
    odd = (turns - turns.swapaxes(1, 2)) / 2
    return np.stack((odd[:, 2, 1], odd[:, 0, 2], odd[:, 1, 0]), axis=1)


def _pose_line(ways: PoseWays, first: Array, way: Array, v: Array, a: Array) -> LineMove:
    """Return a straight part in position and angles: drives at samples."""
    speeds, bends = largest_rates(ways, first, way)
    best, time = LineMove(way, np.inf, 0.0), np.inf
    for share in _BENT:
        duration = max(float((speeds / v).max()), float(np.sqrt((bends / (share * a)).max())))
        duration *= _RATE_MARGIN
        with np.errstate(divide="ignore", invalid="ignore"):
            left = (a - bends / duration**2) * duration / speeds
        rise = float(np.fmin(left, np.inf).min()) / _RATE_MARGIN
        quick = rise * duration >= 1
        here = duration + 1 / rise if quick else 2 * np.sqrt(duration / rise)
        if here < time:
            best, time = LineMove(way, duration, rise), here
    if not np.isfinite(time):
        raise ArgumentError("a drive does not reach the path", "speed")
    return best


def timed(
    guide: Guide, corners: Array, limits: PathLimits, counts: NDArray[np.int64]
) -> tuple[GuideRows, Array, Timing] | None:
    """Return rows along a path, their times, shape (r,), and the timing; None if not proved.

    Parameters
    ----------
    guide
        Proves paths.
    corners
        Those of a proved path, shape (k + 1, 6); the platform stops at them.
    limits
        Of speeds and accelerations.
    counts
        About how many rows each straight part has, shape (k,).
    """
    moving = [k for k in range(len(counts)) if np.any(corners[k] != corners[k + 1])]
    places = np.stack([corners[0], *(corners[k + 1] for k in moving)])
    if not moving:
        trace = guide.trace(corners, counts)
        still = Moves(*np.zeros((2, 1)), *np.zeros((3, 0)))
        return None if trace is None else (trace, 0.0 * trace.fraction, Timing(limits, still))
    if isinstance(guide, PoseGuide):
        ways = guide.ways
        v, a = limits.arrays(ways.machine.count, ways.instance.units.angle.in_radians)
        lines = [_pose_line(ways, x, y - x, v, a) for x, y in pairwise(places)]
    else:
        v, a = (one[: guide.sizes.size] for one in limits.arrays(guide.sizes.size, 1.0))
        lines = [_value_line(y - x, v, a) for x, y in pairwise(places)]
    moves = moves_of(places, lines)
    times = [
        np.linspace(begin, end, max(int(n), _CHANGING) + 1)[:-1]
        for (begin, end), n in zip(pairwise(moves.begins), counts[moving], strict=True)
    ]
    t = np.append(np.concatenate(times), moves.seconds)
    numbers, part = moves.at(t)
    numbers[-1] = places[-1]
    fraction = (t - moves.begins[part]) / np.diff(moves.begins)[part]
    trace = guide.through(RowsOnWay(np.asarray(part, np.int64), fraction, numbers))
    return None if trace is None else (trace, t, Timing(limits, moves))


class LineMove(NamedTuple):
    """A straight part with its limits."""

    way: Array
    """From its first to its last corner, shape (d,), not zero."""
    duration: float
    """How long it takes at the full velocity ``way / duration``."""
    rise: float
    """How quickly the rate, 1 at the full velocity, may change, a second."""


@dataclass(frozen=True, eq=False)
class Moves:
    """Straight parts, one after the other, each from rest to rest."""

    #: When each part begins, and at last when all end, shape (k + 1,).
    begins: Array
    #: Where each begins, and where it leads from there, shapes (k, d).
    places: Array
    ways: Array
    #: Its largest rate, and how quickly the rate changes, shape (k,).
    tops: Array
    rises: Array

    @property
    def seconds(self) -> float:
        """How long all moves take."""
        return float(self.begins[-1])

    def at(self, times: Array) -> tuple[Array, NDArray[np.intp]]:
        """Return the places at times, shape (r, d), and on which parts they are."""
        part = np.searchsorted(self.begins[1:-1], times, side="right")
        span = np.diff(self.begins)[part]
        up = self.tops[part] / self.rises[part]
        since = times - self.begins[part]
        near = np.minimum(since, span - since)
        # The way from the nearer end, by the whole way: a parabola, then a line.
        gone = self.rises[part] * np.minimum(near, up) ** 2 / 2
        gone = gone + self.tops[part] * np.maximum(near - up, 0.0)
        whole = self.tops[part] * (span - up)
        share = np.where(since <= span / 2, gone, whole - gone) / whole
        return self.places[part] + self.ways[part] * share[:, None], part


def moves_of(places: Array, lines: list[LineMove]) -> Moves:
    """Return the moves along straight parts; the corners are of shape (k + 1, d)."""
    durations = np.array([line.duration for line in lines])
    rises = np.array([line.rise for line in lines])
    tops = np.minimum(1.0, np.sqrt(rises * durations))
    spans = durations / tops + tops / rises
    ways = np.array([line.way for line in lines])
    return Moves(np.append(0.0, np.cumsum(spans)), places[:-1], ways, tops, rises)
