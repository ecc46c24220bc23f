"""The rows of a planned path, proved once more as they are returned."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import IncompleteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.paths.between import least_clearances, least_gaps
from gspcli.motion.paths.ends import PathEnd
from gspcli.motion.paths.guides import PROVED_ROWS, Guide, GuideRows
from gspcli.motion.paths.planned_paths import PathPart, PlannedPath
from gspcli.motion.paths.timing import PathLimits, timed
from gspcli.motion.paths.way_costs import steps

Array = NDArray[np.float64]

#: How far a platform moves from row to row, in its lengths; how many rows a part has.
_STEP, _LEAST, _MOST = 0.03, 4, 200


def finished(
    given: Instance,
    guide: Guide,
    corners: Array,
    start: PathEnd,
    goal: PathEnd,
    limits: PathLimits | None = None,
) -> PlannedPath:
    """Return a path with its rows.

    Parameters
    ----------
    given
        The platform, with offsets of readings.
    guide
        Proves paths.
    corners
        Those of a proved path, shape (k + 1, 6).
    start, goal
        Its ends.
    limits
        Of speeds and accelerations, if the path has a time.

    Raises
    ------
    IncompleteError
        If the rows cannot be proved, though the path was.
    """
    proved = np.full(len(corners) - 1, PROVED_ROWS)
    trace = guide.trace(corners, proved)
    timing, t = None, None
    if trace is not None:
        length = Arrangement.of(given).length
        wanted = np.ceil(_lengths(given, trace) / (_STEP * length))
        rows = np.clip(wanted, _LEAST, _MOST).astype(np.int64)
        # Long steps near singular poses are not proved; those of the search are.
        for tried in (rows, np.maximum(rows, proved)):
            if limits is not None:
                found = timed(guide, corners, limits, tried)
                if found is not None:
                    trace, t, timing = found
                    break
            elif (rowed := guide.trace(corners, tried)) is not None:
                trace = rowed
                break
    if trace is None or (limits is not None and timing is None):
        message = "the path that was found could not be proved again: try another seed"
        raise IncompleteError(message)
    # Those of drives take long.
    if guide.clear or trace.rows.motors is None:
        at, between = least_clearances(trace.rows, guide.clear)
    else:
        at, between = np.zeros(len(trace.T)), np.zeros(len(trace.T) - 1)
    conditions = trace.rows.conditions()
    gaps = None if guide.gap is None else least_gaps(trace.rows, guide.gap)[1]
    first = np.searchsorted(trace.part, np.arange(len(trace.proofs)))
    last = np.append(first[1:], len(trace.part) - 1)
    lengths = _lengths(given, trace)
    parts = tuple(
        PathPart(
            int(a),
            int(b),
            int(trace.proofs[k]),
            float(lengths[k]),
            float(conditions[a : b + 1].max()),
            float(between[a:b].min()),
            gap=None if gaps is None else float(gaps[a:b].min()),
        )
        for k, (a, b) in enumerate(zip(first.tolist(), last.tolist(), strict=True))
    )
    return PlannedPath(
        given, start.name, goal.name, "proved", "", guide.along,
        trace.part + trace.fraction if t is None else t,
        trace.values, trace.R, trace.T, conditions, at, parts, timing, trace.drives,
        None if gaps is None else ComparedShapes(given).gaps(trace.R, trace.T).min(axis=1),
    )  # fmt: skip


def _lengths(instance: Instance, trace: GuideRows) -> Array:
    """Return the length of each straight part."""
    moved = steps(instance, trace.R, trace.T)
    return np.asarray(
        np.bincount(trace.part[:-1], weights=moved, minlength=len(trace.proofs)), float
    )
