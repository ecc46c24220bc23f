"""Sines of angles of a quarter turn at most, with a bound of the error that needs no library."""

from __future__ import annotations

from math import factorial

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Absolute error of what is computed here. Of an argument of at most 1.6 the terms that are left
#: out are less than 2^-80; by Horner's rule term k errs by at most 4k + 6 roundings (its powers,
#: its coefficient, the sums it is in), the square of the argument included, which is less than
#: 2^-49 for the sum of all terms; the argument errs by 3 roundings if it was given in degrees, or
#: as the complement of an angle.
SINE_ERROR = 2.0**-48
_TERMS = [(-1) ** k / factorial(2 * k + 1) for k in range(14)]
_QUARTER = {True: 90.0, False: np.pi / 2}


def sines(angles: Array, *, degrees: bool) -> Array:
    """Return the sines of angles from -90 to 90 degrees (a few roundings beyond are harmless)."""
    x = angles * (np.pi / 180) if degrees else angles
    square = x * x
    total = np.full_like(x, _TERMS[-1])
    for term in reversed(_TERMS[:-1]):
        total = total * square + term
    return np.asarray(total * x)


def cosines(angles: Array, *, degrees: bool) -> Array:
    """Return the cosines of angles from 0 to 180 degrees."""
    return sines(_QUARTER[degrees] - angles, degrees=degrees)
