"""Ball arithmetic for proofs: exact numbers, vectors, outward rounding.

Every function works at the precision of the current `flint.ctx`; an `arb` is a real ball and an
`acb` a complex one, and each result contains the exact one.
"""

from __future__ import annotations

import copyreg
import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import TypeVar

import numpy as np
from flint import acb, arb, ctx, fmpq
from numpy.typing import NDArray

from gspcli.certification.numbers.rounding import TINY
from gspcli.geometry.enclosures import above
from gspcli.geometry.numbers import Number

Ball = TypeVar("Ball", arb, acb)

#: Numbers are written as sums of this many doubles, from those of at most this many bits.
_DOUBLES, _LONG = 4, 1024


def _same_ball(mid: tuple[int, int] | str, rad: tuple[int, int] | str) -> arb:
    """Return the ball with a midpoint and a radius, each m 2^e as (m, e), or a name.

    The radius is rounded up: the ball contains the one that was written.
    """
    return arb(mid, arb(rad))


def _parts(ball: arb) -> tuple[tuple[int, int] | str, tuple[int, int] | str]:
    """Return the midpoint and the radius of a ball, exactly."""

    def part(number: arb) -> tuple[int, int] | str:
        if not number.is_finite():
            return "nan" if number.is_nan() else "inf" if number > 0 else "-inf"
        m, e = number.man_exp()
        return int(m), int(e)

    return part(ball.mid()), part(ball.rad())


#: python-flint does not pickle balls.
copyreg.pickle(arb, lambda ball: (_same_ball, _parts(ball)))
copyreg.pickle(acb, lambda ball: (acb, (ball.real, ball.imag)))


def power_of_two(size: float) -> arb:
    """Return the largest power of two that is at most a positive size; 1 for zero."""
    if not 0 < size < math.inf:
        return arb(1)
    return arb(2) ** (math.frexp(size)[1] - 1)


def dot(a: Sequence[Ball], b: Sequence[Ball]) -> Ball:
    """Return the bilinear product of two vectors of length three."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[Ball], b: Sequence[Ball]) -> list[Ball]:
    """Return the cross product of two vectors."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def rotated(rotation: Sequence[Sequence[Ball]], vector: Sequence[Ball]) -> list[Ball]:
    """Return a 3x3 matrix, given by rows, times a vector."""
    return [dot(row, vector) for row in rotation]


def norm(vector: Sequence[Ball]) -> Ball:
    """Return the Euclidean norm of a vector, as an analytic function of its components."""
    square = dot(vector, vector)
    return (square.nonnegative_part() if isinstance(square, arb) else square).sqrt()


def unit_vector(vector: Sequence[Ball]) -> list[Ball]:
    """Return a vector over its norm; nothing for none."""
    return [entry / norm(vector) for entry in vector]


def largest(values: Sequence[Ball]) -> arb:
    """Return an upper bound, as an exact number, of the moduli; NaN if one is not finite."""
    bounds = [value.abs_upper() for value in values]
    if not all(bound.is_finite() for bound in bounds):
        return arb.nan()
    return max(bounds)


def floats_above(values: Iterable[Ball]) -> NDArray[np.float64]:
    """Return floats that are not below the moduli of any numbers in balls."""
    # `TINY` covers the rounding of subnormal floats.
    bounds = np.array([float(value.abs_upper()) for value in values])
    return np.asarray(above(bounds) + TINY)


def float_above(value: Ball) -> float:
    """Return a float that is not below the modulus of any number in a ball."""
    return float(floats_above([value])[0])


def float_ends(value: arb) -> tuple[float, float]:
    """Return floats below and above all numbers of a ball."""
    low = math.nextafter(float(value.lower()), -math.inf)
    return low, math.nextafter(float(value.upper()), math.inf)


def decimal_near(number: Number, digits: int) -> Fraction:
    """Return a decimal fraction within one unit in this many significant digits of a number."""
    with ctx.workprec(4 * digits + 64):
        value = number.ball()
    places = digits - 1 - math.floor(math.log10(abs(number.value))) if number.value else digits
    with ctx.workprec(8 * (digits + abs(places)) + 64):
        scaled = value * arb(fmpq(10) ** places)
        whole = int((scaled.mid() + arb(fmpq(1, 2))).floor().fmpz())
    return Fraction(whole) / Fraction(10) ** places
