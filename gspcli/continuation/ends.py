"""Comparison of ends of paths with each other and with infinity.

Every end has an error: a bound, for points of norm 1, of its distance from the solution.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.quadrics import ComplexArray, FloatArray

SINGULAR_ERROR = 1e-7
"""Error of ends found by the endgame; solutions that are nearer to each other count as one."""
# Any vector v suffices: |z.v| is a function of the point that does not depend on its phase.
_KEY = np.exp(1j * np.arange(8) ** 2) / np.sqrt(8)


def regular_error(correction: FloatArray) -> FloatArray:
    """Return the errors of regular ends from the lengths of their last Newton corrections."""
    return 1e-13 + 100 * correction


def infinite(points: ComplexArray, error: FloatArray) -> NDArray[np.bool_]:
    """Return which points (..., 8) are at infinity: N = e.e is below a twentieth of their errors.

    The errors are larger than needed, so that two ends at one solution are never counted as two.
    With the whole error, solutions at 1e5 times the size of the platform would count as infinite.
    """
    e, error = points[..., :4], error / 20
    size = np.sqrt((e.real**2 + e.imag**2).sum(axis=-1))
    return np.asarray(np.abs((e**2).sum(axis=-1)) <= error * (size + error))


def may_coincide(
    points: ComplexArray, error: FloatArray
) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Sort points (B, P, 8) by a continuous invariant; return which neighbours may be the same.

    Returns
    -------
    order, near
        Shapes (B, P) and (B, P - 1).
    """
    keys = np.abs(points @ _KEY)
    order = keys.argsort(axis=1)
    rows = np.arange(len(keys))[:, None]
    keys, error = keys[rows, order], error[rows, order]
    return order, keys[:, 1:] - keys[:, :-1] < np.maximum(error[:, 1:], error[:, :-1])


def distances(points: ComplexArray, point: ComplexArray) -> FloatArray:
    """Return the sines of the angles between points (n, 8) and a point, all of norm 1."""
    # The cosine is not used: its rounding hides angles below 1e-8.
    return np.asarray(np.linalg.norm(points - np.outer(points @ point.conj(), point), axis=1))


def clusters(points: ComplexArray, error: FloatArray) -> list[NDArray[np.intp]]:
    """Return the indices of points (n, 8), grouped by being the same within their errors (n,)."""
    order, near = may_coincide(points[None], error[None])
    groups = []
    for run in np.split(order[0], np.flatnonzero(~near[0]) + 1):
        if len(run) == 1:
            groups.append(run)
            continue
        rest = run
        while len(rest):
            first = rest[0]
            together = distances(points[rest], points[first]) < np.maximum(
                error[rest], error[first]
            )
            together[0] = True
            groups.append(np.sort(rest[together]))
            rest = rest[~together]
    return groups
