"""Polygons of values, drives or poses, each straight part proved.

On straight ways of drives all cranks, slides and driven values change linearly. A mode is followed
along them by `MovingGeometry`, which proves that it exists, is regular and is the only one near.
Ranges are intervals, so a way keeps those that its ends keep; cones are proved by `limit_events`.
No drive passes a dead point: each half of the way between two rows is in a box about the row at its
end in which all drives are proved to keep their working modes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose
from gspcli.geometry.enclosures import above
from gspcli.geometry.limits import machine_keeps
from gspcli.geometry.machine import Machine
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.following.branch_follower import FollowOptions, over_rows
from gspcli.motion.following.branch_runs import Run
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.tracks import Track
from gspcli.motion.paths.between import PathRows, cones_kept, least_clearances, least_gaps
from gspcli.motion.paths.ends import PathEnd
from gspcli.motion.paths.limit_events import limit_events
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.value_ways import ValueWays
from gspcli.motion.singularities.neighbourhoods import MachineNeighbourhood

Array = NDArray[np.float64]
#: Rows of each straight part while paths are searched for and made smoother.
PROVED_ROWS = 12
#: Corners keep this part of a range away from its ends, so that rounding does not leave it.
_MARGIN = 1e-4
#: Digits of corners, relative to the sizes: files are short, and do not depend on last digits.
_DIGITS = 6
#: How often steps between rows are halved at most for working modes to be proved.
_HALVINGS = 5


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
        between = PathRows(self.ways, values, R, T)
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
        machine = self.ways.machine
        if np.isnan(machine.along(R, T)).any():
            return None
        rows = PathRows(self.ways, machine.values(R, T), R, T, given.numbers)
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
        kept = machine_keeps(machine, R, T)
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
    ways
        Straight ways of poses of the platform, for the rows.
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
        ways: PoseWays,
        start: PathEnd,
        goal: PathEnd,
        clear: float = 0.0,
        gap: float | None = None,
    ) -> None:
        self.machine, self.ways, self.start, self.goal = machine, ways, start, goal
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
        proofs = np.zeros(int(given.part[-1]) + 1, np.int64)
        for k, part in enumerate(given.part[:-1].tolist()):
            pieces = self._keeps_working_modes(given.numbers[k : k + 2], R[k], T[k], _HALVINGS)
            if not pieces:
                return None
            proofs[part] += pieces
        rows = PathRows(self.ways, followed.values, R, T, numbers=q, geometry=geometry)
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

    def _keeps_working_modes(self, numbers: Array, R: Array, T: Array, halvings: int) -> int:
        """Return in how many boxes after a row working modes are proved to be kept; else 0."""
        drives = self.machine
        q = numbers * drives.units
        near = MachineNeighbourhood(drives, R, T, q[0])
        widths = near.widths(above(np.abs(q[1] - q[0])[drives.index]))[None]
        if near.keeps_working_modes(widths, near.box(widths))[0]:
            return 1
        if not halvings:
            return 0
        there = self._middle(q, R, T)
        if there is None:
            return 0
        middle = numbers.mean(axis=0)
        first = self._keeps_working_modes(np.stack((numbers[0], middle)), R, T, halvings - 1)
        second = first and self._keeps_working_modes(
            np.stack((middle, numbers[1])), *there, halvings - 1
        )
        return first + second if second else 0

    def _middle(self, q: Array, R: Array, T: Array) -> tuple[Array, Array] | None:
        """Return the pose in the middle of a way of drives from a pose; None if it is not found.

        Parameters
        ----------
        q
            The drives at both ends, shape (2, m).
        R, T
            The pose at the first.
        """
        numbers = np.stack((q[0], q.mean(axis=0))) / self.machine.units
        begin = PathEnd("", np.zeros(6), R, T)
        followed = DriveGuide(self.machine, self.ways, begin, begin)._followed(numbers)
        if followed.events or np.isnan(followed.T).any():
            return None
        return followed.R[0, -1], followed.T[0, -1]
