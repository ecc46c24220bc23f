"""Sines of many angles with 32 digits and an error bound, without a library."""

from __future__ import annotations

from fractions import Fraction
from math import factorial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.numbers.doubled import two_product, two_sum

Array = NDArray[np.float64]
#: Numbers as sums of two doubles.
Pair = tuple[Array, Array]

#: Absolute error of what is computed here. Of an argument of at most 1.6 the terms that are left
#: out are less than 2^-108. With u = 2^-53 a product errs by at most 5 u^2 of itself, and a sum by
#: 4 u^2 of the moduli of what is added; the argument errs by 7 u^2 of itself. By Horner's rule term
#: k errs by at most (28 k + 12) u^2 of itself: its products and sums, its coefficient, the squares
#: and the argument; less than 64 u^2 = 2^-100 for the sum of all terms. Those computed in doubles
#: are less than 2^-50, and err by 2^-49 of themselves at most.
SINE_ERROR = 2.0**-96


def _pair(number: Fraction) -> tuple[float, float]:
    high = float(number)
    return high, float(number - Fraction(high))


_PI = Fraction("3.14159265358979323846264338327950288419716939937510")
_UNIT = _pair(_PI / 180)
_QUARTER = {True: (90.0, 0.0), False: _pair(_PI / 2)}
_TERMS = [_pair(Fraction((-1) ** k, factorial(2 * k + 1))) for k in range(17)]
#: From this term on doubles suffice.
_SMALL = 10


class SineNumbers(NamedTuple):
    """The numbers from which sines are computed, for the same computation in other programs."""

    quarter: tuple[float, float]
    """A quarter turn, as all of these the sum of two doubles."""
    unit: tuple[float, float]
    """What angles in degrees are multiplied by."""
    terms: list[tuple[float, float]]
    """Coefficients of the series."""
    small: int
    """From this term on doubles do."""

    @classmethod
    def of(cls, *, degrees: bool) -> SineNumbers:
        """Return the numbers for a unit of angles."""
        return cls(_QUARTER[degrees], _UNIT, _TERMS, _SMALL)


def sines(angles: Array, complements: NDArray[np.bool_], *, degrees: bool) -> Pair:
    """Return sines of angles from -90 to 90 degrees, or cosines of angles from 0 to 180.

    Parameters
    ----------
    angles
        In degrees or radians; a few roundings beyond the range are harmless.
    complements
        For which of them the cosine is returned; broadcast.
    degrees
        The unit.
    """
    high, low = _QUARTER[degrees]
    x = two_sum(np.where(complements, high, 0.0), np.where(complements, -angles, angles))
    x = _normal(x[0], x[1] + np.where(complements, low, 0.0))
    if degrees:
        x = _times(x, _UNIT)
    square = _times(x, x)
    rest = np.full_like(x[0], _TERMS[-1][0])
    for term, _ in reversed(_TERMS[_SMALL:-1]):
        rest = rest * square[0] + term
    total: Pair = rest, np.zeros_like(rest)
    for high, low in reversed(_TERMS[:_SMALL]):
        product = _times(total, square)
        sum_, left = two_sum(product[0], np.asarray(high))
        total = _normal(sum_, left + (product[1] + low))
    return _times(total, x)


def _times(a: Pair, b: Pair | tuple[float, float]) -> Pair:
    product, rest = two_product(a[0], np.asarray(b[0]))
    return _normal(product, rest + (a[0] * b[1] + a[1] * b[0]))


def _normal(high: Array, low: Array) -> Pair:
    total = high + low
    return total, low - (total - high)
