"""Intervals that enclose exact numbers, in floating point or with more digits, rounded outwards.

An interval without zero proves that a number is not zero. ``sqrt(2)*sqrt(2)-2`` is 4e-16 in
floating point, but its interval contains zero.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from gspcli.geometry.evaluation import FUNCTIONS
from gspcli.records import dataclass

_DOMAINS = {"sqrt": (0.0, math.inf), "asin": (-1.0, 1.0), "acos": (-1.0, 1.0)}


@dataclass(frozen=True)
class Interval:
    """All numbers from ``low`` to ``high``."""

    low: float
    high: float

    @classmethod
    def around(cls, *values: float, ulps: int = 1) -> Interval:
        """Return the hull of values whose rounding errors are at most this many last places."""
        if not all(map(math.isfinite, values)):
            return cls(-math.inf, math.inf)
        low, high = min(values), max(values)
        return cls(low - ulps * math.ulp(low), high + ulps * math.ulp(high))

    @property
    def without_zero(self) -> bool:
        """Whether the interval excludes zero."""
        return self.low > 0 or self.high < 0

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __add__(self, other: Interval) -> Interval:
        return Interval.around(self.low + other.low, self.high + other.high)

    def __sub__(self, other: Interval) -> Interval:
        return self + -other

    def __mul__(self, other: Interval) -> Interval:
        return Interval.around(*(a * b for a in vars(self).values() for b in vars(other).values()))

    def __truediv__(self, other: Interval) -> Interval:
        if not other.without_zero:
            raise ZeroDivisionError
        return Interval.around(*(a / b for a in vars(self).values() for b in vars(other).values()))


class _Intervals:
    """Arithmetic of intervals."""

    def rational(self, value: Fraction) -> Interval:
        return Interval.around(value.numerator / value.denominator)

    def pi(self) -> Interval:
        return Interval.around(math.pi)

    def function(self, name: str, argument: Interval) -> Interval:
        if name == "tan":
            return self.function("sin", argument) / self.function("cos", argument)
        # The library's functions have an error of at most one unit in the last place; two are
        # taken.
        function = FUNCTIONS[name]
        if name in ("sin", "cos"):
            middle = Interval.around(function(argument.low), ulps=2)
            change = argument.high - argument.low
            return middle + Interval(-change, change)
        # The others are monotone.
        least, most = _DOMAINS.get(name, (-math.inf, math.inf))
        ends = (min(max(end, least), most) for end in (argument.low, argument.high))
        return Interval.around(*map(function, ends), ulps=2)


#: The arithmetic for `Expression.evaluate`.
INTERVALS = _Intervals()


class FineIntervals:
    """Arithmetic of intervals with more digits, by mpmath.

    Parameters
    ----------
    bits
        The precision.
    """

    #: Bits beyond those of the result; the error of a function is far below half of them.
    _SPARE = 32

    def __init__(self, bits: int) -> None:
        # Few numbers need mpmath, and its import takes as long as a solve.
        from mpmath import MPContext
        from mpmath.ctx_iv import MPIntervalContext

        self._intervals, self._numbers = MPIntervalContext(), MPContext()
        self._intervals.prec, self._numbers.prec = bits, bits + self._SPARE

    def rational(self, value: Fraction) -> Any:
        """Return an interval about a rational number."""
        return self._intervals.mpf(value.numerator) / self._intervals.mpf(value.denominator)

    def pi(self) -> Any:
        """Return an interval about pi."""
        return +self._intervals.pi

    def function(self, name: str, argument: Any) -> Any:
        """Return an interval about all values; ValueError if there are none."""
        if name == "tan":
            return self.function("sin", argument) / self.function("cos", argument)
        if name in ("sin", "cos"):
            return getattr(self._intervals, name)(argument)
        least, most = _DOMAINS.get(name, (-math.inf, math.inf))
        if argument.b < least or argument.a > most:
            raise ValueError
        ends = (min(max(end, least), most) for end in self.ends(argument))
        function = getattr(self._numbers, name)
        # The last bits of the ends are lost to rounding outwards.
        low, high = sorted(function(end) for end in ends)
        return self._intervals.mpf([low, high]) * self._nearly_one

    def ends(self, interval: Any) -> tuple[Any, Any]:
        """Return the ends of an interval as numbers of mpmath."""
        return self._numbers.mpf(interval.a), self._numbers.mpf(interval.b)

    @property
    def _nearly_one(self) -> Any:
        error = self._numbers.ldexp(1, -self._intervals.prec)
        return self._intervals.mpf([1 - error, 1 + error])
