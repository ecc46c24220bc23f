"""Find the real points of a set that is closed under conjugation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.geometry.quaternions import normalized

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def find_real_points(points: Complex) -> tuple[Complex, NDArray[np.bool_]]:
    """Return representatives of the points of a set closed under conjugation, and which are real.

    A point is real if, of all points of the set, the point itself is nearest to its conjugate.
    This needs no threshold if the distances between points exceed their errors.

    Parameters
    ----------
    points
        Points of projective space, shape (k, n + 1).

    Returns
    -------
    representatives
        The points with norm 1; a real point has exactly real coordinates; shape (k, n + 1).
    real
        Shape (k,).
    """
    return _kernel.find_real_points(np.ascontiguousarray(points))


def made_real(points: Complex) -> Array:
    """Return real representatives of real points, norm 1, shape (..., n + 1)."""
    flat = points.reshape(-1, points.shape[-1])
    pivot = flat[np.arange(len(flat)), np.abs(flat).argmax(axis=1)]
    return np.asarray(normalized((flat * (1 / pivot)[:, None]).real).reshape(points.shape))
