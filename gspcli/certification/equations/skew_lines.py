"""Proofs that the lines of a DLL are not parallel.

The equation of the distance of two lines is ``M^2 = d^2 (u.u v.v - C^2)`` with the mutual moment M
and ``C = R u . v``. If its right-hand side does not vanish, the distance is d. For parallel lines
the equation holds at any distance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.geometry.enclosures import above, roundings
from gspcli.geometry.instance import Array, Instance
from gspcli.geometry.primitives import Line

Complex = NDArray[np.complex128]


# NaN proves nothing.
@np.errstate(all="ignore")
def are_skew(instance: Instance, R: Complex, deviation: Array) -> NDArray[np.bool_]:
    """Return at which poses the lines of every DLL are proved not to be parallel, shape (n,).

    Parameters
    ----------
    instance
        The platform.
    R, deviation
        Rotations (n, 3, 3), and bounds of the errors of their entries, shape (n,).
    """
    weights = [
        np.outer(row.base.unit, row.platform.unit).ravel()
        for row in instance.constraints
        if row.kind is DLL and isinstance(row.platform, Line) and isinstance(row.base, Line)
    ]
    if not weights:
        return np.ones(len(R), np.bool_)
    columns = np.array(weights).T
    entries = R.reshape(-1, 9)
    cosine = entries @ columns
    sizes, reach = np.abs(entries) @ np.abs(columns), np.abs(columns).sum(axis=0)
    error = above(deviation[:, None] * reach + roundings(8, sizes))
    # For unit vectors the right-hand side is d^2 times this.
    sine = np.abs(1 - cosine**2)
    rounding = roundings(8, 1 + np.abs(cosine) ** 2)
    enough = above((2 * np.abs(cosine) + error) * error + rounding)
    return np.asarray((sine > enough).all(axis=1))
