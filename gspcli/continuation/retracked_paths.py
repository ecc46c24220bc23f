"""A second attempt at the few of many paths that fail or end at the end of another path."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.ends import clusters, regular_error
from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.regularity import clearly_simple
from gspcli.continuation.systems import System
from gspcli.continuation.tracker import PathResults, PathStatus, track
from gspcli.continuation.tracker_options import CAREFUL

Array = NDArray[np.bool_]

#: The largest part of the paths that is followed again.
_FEW = 0.02


def collided(points: ComplexArray, error: FloatArray, regular: Array) -> Array:
    """Return which regular ends (P, 8), with errors (P,), another path shares, shape (P,)."""
    together = np.zeros(len(points), dtype=np.bool_)
    index = np.flatnonzero(regular)
    for group in clusters(points[index], error[index]):
        if len(group) > 1:
            together[index[group]] = True
    return together


def retracked(
    origin: System, target: System, points: ComplexArray, first: PathResults, jobs: int
) -> PathResults:
    """Return first results (1, P) after a second attempt at the few wrong paths.

    One of hundreds of paths may fail or jump; with smaller steps it does not. If many paths go
    wrong, the target is special, and the first results are returned.
    """
    error = regular_error(first.correction[0])
    known = clearly_simple(first)[0]
    wrong = collided(first.points[0], error, known)
    # Paths that have failed, and paths at whose end Newton's method has not converged.
    wrong |= ~known & (first.status[0] != PathStatus.SINGULAR)
    if not 0 < wrong.sum() <= max(2, _FEW * len(wrong)):
        return first
    again = track(origin, target, points[wrong], options=CAREFUL, jobs=jobs)
    columns = {}
    for column in fields(first):
        columns[column.name] = part = getattr(first, column.name).copy()
        if len(part):
            part[0, wrong] = getattr(again, column.name)[0]
    return PathResults(**columns)
