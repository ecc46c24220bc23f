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

#: The exponents of these, and of the largest radius of a ball around a number that may be a tie.
_SMALL, _GRID, _TIE = -12, -64, -900
#: See above.
SMALL, GRID = Fraction(2) ** _SMALL, Fraction(2) ** _GRID


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
    exponent = math.frexp(max(least_unit, 2.0 ** math.frexp(largest)[1]))[1] - 1
    found = [[_rounded(x, exponent) for x in both] for both in parts]
    if any(x is None for both in found for x in both):
        return None
    return np.array(found, np.float64).view(np.complex128)[:, 0]


def _rounded(number: arb, unit: int) -> float | None:
    """Return a ball's numbers rounded, the unit a power of two; None if that is not one double."""
    mantissa, exponent = map(int, number.mid().man_exp())
    radius, place = map(int, number.rad().man_exp())
    if not radius:
        return _nearest(mantissa, exponent, unit)
    last = min(exponent, place)
    middle, reach = mantissa << (exponent - last), radius << (place - last)
    low, high = (_nearest(end, last, unit) for end in (middle - reach, middle + reach))
    if low == high:
        return low
    if radius.bit_length() + place > unit + _TIE:
        return None
    # An exact number may well be half-way between two.
    tie = (Fraction(low) + Fraction(high)) / 2
    return _nearest(tie.numerator, 1 - tie.denominator.bit_length(), unit)


def _nearest(mantissa: int, exponent: int, unit: int) -> float:
    """Return what a mantissa times a power of two is rounded to."""
    size = abs(mantissa)
    if size.bit_length() + exponent > unit + _SMALL:
        # The nearest double, exactly where it is none of those near zero.
        drop = max(size.bit_length() - 53, -1074 - exponent)
    else:
        drop = unit + _GRID - exponent
    kept = _shifted(size, drop)
    # Zero has one sign.
    return math.ldexp(kept if mantissa > 0 else -kept, exponent + drop) if kept else 0.0


def _shifted(size: int, drop: int) -> int:
    """Return the integer nearest to one over a power of two, of two the even one."""
    if drop <= 0:
        return size << -drop
    kept, rest = size >> drop, size & ((1 << drop) - 1)
    half = 1 << (drop - 1)
    return kept + (rest > half or (rest == half and kept & 1))
