"""An order of poses that does not depend on the way in which they were found."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel

Complex = NDArray[np.complex128]


def stable_order(
    real: NDArray[np.bool_], quaternions: Complex, translations: Complex, length: float
) -> NDArray[np.int64]:
    """Return the permutation that puts poses in order, shape (n,).

    Real poses come first. Then poses are compared by the components of the quaternion and of the
    translation in turn, real parts before imaginary parts, rounded to nine decimals (translations
    in powers of ten of the typical length). Poses that agree in all of these are compared with all
    their digits.

    Parameters
    ----------
    real
        Which poses are real, shape (n,).
    quaternions, translations
        Shapes (n, 4) and (n, 3).
    length
        The typical length.
    """
    unit = 10.0 ** math.floor(math.log10(length))
    return _kernel.order(
        np.ascontiguousarray(real),
        np.ascontiguousarray(quaternions),
        np.ascontiguousarray(translations),
        unit=unit,
    )
