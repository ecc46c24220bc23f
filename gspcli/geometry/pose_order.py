"""The order of poses that does not depend on how they were found."""

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

    Real ones come first; then by the quaternion, then by the translation, each component in turn,
    rounded to nine decimals (translations in powers of ten of the typical length), real parts
    before imaginary parts. Poses that agree in all of these are compared with all their digits.

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
