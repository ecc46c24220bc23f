"""The few of many paths that fail or run into others, followed again before anything else."""

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

#: At most this part of the paths is a few.
_FEW = 0.02


def collided(points: ComplexArray, error: FloatArray, regular: Array) -> Array:
    """Return which of some regular ends (P, 8), with errors (P,), another path shares, (P,)."""
    together = np.zeros(len(points), dtype=np.bool_)
    index = np.flatnonzero(regular)
    for group in clusters(points[index], error[index]):
        if len(group) > 1:
            together[index[group]] = True
    return together


def retracked(
    origin: System, target: System, points: ComplexArray, first: PathResults, jobs: int
) -> PathResults:
    """Return first results (1, P) in which the few paths that went wrong are followed again.

    Of hundreds of paths one may fail, or jump; with smaller steps it does not. If they
    are many, the target is not one of those for which that is worth it.
    """
    error = regular_error(first.correction[0])
    known = clearly_simple(first)[0]
    wrong = collided(first.points[0], error, known)
    # Those that have failed, and those at which Newton's method has not settled.
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
