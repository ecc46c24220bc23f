"""Solved platforms of six legs of which one body is flat, or both are, with complex values.

The equations of a flat body are not solved for the same quantities as those of others (`Shifts`).
From a platform that is flat, too, paths are short, and what still is at infinity is seen at their
ends. Nothing rests on it: the poses of a geometry are counted.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP, Kind
from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.shifts import FROM_START, ends_from_start
from gspcli.continuation.start import StartSystem
from gspcli.continuation.systems import EQUATIONS, System
from gspcli.solver.reference_start import complex_platform

Array = NDArray[np.float64]

#: Heights of points of a flat body, in lengths of order one, ...
_FLAT = 1e-12
#: ... N of finite ends, points of norm one, ...
_FINITE = 1e-6
#: ... and by how much the cosine of two of them is less than one if they are different.
_SAME = 1e-8
#: Of the random geometry: of 0, 1 and 3 the one from which fewest paths to real designs go wrong.
_SEED = 3


def ends_from_flat(
    kinds: tuple[Kind, ...], y: Array, x: Array, system: System
) -> ComplexArray | None:
    """Return what seem to be all finite solutions of a geometry with complex values.

    Parameters
    ----------
    kinds, y, x
        Of the geometry, lengths of order one, shapes (6, 3).
    system
        Its equations, in canonical order.

    Returns
    -------
    ComplexArray or None
        Points of norm one, shape (n, 8); None unless a body of six legs is flat, and no paths
        collide. None of shared joints, too: most paths to these go wrong.
    """
    platform, base = (bool(np.ptp(points[:, 2]) <= _FLAT) for points in (y, x))
    if set(kinds) != {DPP} or not (platform or base) or _shares_joints(y) or _shares_joints(x):
        return None
    start = _start(platform, base)
    ends = None if start is None else ends_from_start(start, system.coefficients.g, FROM_START)
    if ends is None:
        return None
    ends = ends[~np.isnan(ends[:, 0])]
    ends /= np.linalg.norm(ends, axis=1, keepdims=True)
    ends = ends[np.abs((ends[:, :4] ** 2).sum(axis=1)) > _FINITE]
    alike = np.abs(ends.conj() @ ends.T) > 1 - _SAME
    return None if alike.sum() > len(ends) else ends


def _shares_joints(points: Array) -> bool:
    return len(set(map(tuple, points.tolist()))) < len(points)


@cache
def _start(platform: bool, base: bool) -> StartSystem | None:
    """Return a solved platform of which these bodies are flat; None if it has no solution."""
    from gspcli.continuation.pursuit import pursue

    given = complex_platform((DPP,) * EQUATIONS, _SEED, flat=(platform, base))
    points = next(pursue([given], seed=_SEED)).distinct_simple()
    if not len(points):
        return None
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return StartSystem(given, points)
