"""Exact numbers as sums of two doubles, for proofs that the kernel writes in 32 digits."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from gspcli.certification.rounding import OUTWARD
from gspcli.geometry.numbers import Number

if TYPE_CHECKING:
    from flint import arb

#: Part of its size by which a number may differ from its two doubles (native/open_equations.hpp).
ERROR = 2.0**-96
#: Bits of balls that are turned into two doubles.
_PRECISION = 128


class Doubled(NamedTuple):
    """A number within `ERROR` times its size of the sum of two doubles."""

    high: float
    """Next to the number."""
    low: float
    size: float
    """Not less than the modulus of `high`."""

    @classmethod
    def of(cls, number: Number) -> Doubled:
        """Return the doubles next to a number."""
        exact = number.fraction
        if exact is None:
            return cls.near(lambda: _ball(number))
        return cls.of_ratio(exact.numerator, exact.denominator)

    @classmethod
    def of_ratio(cls, numerator: int, denominator: int) -> Doubled:
        """Return those next to a quotient of integers, within half a last place of `low`."""
        high = numerator / denominator
        p, q = high.as_integer_ratio()
        return cls(high, (numerator * q - p * denominator) / (denominator * q), abs(high))

    @classmethod
    def near(cls, compute: Callable[[], arb]) -> Doubled:
        """Return those next to what is computed in balls."""
        from flint import ctx

        with ctx.workprec(_PRECISION):
            ball = compute()
            high = float(ball)
            low = float(ball - high)
            error = float((ball - high - low).abs_upper()) * OUTWARD
        return cls(high, low, max(abs(high), error / ERROR))

    @classmethod
    def square(cls, number: Number) -> Doubled:
        """Return the doubles next to the square of a number."""
        exact = number.fraction
        if exact is None:
            return cls.near(lambda: _ball(number) ** 2)
        return cls.of_ratio(exact.numerator**2, exact.denominator**2)

    def scaled(self, factor: float) -> Doubled:
        """Return the number times a power of two, or its negative."""
        return Doubled(self.high * factor, self.low * factor, self.size * abs(factor))


def _ball(number: Number) -> arb:
    from gspcli.certification.balls import ball

    return ball(number)
