"""Where three planes and quadrics of projective 3-space meet, if they are in general position.

A plane is a vector p of length 4, its equation ``p . z = 0``; a quadric is a symmetric matrix Q of
order 4, its equation ``z^T Q z = 0``. By Bezout's theorem n quadrics and 3 - n planes meet in 2^n
points counted with multiplicity, or in infinitely many. The native kernel finds them for many
systems at a time, and says where its answer is not to be trusted.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.geometry.quaternions import Field

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def generic_points(
    planes: Field, quadrics: Field, accuracy: Array, real: NDArray[np.bool_]
) -> tuple[Complex, Array, NDArray[np.bool_]]:
    """Return the points of systems in general position.

    Parameters
    ----------
    planes
        Planes of the s systems of each of f groups, shape (f, s, k, 4); k = 0 to 3.
    quadrics
        The quadrics that the systems of a group share, shape (f, 3 - k, 4, 4).
    accuracy
        The relative error of both in each group, shape (f,).
    real
        Which groups are of real systems, shape (f,): their points are exactly real or come in
        exactly conjugate pairs, one directly after the other.

    Returns
    -------
    points
        Shape (f, s, 2^(3 - k), 4), norm 1.
    errors
        Estimated distance of each from the exact point, shape (f, s, 2^(3 - k)).
    ok
        Which systems have been solved, shape (f, s): all their points are accurate and well
        apart. By Bezout's theorem there are no others.
    """
    return _kernel.intersect(
        np.ascontiguousarray(planes, np.complex128),
        np.ascontiguousarray(quadrics, np.complex128),
        accuracy,
        real,
    )
