"""Ball arithmetic in the shape that the proofs need: exact numbers, vectors, outward rounding.

Every function works at the precision of the current `flint.ctx`; an `arb` is a real ball and an
`acb` a complex one, and each result contains the exact one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TypeVar

from flint import acb, arb, fmpq

from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Vector

Ball = TypeVar("Ball", arb, acb)

#: Outward rounding of a sum or product of at most a few hundred nonnegative floats: each
#: operation loses a relative 2^-53 at most, and this factor makes up for four thousand of them.
OUTWARD = 1 + 2.0**-40


class _BallField:
    """Evaluates a `Number` to a ball that contains it."""

    def rational(self, value: Fraction) -> arb:
        return arb(fmpq(value.numerator, value.denominator))

    def pi(self) -> arb:
        return arb.pi()

    def function(self, name: str, argument: arb) -> arb:
        result: arb = getattr(argument, name)()
        return result


_FIELD = _BallField()


def ball(number: Number) -> arb:
    """Return a ball that contains an exact number."""
    return number.evaluate(_FIELD)


def length_vector(vector: Vector, scale: arb) -> list[arb]:
    """Return balls of a position in units of `scale`."""
    return [ball(number) / scale for number in vector]


def direction_vector(vector: Vector) -> list[arb]:
    """Return balls of a direction, scaled by a power of two to a length near one."""
    largest = max(abs(number.value) for number in vector)
    factor = power_of_two(largest)
    return [ball(number) / factor for number in vector]


def power_of_two(size: float) -> arb:
    """Return the power of two next below a positive size, exactly; 1 for zero."""
    if not 0 < size < math.inf:
        return arb(1)
    return arb(2) ** (math.frexp(size)[1] - 1)


def dot(a: Sequence[Ball], b: Sequence[Ball]) -> Ball:
    """Return the bilinear product of two vectors of length three."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[Ball], b: Sequence[Ball]) -> list[Ball]:
    """Return the cross product of two vectors."""
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def rotated(rotation: Sequence[Sequence[Ball]], vector: Sequence[Ball]) -> list[Ball]:
    """Return a 3x3 matrix, given by rows, times a vector."""
    return [dot(row, vector) for row in rotation]


def norm(vector: Sequence[arb]) -> arb:
    """Return the Euclidean norm of a real vector."""
    return dot(vector, vector).nonnegative_part().sqrt()


def largest(values: Sequence[Ball]) -> arb:
    """Return an upper bound, as an exact number, of the moduli; NaN if one is not finite."""
    bounds = [value.abs_upper() for value in values]
    if not all(bound.is_finite() for bound in bounds):
        return arb.nan()
    return max(bounds)


def float_above(value: arb) -> float:
    """Return a float that is not below any number of a nonnegative ball."""
    # The float nearest to the upper end may lie below it, but its successor cannot.
    return math.nextafter(float(value.abs_upper()), math.inf)


def float_ends(value: arb) -> tuple[float, float]:
    """Return floats below and above all numbers of a ball."""
    low = math.nextafter(float(value.lower()), -math.inf)
    return low, math.nextafter(float(value.upper()), math.inf)
