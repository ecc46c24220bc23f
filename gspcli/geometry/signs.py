"""The sign of an exact number, and the nearest double, where doubles do not suffice.

``sqrt(2) - 1.414213562373095`` is 4.9e-17, but zero in floating point; ``sqrt(2)*sqrt(2) - 2`` is
zero, but 4e-16 in floating point. More digits prove that a number is not zero. An algebraic number
is zero if its modulus is below the bound of `gspcli.geometry.separation`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from gspcli.geometry.evaluation import FLOATS, Expression
from gspcli.geometry.intervals import INTERVALS, FineIntervals, Interval
from gspcli.geometry.separation import separation_bits

#: Precisions that are tried in turn, and the largest one for a proof that a number is zero.
_BITS, _MOST_BITS = (128, 512, 2048), 2**15
#: Relative width of an interval within which a double is known.
_NARROW = 2.0**-40


def sign_of(number: Expression) -> int | None:
    """Return 1, 0 or -1, proved; None if the sign is not known.

    Raises
    ------
    ValueError
        If the number does not exist, such as the root of a negative one.
    """
    if number.fraction is not None:
        return (number.fraction > 0) - (number.fraction < 0)
    interval = _in_doubles(number)
    if interval is not None and interval.without_zero:
        return 1 if interval.low > 0 else -1
    for low, high in _finer(number, _BITS):
        if low > 0 or high < 0:
            return 1 if low > 0 else -1
    separation = separation_bits(number)
    if separation is None or separation > _MOST_BITS:
        return None
    for low, high in _finer(number, (separation + _BITS[0],)):
        if low > 0 or high < 0:
            return 1 if low > 0 else -1
        if max(-low, high) * 2**separation < 1:
            return 0
    return None


def nearest(number: Expression) -> float:
    """Return a double that is within a few units in the last place of a number.

    Raises
    ------
    ZeroDivisionError, OverflowError, ValueError
        If the number does not exist, or cannot be distinguished from one that does not.
    """
    interval = _in_doubles(number)
    if interval is None or not _is_narrow(interval.low, interval.high):
        for low, high in _finer(number, _BITS):
            if _is_narrow(low, high):
                return float((low + high) / 2)
        if sign_of(number) == 0:
            return 0.0
    return number.evaluate(FLOATS)


def _in_doubles(number: Expression) -> Interval | None:
    """Return an interval in floating point; None next to the end of a domain."""
    try:
        return number.evaluate(INTERVALS)
    except (ZeroDivisionError, ValueError):
        return None


def _finer(number: Expression, precisions: tuple[int, ...]) -> Iterator[tuple[Any, Any]]:
    """Yield the ends of intervals with ever more digits."""
    for bits in precisions:
        field = FineIntervals(bits)
        try:
            yield field.ends(number.evaluate(field))
        except ArithmeticError:
            continue


def _is_narrow(low: Any, high: Any) -> bool:
    size = max(abs(low), abs(high))
    return bool(math.inf > size > 0 and high - low <= _NARROW * size)
