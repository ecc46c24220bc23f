"""Straight ways of values, followed with proof, within ranges and cones.

On a straight way all values change linearly, as drives move them. Ranges are intervals, so the
whole way keeps those that both its ends keep. A mode is followed along it by
`MovingPlatform.follow`, which proves that it exists, is regular and is the only one near. A
distance of two lines must not be zero on the way: there the value turns, and the mode could
continue as one of two.

A mode may fill the box of its ranges: one pose for each set of values in the box. If that is so, it
is regular on the whole box. Its poses are open and closed among all poses whose values are in the
ranges. So no path within the ranges leads from it to another mode, not even through singular poses,
and every straight way of values is a path of it. The proof is that of
`gspcli.motion.singularities.neighbourhoods`: boxes too large for it are halved, and the mode is
followed to their centres.
"""

from __future__ import annotations

from enum import Enum
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DPH
from gspcli.geometry.enclosures import above
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.limits import joint_cones
from gspcli.geometry.machine import Machine
from gspcli.motion.following.branch_follower import FollowOptions, MovingPlatform, Stop, apart
from gspcli.motion.following.branch_runs import SAME
from gspcli.motion.following.followed_rows import RowFollower
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.singularities.neighbourhoods import Neighbourhood

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
        self.cones = joint_cones(instance)
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


class Sheet(Enum):
    """What a mode is over the box of ranges."""

    WHOLE = "whole"
    """It is proved to fill the box."""
    ENDS = "ends"
    """It could not be followed to some values of the box: it ends there, or nearly so."""
    OPEN = "open"
    """Neither was found with this many boxes."""


def whole_sheet(ways: ValueWays, values: Array, point: Array) -> Sheet:
    """Return whether a mode fills the box of ranges.

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
        return Sheet.ENDS
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
            return Sheet.OPEN
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
            return Sheet.ENDS
        centres = np.concatenate((centres, goals))
        halves = np.concatenate((halves, h, h))
        points = np.concatenate((points, moved.points[:, -1]))
    return Sheet.WHOLE
