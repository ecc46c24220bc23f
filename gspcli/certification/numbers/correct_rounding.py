"""Numbers that are known as balls, rounded correctly: what every proved pose is written in.

Below `SMALL` units a number is rounded to the nearest multiple of `GRID` units, so that what is
exactly zero needs no other proof than that it is nearly zero; else to the nearest double. The unit
is the power of two above all numbers of a rotation, of a quaternion, or of a translation and the
length scale of its platform. The kernel does the same (native/fine_points.cpp): the result depends
on the exact numbers alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from flint import acb, arb
from numpy.typing import NDArray

#: See above; and the largest radius of a ball around a number that may be a tie of two doubles.
SMALL, GRID, _TIE = Fraction(1, 2**12), Fraction(1, 2**64), Fraction(1, 2**900)


def rounded(
    numbers: Sequence[acb], *, real: bool, least_unit: float = 0.0
) -> NDArray[np.complex128] | None:
    """Return the numbers in balls, rounded correctly; None if some balls are too large to tell.

    Parameters
    ----------
    numbers
        Balls of n complex numbers.
    real
        Whether they are real, whatever their imaginary parts.
    least_unit
        The unit is not below this power of two.
    """
    parts = [[x.real, arb(0) if real else x.imag] for x in numbers]
    if not all(x.is_finite() for both in parts for x in both):
        return None
    largest = max([abs(float(x.mid())) for both in parts for x in both])
    unit = Fraction(max(least_unit, 2.0 ** math.frexp(largest)[1]))
    found = [[_rounded(x, unit) for x in both] for both in parts]
    if any(x is None for both in found for x in both):
        return None
    return np.array(found, np.float64).view(np.complex128)[:, 0]


def _rounded(number: arb, unit: Fraction) -> float | None:
    middle, radius = _fraction(number.mid()), _fraction(number.rad())
    if radius < _TIE * unit:
        # An exact number may well be half-way between two doubles.
        return _nearest(middle, unit)
    low, high = (_nearest(end, unit) for end in (middle - radius, middle + radius))
    return low if low == high else None


def _nearest(number: Fraction, unit: Fraction) -> float:
    if abs(number) >= SMALL * unit:
        return float(number)
    # Zero has one sign.
    return float(round(number / (GRID * unit)) * GRID * unit) + 0.0


def _fraction(number: arb) -> Fraction:
    mantissa, exponent = map(int, number.man_exp())
    return Fraction(mantissa << exponent) if exponent >= 0 else Fraction(mantissa, 1 << -exponent)
