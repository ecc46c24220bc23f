"""The rotations that satisfy three angle constraints (Section 6.1, Proposition 6.1).

An angle constraint is linear in R, so times ``N = e.e`` a real quadric in the quaternion space
P^3. Three of them in general position meet in eight points, none of which has N = 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.intersections import generic_points
from gspcli.geometry.quaternions import dot, rotated_forms
from gspcli.geometry.surfaces import certainly_not_zero
from gspcli.records import dataclass

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: Points with a larger error relative to N are not good enough.
_ACCURACY = 1e-11
_EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Rotations:
    """The eight simple solutions of each three angle constraints, one set after the other.

    Attributes
    ----------
    e
        The real rotations, exactly real, and one of each pair of conjugates that are not;
        quaternions of norm 1, shape (f, 4).
    real
        Which of them are real, shape (f,).
    errors
        Their estimated errors, shape (f,).
    counts
        How many of these are of each set, shape (b,); none where the quadrics do not certainly
        meet in eight simple finite points.
    """

    e: Complex
    real: NDArray[np.bool_]
    errors: Array
    counts: NDArray[np.intp]


def angle_forms(u: Array, v: Array, cosines: Array) -> Array:
    """Return the quadrics of ``R u . v = cosine`` in quaternions, (..., 3) -> (..., 4, 4)."""
    return np.asarray(rotated_forms(u, v) - cosines[..., None, None] * np.eye(4))


def rotations(forms: Array) -> Rotations:
    """Return, for each three quadrics of angles, all rotations.

    Parameters
    ----------
    forms
        From `angle_forms`, shape (b, 3, 4, 4).
    """
    count = len(forms)
    points, distances, solved = generic_points(
        np.empty((count, 1, 0, 4)), forms, np.full(count, _EPS), np.ones(count, bool)
    )
    e, errors = points[:, 0], distances[:, 0]
    norm = np.abs(dot(e, e))
    known = certainly_not_zero(norm, errors) & (errors < _ACCURACY * norm)
    ok = solved[:, 0] & known.all(axis=1)
    real = (e.imag == 0).all(axis=2)
    # Conjugates come one directly after the other.
    chosen = (real | ((~real).cumsum(axis=1) % 2 == 1)) & ok[:, None]
    return Rotations(e[chosen], real[chosen], errors[chosen], chosen.sum(axis=1))
