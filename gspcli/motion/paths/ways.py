"""Straight ways, proved regular and within the limits.

On a straight way of values all values change linearly, as drives move them. Ranges are intervals,
so the whole way keeps those that both its ends keep. A mode is followed along it by
`MovingPlatform.follow`, which proves that it exists, is regular and is the only one near. A
distance of two lines must not be zero on the way: there the value turns, and the mode could
continue as one of two.

On a straight way of poses the position of the pivot and three angles change linearly, as a
controller of six axes moves them. The box of parameters between its ends is divided by the grid of
`PoseBoxes.judge`; the cells on the diagonal contain the whole way. So if all of them keep the
limits and contain no singular pose, so does the way. Cells that are not proved are halved.

A mode may fill the box of its ranges: one pose for each set of values in the box. If that is so, it
is regular on the whole box. Its poses are open and closed among all poses whose values are in the
ranges. So no path within the ranges leads from it to another mode, not even through singular poses,
and every straight way of values is a path of it. The proof is that of
`gspcli.motion.singularities.neighbourhoods`: boxes too large for it are halved, and the mode is
followed to their centres.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DHP, DLL, DPH
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.enclosures import above
from gspcli.geometry.euler import euler_from_rotation
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import apply
from gspcli.motion.following.branch_follower import FollowOptions, MovingPlatform, Stop, apart
from gspcli.motion.following.follower import RowFollower
from gspcli.motion.following.tracks import SAME
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.singularities.neighbourhoods import Neighbourhood
from gspcli.motion.workspace.pose_boxes import NEGATIVE, PARAMETERS, PoseBoxes
from gspcli.records import dataclass

Array = NDArray[np.float64]
Index = NDArray[np.int64]
#: A mode that needs more halvings of a way is not followed further: it is nearly singular.
_HALVINGS = 14
#: The most boxes that are tested, and how many at a time.
_MOST, _PIECE = 4000, 256


class Arrived(NamedTuple):
    """The results of following modes along ways with r rows each."""

    there: NDArray[np.bool_]
    """Which are proved on the whole way, shape (n,)."""
    points: Array
    """Their Study points of norm one at the rows, shape (n, r, 8); NaN after the end of a mode."""
    parts: Index
    """How many parts were proved, shape (n,)."""


class ValueWays:
    """Straight ways of the values of one platform.

    Parameters
    ----------
    instance
        The platform with its limits, without offsets of readings; its values are not used.
    signs
        The signs of the values, shape (6,), for constraints whose side is open.
    """

    def __init__(self, instance: Instance, signs: Array) -> None:
        self.instance, self.machine = instance, Machine.of(instance)
        self.platform = MovingPlatform(apart(instance))
        #: The range of each value, infinite if there is none, shape (6,).
        self.low, self.high = _ranges(instance, signs)
        self.cones = self.machine.cones
        self._lines = np.array([row.kind is DLL for row in instance.constraints])

    @cached_property
    def follower(self) -> RowFollower:
        """The step with which the segments of ways are proved."""
        return RowFollower(self.platform.instance, ())

    @property
    def ranged(self) -> bool:
        """Whether each value has a range."""
        return bool(np.isfinite(self.low).all() and np.isfinite(self.high).all())

    def points(self, R: Array, T: Array) -> Array:
        """Return Study points of norm one of poses, ``(n, 3, 3), (n, 3) -> (n, 8)``."""
        return self.platform.points(R, T)

    def poses(self, points: Array) -> tuple[Array, Array]:
        """Return the poses (R, T) of Study points."""
        return self.platform.poses(points)

    def values(self, R: Array, T: Array) -> Array:
        """Return the values at poses, distances to planes signed, shape (n, 6)."""
        return values_at(self.instance, R, T)

    def kept(self, values: Array) -> NDArray[np.bool_]:
        """Return which sets of values are in the ranges, ``(..., 6) -> (...)``."""
        room = 1e-12 * np.maximum(np.abs(self.low), np.abs(self.high))
        room = np.where(np.isfinite(room), room, 0.0)
        inside = (values >= self.low - room) & (values <= self.high + room)
        return np.asarray(inside.all(axis=-1) & (values[..., self._lines] > 0).all(axis=-1))

    def follow(self, values: Array, which: Index, points: Array) -> Arrived:
        """Follow modes along ways; all rows must be in the ranges.

        Parameters
        ----------
        values
            The rows of the ways, shape (w, r, 6).
        which
            The way of each mode, shape (n,).
        points
            Study points of the modes at the first rows, shape (n, 8).
        """
        if not len(points):
            nothing = np.zeros((0, values.shape[1], 8))
            return Arrived(np.zeros(0, bool), nothing, np.zeros(0, np.int64))
        found = self.platform.follow(
            self.platform.internal(values), which, points, FollowOptions(most_halvings=_HALVINGS)
        )
        kept = np.asarray(self.kept(values)).all(axis=1)
        there = np.asarray(found.stop == Stop.END) & np.asarray(kept)[which]
        return Arrived(there, found.points, found.segments)

    @staticmethod
    def same(a: Array, b: Array) -> NDArray[np.bool_]:
        """Return whether Study points are the same pose; each pose has two, ``(..., 8)``."""
        away = np.minimum(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
        return np.asarray(away < SAME)


def _ranges(instance: Instance, signs: Array) -> tuple[Array, Array]:
    """Return the ends of the ranges of values; those of an open side by the signs."""
    low, high = np.full(6, -np.inf), np.full(6, np.inf)
    for k, row in enumerate(instance.constraints):
        if row.limits is None:
            continue
        least, most = (limit.value for limit in row.limits)
        if row.kind in (DPH, DHP) and row.side is Side.BOTH and least == 0.0:
            least = -most
        elif row.kind in (DPH, DHP) and (
            row.side is Side.NEGATIVE or (row.side is Side.BOTH and signs[k] < 0)
        ):
            least, most = -most, -least
        low[k], high[k] = least, most
    return low, high


def fills_ranges(ways: ValueWays, values: Array, point: Array) -> bool:
    """Return whether a mode is proved to fill the box of ranges.

    Parameters
    ----------
    ways
        Straight ways of values; each value must have a range.
    values, point
        Its values, shape (6,), and its Study point of norm one, shape (8,).
    """
    middle, half = (ways.low + ways.high) / 2, (ways.high - ways.low) / 2
    first = ways.follow(np.stack((values, middle))[None], np.zeros(1, np.int64), point[None])
    if not first.there[0]:
        return False
    centres, halves, points = middle[None], half[None], first.points[:, -1]
    boxes = 0
    while len(centres):
        # The smallest boxes first, so that few are kept.
        order = np.argsort(halves.prod(axis=1), kind="stable")
        now, later = order[:_PIECE], order[_PIECE:]
        c, h, p = centres[now], halves[now], points[now]
        centres, halves, points = centres[later], halves[later], points[later]
        boxes += len(c)
        if boxes > _MOST:
            return False
        near = Neighbourhood(ways.platform, p, ways.platform.internal(c))
        box = near.box(above(ways.platform.internal(h)))
        open_ = ~(box.measure < 1)
        if not open_.any():
            continue
        c, h, p = c[open_], h[open_], p[open_]
        axis = np.linalg.norm(box.shifts[open_], axis=2).argmax(axis=1)
        each = np.arange(len(c))
        h = h.copy()
        h[each, axis] /= 2
        step = np.zeros_like(h)
        step[each, axis] = h[each, axis]
        goals = np.concatenate((c - step, c + step))
        rows = np.stack((np.concatenate((c, c)), goals), axis=1)
        moved = ways.follow(rows, np.arange(len(rows)), np.concatenate((p, p)))
        if not moved.there.all():
            return False
        centres = np.concatenate((centres, goals))
        halves = np.concatenate((halves, h, h))
        points = np.concatenate((points, moved.points[:, -1]))
    return True


#: A way is divided at first until no angle of a piece changes by more, in radians.
_TURN = 0.5
#: Most cells of a piece that may be open, and most times that a piece is halved besides.
_MOST_OPEN, _MOST_CUTS = 256, 4
#: Half the width of the box about a pose whose sign is asked for, relative to the sizes.
_NEAR = 1e-9


@dataclass(frozen=True)
class WayProof:
    """What is proved of a straight way."""

    #: The sign of the determinant of the Jacobian matrix on the whole way, 1 or -1; 0 if the way is
    #: not proved.
    sign: int
    #: How many cells are proved.
    cells: int
    #: Why the way is not proved, in words; empty if it is.
    reason: str = ""
    #: Whether it is proved that some pose of the way is singular or violates a limit.
    violated: bool = False
    #: Whether rods that share a motor are not parallel on the way.
    shared: bool = False


class PoseWays:
    """Straight ways in position and angles of one platform.

    Parameters
    ----------
    instance
        The platform with its limits.
    pivot
        The point of the platform whose position is a parameter, shape (3,); the centre of its
        points if None.
    sequence
        The order of the axes of the angles, as in `gspcli.geometry.euler`.
    limits
        Whether ranges and cones must be kept, too.
    working_modes
        The signs of the gains of cranks and slides, shape (6,). If None they are those of the
        stated home, or, without one, those of the unmoved platform.
    """

    def __init__(
        self,
        instance: Instance,
        *,
        pivot: ArrayLike | None = None,
        sequence: str = "ZYX",
        limits: bool = True,
        working_modes: NDArray[np.int64] | None = None,
    ) -> None:
        self.instance = instance
        arrangement = Arrangement.of(instance)
        self.pivot = np.asarray(arrangement.platform_centre if pivot is None else pivot, float)
        self.boxes = PoseBoxes(
            instance, np.eye(3), np.zeros(3), pivot=self.pivot, sequence=sequence, regular=True,
            working_modes=working_modes,
        )  # fmt: skip
        #: The machine, in the working modes of all ways.
        self.machine = self.boxes.machine
        self._conditions = self.boxes.conditions if limits else self.boxes.reached
        #: Sizes of the six parameters: lengths of the platform, and radians.
        self.sizes = np.array([arrangement.length] * 3 + [1.0] * 3)

    def arrangement(self, R: Array, T: Array) -> Arrangement:
        """Return the platform at poses: points of cranks and slides are where they reach them."""
        return self.machine.placed(R, T)

    def _is_apart(self, begin: Array, end: Array) -> str:
        """Return why rods that share a drive may not agree on a way, or nothing."""
        if not self.machine.shared:
            return ""
        free = [name for name, a, b in zip(PARAMETERS, begin, end, strict=True) if a != b]
        try:
            self.boxes.refuse_shared(self.poses(begin)[0], free)
        except ArgumentError:
            return "rods that share a drive are not parallel"
        return ""

    def parameters(self, R: ArrayLike, T: ArrayLike) -> Array:
        """Return the parameters of poses, ``(..., 3, 3), (..., 3) -> (..., 6)``.

        The middle one of the angles is between -pi/2 and pi/2, see `euler_from_rotation`.
        """
        R, T = np.asarray(R, float), np.asarray(T, float)
        place = T + apply(R, np.broadcast_to(self.pivot, T.shape))
        return np.concatenate((place, euler_from_rotation(self.boxes.sequence, R)), axis=-1)

    def poses(self, parameters: Array) -> tuple[Array, Array]:
        """Return the poses (R, T) of parameters, ``(..., 6) -> (..., 3, 3), (..., 3)``."""
        return self.boxes.poses(parameters)

    def nearest(self, parameters: Array, goals: Array) -> Array:
        """Return the parameters of the same poses as goals that are nearest to some, (..., 6).

        Angles may differ by whole turns; and each rotation has two triples of angles, one with the
        middle angle beyond a right angle.
        """
        middle = PARAMETERS.index(self.boxes.middle)
        other = goals.copy()
        other[..., 3:] += np.pi
        other[..., middle] = np.pi - goals[..., middle]
        found = []
        for one in (goals, other):
            turned = one.copy()
            away = one[..., 3:] - parameters[..., 3:]
            turned[..., 3:] -= 2 * np.pi * np.round(away / (2 * np.pi))
            found.append(turned)
        far = [np.abs(one - parameters)[..., 3:].sum(axis=-1) for one in found]
        return np.where((far[0] <= far[1])[..., None], found[0], found[1])

    def continued(self, R: Array, T: Array) -> Array:
        """Return the parameters of rows of poses, each continued from the one before, (r, 6)."""
        found = self.parameters(R, T)
        for k in range(1, len(found)):
            found[k] = self.nearest(found[k - 1], found[k])
        return found

    def prove(self, begin: Array, end: Array) -> WayProof:
        """Prove the straight way between two sets of parameters, shape (6,) each."""
        reason = self._is_apart(begin, end)
        if reason:
            return WayProof(0, 0, reason, shared=True)
        steps = max(1, int(np.ceil(np.abs(end - begin)[3:].max() / _TURN)))
        knots = begin + (end - begin) * (np.arange(steps + 1) / steps)[:, None]
        knots[-1] = end
        # The last piece is the first one of the stack.
        pieces = [(knots[k], knots[k + 1], 0) for k in range(steps)][::-1]
        sign = cells = 0
        while pieces:
            first, last, cuts = pieces.pop()
            found = self._piece(first, last)
            if not found.sign:
                if found.violated or cuts == _MOST_CUTS:
                    return found
                half = (first + last) / 2
                pieces += [(half, last, cuts + 1), (first, half, cuts + 1)]
                continue
            if sign * found.sign < 0:
                return WayProof(0, cells, "singularity", violated=True)
            sign, cells = found.sign, cells + found.cells
        return WayProof(sign, cells)

    def _piece(self, begin: Array, end: Array) -> WayProof:
        """Prove a piece on one grid."""
        way = end - begin
        free = np.flatnonzero(way).tolist()
        if not free:
            return self.at(begin)
        bounds = np.stack((np.minimum(begin, end), np.maximum(begin, end)), axis=1)
        bits = min(64 // len(free), 20)
        top = np.uint64(64 // len(free))
        mask = np.uint64((1 << int(top)) - 1) if len(free) > 1 else ~np.uint64(0)
        index, left = np.zeros(1, np.uint64), np.array([self._conditions])
        signs: set[int] = set()
        cells = 0
        for level in range(bits + 1):
            last = np.uint64((1 << level) - 1)
            keys = np.zeros(len(index), np.uint64)
            for place, k in enumerate(free):
                keys |= (index if way[k] > 0 else last - index) << np.uint64(place * int(top))
            found = self.boxes.judge(bounds, free, level, keys, left, split=False)
            cells += len(found.inside)
            signs.update((found.inside_signs & NEGATIVE).tolist())
            if len(found.inside) + len(found.open) < len(index):
                return WayProof(0, cells, "limit", violated=True)
            if len(signs) > 1:
                return WayProof(0, cells, "singularity", violated=True)
            if not len(found.open):
                return WayProof(-1 if signs.pop() else 1, cells)
            if len(found.open) > _MOST_OPEN:
                break
            index = found.open & mask
            if way[free[0]] < 0:
                index = last - index
            left = found.open_left & ~NEGATIVE
            index, left = np.concatenate((2 * index, 2 * index + 1)), np.concatenate((left, left))
        open_ = int(left[0] & ~NEGATIVE)
        return WayProof(0, cells, ", ".join(self.boxes.names(open_)))

    def at(self, parameters: Array) -> WayProof:
        """Prove that a pose is regular and within the limits, with the box of poses near to it."""
        half = _NEAR * (self.sizes + np.abs(parameters))
        if self.machine.shared:
            half[3:] = 0
        low, high = parameters - half, parameters + half
        reason = self._is_apart(low, high)
        if reason:
            return WayProof(0, 0, reason, shared=True)
        found = self.boxes.judge(
            np.stack((low, high), axis=1),
            np.flatnonzero(low < high).tolist(),
            0,
            np.zeros(1, np.uint64),
            np.array([self._conditions]),
            split=False,
        )
        if len(found.inside):
            return WayProof(-1 if found.inside_signs[0] & NEGATIVE else 1, 1)
        names = self.boxes.names(int(found.open_left[0])) if len(found.open) else ["limit"]
        return WayProof(0, 0, ", ".join(names))
