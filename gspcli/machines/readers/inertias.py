"""Masses and matrices of inertia as SDF and URDF have them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ENTRIES = (("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2))


def matrix(entry: Callable[[str], float], X: Array) -> Array:
    """Return a matrix of inertia in the axes of a body, shape (3, 3).

    Parameters
    ----------
    entry
        The entry of a name, as ``ixx``, in the axes of X.
    X
        The frame of the centre of mass in the body, shape (4, 4).
    """
    own = np.zeros((3, 3))
    for axes, i, j in _ENTRIES:
        own[i, j] = own[j, i] = entry(f"i{axes}")
    turned: Array = X[:3, :3] @ own @ X[:3, :3].T
    return turned
