"""Exact numbers as sums of two doubles, for proofs of the kernel with 32 digits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import chain
from math import factorial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.geometry.enclosures import above
from gspcli.geometry.numbers import Number

if TYPE_CHECKING:
    from flint import arb


Array = NDArray[np.float64]

#: Largest difference of a number from its two doubles, as a part of its size
#: (native/open_equations.hpp); the size of a sine is one.
ERROR = 2.0**-96
#: Integers up to this are doubles.
_INTEGERS = 2**53
_ONE = (1, 1)
#: Bits of balls that are converted to two doubles, and the bits that must be accurate.
_PRECISION, _KNOWN = 128, 108


class Doubled(NamedTuple):
    """A number within `ERROR` times its size of the sum of two doubles."""

    high: float
    """Next to the number."""
    low: float
    size: float
    """Not less than the modulus of `high`."""

    @classmethod
    def of(cls, number: Number) -> Doubled:
        """Return the doubles nearest to a number."""
        exact = number.fraction
        if exact is None:
            return cls.near(number.ball)
        return cls.of_ratio(exact.numerator, exact.denominator)

    @classmethod
    def of_ratio(cls, numerator: int, denominator: int) -> Doubled:
        """Return the doubles nearest to a quotient of integers, within half a place of `low`."""
        high = numerator / denominator
        p, q = high.as_integer_ratio()
        return cls(high, (numerator * q - p * denominator) / (denominator * q), abs(high))

    @classmethod
    def near(cls, compute: Callable[[], arb]) -> Doubled:
        """Return the doubles nearest to a number that is computed in balls."""
        from flint import ctx

        with ctx.workprec(_PRECISION):
            ball = compute()
            if ball.rel_accuracy_bits() < _KNOWN:
                # Almost equal numbers are subtracted.
                with ctx.workprec(8 * _PRECISION):
                    ball = compute()
            high = float(ball)
            low = float(ball - high)
            error = above(float((ball - high - low).abs_upper()))
        return cls(high, low, max(abs(high), error / ERROR))

    @classmethod
    def square(cls, number: Number) -> Doubled:
        """Return the doubles nearest to the square of a number."""
        exact = number.fraction
        if exact is None:
            return cls.near(lambda: number.ball() ** 2)
        return cls.of_ratio(exact.numerator**2, exact.denominator**2)

    def scaled(self, factor: float) -> Doubled:
        """Return the number times a power of two, or its negative."""
        return Doubled(self.high * factor, self.low * factor, self.size * abs(factor))


def doubled(numbers: Sequence[Number]) -> Array:
    """Return `Doubled.of` of numbers as columns, shape (3, n); short quotients together."""
    fractions = [number.fraction for number in numbers]
    found = quotients([_ONE if x is None else x.as_integer_ratio() for x in fractions])
    for k in [k for k, exact in enumerate(fractions) if exact is None]:
        found[:, k] = Doubled.of(numbers[k])
    return found


def quotients(ratios: Sequence[tuple[int, int]]) -> Array:
    """Return `Doubled.of_ratio` of quotients p / q, q > 0, as columns, shape (3, n)."""
    integers = list(chain.from_iterable(ratios))
    if max(integers) <= _INTEGERS and min(integers) >= -_INTEGERS:
        return _kernel.quotients(np.array(integers, float).reshape(-1, 2))
    return np.array([Doubled.of_ratio(*ratio) for ratio in ratios]).T


def two_product(a: Array, b: Array) -> tuple[Array, Array]:
    """Return products of moderate numbers, and their rounding errors (T. J. Dekker)."""
    (a_high, a_low), (b_high, b_low) = _split(a), _split(b)
    product = a * b
    rest = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, rest


def two_sum(a: Array, b: Array) -> tuple[Array, Array]:
    """Return sums, and their rounding errors (D. E. Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def _split(x: Array) -> tuple[Array, Array]:
    """Return the halves of numbers, each of which has 26 bits."""
    split = x * (2.0**27 + 1)
    high = split - (split - x)
    return high, x - high


#: Numbers as sums of two doubles.
Pair = tuple[Array, Array]

# What is computed here errs by less than `ERROR`. Of an argument of at most 1.6 the terms that are
# left out are less than 2^-108. With u = 2^-53 a product errs by at most 5 u^2 of itself, and a sum
# by 4 u^2 of the moduli of what is added; the argument errs by 7 u^2 of itself. By Horner's rule
# term k errs by at most (28 k + 12) u^2 of itself: its products and sums, its coefficient, the
# squares and the argument; less than 64 u^2 = 2^-100 for the sum of all terms. Those computed in
# doubles are less than 2^-50, and err by 2^-49 of themselves at most.


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
