"""Correct rounding of numbers in balls; every proved pose is returned in this form.

Below `SMALL` units a number is rounded to the nearest multiple of `GRID` units, otherwise to the
nearest double. So a number that is exactly zero becomes zero if it is proved to be nearly zero. The
unit is the power of two above all numbers of a rotation, of a quaternion, or of a translation and
the length scale of its platform. The kernel rounds in the same way (native/fine_points.cpp): the
result depends on the exact numbers only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from flint import acb, arb
from numpy.typing import NDArray

from gspcli.certification.numbers.rounding import NEAREST

#: The exponents of `SMALL`, of `GRID`, and of the largest radius of a ball about a possible tie.
_SMALL, _GRID, _TIE = -12, -64, -900
#: The limit of small numbers and the step of their grid, in units.
SMALL, GRID = Fraction(2) ** _SMALL, Fraction(2) ** _GRID


#: Errors of complex numbers that are as good as rounded, as a part of the largest.
_ACCURATE = NEAREST / 4


def rounded(
    numbers: Sequence[acb], *, real: bool, least_unit: float = 0.0
) -> NDArray[np.complex128] | None:
    """Return the numbers in balls, rounded correctly; None if a ball is too large.

    Parameters
    ----------
    numbers
        Balls of n complex numbers.
    real
        Whether they are real; their imaginary parts are then ignored.
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


def accurate(numbers: Sequence[acb], *, least_unit: float = 0.0) -> NDArray[np.complex128] | None:
    """Return the numbers in balls within 2^-53 of the largest of them; None if a ball is too large.

    Their middles are rounded as by `rounded`: nearly always the results are those of smaller balls.
    """
    if not all(x.is_finite() for x in numbers):
        return None
    largest = max([float(part.mid()) for x in numbers for part in (abs(x.real), abs(x.imag))])
    off = max([float(part.rad()) for x in numbers for part in (x.real, x.imag)])
    if off > _ACCURATE * max(least_unit, largest):
        return None
    middles = [acb(x.real.mid(), x.imag.mid()) for x in numbers]
    return rounded(middles, real=False, least_unit=least_unit)


def _rounded(number: arb, unit: int) -> float | None:
    """Return the rounded number of a ball, in a unit; None if not all its numbers agree."""
    near = float(number.mid())
    if abs(near) > 2.0 ** (unit + _SMALL + 1):
        # Not at a power of two, where doubles are nearer below.
        half = math.ulp(near) / 2 if math.frexp(near)[0] not in (0.5, -0.5) else 0.0
        if abs(number - arb(near)) < arb(half):
            return near
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
    # An exact number may be half-way between two doubles.
    tie = (Fraction(low) + Fraction(high)) / 2
    return _nearest(tie.numerator, 1 - tie.denominator.bit_length(), unit)


def _nearest(mantissa: int, exponent: int, unit: int) -> float:
    """Return a mantissa times a power of two, rounded."""
    size = abs(mantissa)
    if size.bit_length() + exponent > unit + _SMALL:
        # The nearest double, if it is not subnormal.
        drop = max(size.bit_length() - 53, -1074 - exponent)
    else:
        drop = unit + _GRID - exponent
    kept = _shifted(size, drop)
    # No result is a negative zero.
    return math.ldexp(kept if mantissa > 0 else -kept, exponent + drop) if kept else 0.0


def _shifted(size: int, drop: int) -> int:
    """Return an integer over a power of two, rounded to the nearest integer, ties to even."""
    if drop <= 0:
        return size << -drop
    kept, rest = size >> drop, size & ((1 << drop) - 1)
    half = 1 << (drop - 1)
    return kept + (rest > half or (rest == half and kept & 1))
