"""Exact numbers as sums of two doubles, for proofs of the kernel with 32 digits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.certification.numbers.rounding import OUTWARD
from gspcli.geometry.numbers import Number

if TYPE_CHECKING:
    from flint import arb

Array = NDArray[np.float64]

#: Largest relative difference of a number from its two doubles (native/open_equations.hpp).
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
            error = float((ball - high - low).abs_upper()) * OUTWARD
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
