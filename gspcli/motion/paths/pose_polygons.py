"""Ways of values as polygons of poses: short straight ways in position and angles along them.

Within ranges a map of values finds ways around more quickly than one of poses: random values in the
ranges have poses that all keep them. A regular way that is found there keeps a distance from
singular poses, so enough straight ways of poses between places on it are regular, too. Each of them
is proved as any other; nothing is taken from the proof of the way of values.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.motion.paths.between_rows import PathRows
from gspcli.motion.paths.guides import PROVED_ROWS, PoseGuide
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.way_costs import cost

Array = NDArray[np.float64]

#: How often the steps of a way of values are halved at most.
_HALVINGS = 8
#: A corner is left out if the way without it costs at most this many times as much.
_DEARER = 1.05
_ROWS = np.array([PROVED_ROWS])


def pose_polygon(guide: PoseGuide, rows: PathRows, begin: Array, end: Array) -> Array | None:
    """Return the corners of a proved polygon of poses along a way of values, shape (k + 1, 6).

    None if some straight way between near places is not proved.

    Parameters
    ----------
    guide
        Proves polygons of poses.
    rows
        Places on the way of values.
    begin, end
        The parameters of both ends, shape (6,).
    """
    for _ in range(_HALVINGS + 1):
        found, open_ = _along(guide, _placed(guide.ways, rows, begin, end))
        if not open_:
            return _fewer(guide, np.array(found))
        finer = rows.halved(np.array(open_))
        if finer is None:
            return None
        rows = finer
    return None


def _placed(ways: PoseWays, rows: PathRows, begin: Array, end: Array) -> Array:
    """Return the parameters of rows, each continued from the one before, with the given ends."""
    found = np.concatenate((begin[None], ways.parameters(rows.R[1:], rows.T[1:])))
    found[-1] = end
    for k in range(1, len(found)):
        found[k] = ways.nearest(found[k - 1], found[k])
    return found


def _along(guide: PoseGuide, places: Array) -> tuple[list[Array], list[int]]:
    """Return corners of a polygon, and the places after which no straight way is proved.

    Long straight ways are tried first, and then their halves.
    """
    corners, open_ = [places[0]], []
    spans = [(0, len(places) - 1)]
    while spans:
        first, last = spans.pop()
        if guide.trace(places[[first, last]], _ROWS) is not None:
            corners.append(places[last])
        elif last - first == 1:
            open_.append(first)
        else:
            middle = (first + last) // 2
            spans += [(middle, last), (first, middle)]
    return corners, open_


def _fewer(guide: PoseGuide, corners: Array) -> Array:
    """Leave corners out, one by one, where the way between their neighbours is proved."""
    instance = guide.ways.instance

    def costs(*ends: int) -> float:
        steps = np.full(len(ends) - 1, PROVED_ROWS)
        return cost(instance, *guide.unproved(corners[list(ends)], steps))

    k = 1
    while k < len(corners) - 1:
        cheap = costs(k - 1, k + 1) <= _DEARER * costs(k - 1, k, k + 1)
        if cheap and guide.trace(corners[[k - 1, k + 1]], _ROWS) is not None:
            corners = np.delete(corners, k, axis=0)
            # The neighbours before have other neighbours now.
            k = max(k - 1, 1)
        else:
            k += 1
    return corners
