"""Proof that a mode fills the box of its ranges: one pose for each set of values in the box.

If that is so, the mode is regular on the whole box. Its poses are open and closed among all poses
whose values are in the ranges. So no path within the ranges leads from it to another mode, not even
through singular poses, and every straight way of values is a path of it. The proof is that of
`gspcli.motion.singularities.neighbourhoods`: boxes too large for it are halved, and the mode
is followed to their centres.
"""

from __future__ import annotations

from enum import Enum

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.enclosures import OUT
from gspcli.motion.paths.value_ways import ValueWays
from gspcli.motion.singularities.neighbourhoods import Neighbourhood

Array = NDArray[np.float64]

#: The most boxes that are tested, and how many at a time.
_MOST, _PIECE = 4000, 256


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
        box = near.box(ways.platform.internal(h) * OUT)
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
