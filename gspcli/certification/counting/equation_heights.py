"""Bounds of the heights of the numbers in the equations of a platform, in bits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction

from flint import fmpq

from gspcli.catalogue.kinds import DLL, DLP, DPL
from gspcli.certification.counting.elements import ONE, WHOLE, FieldElement, Term
from gspcli.certification.counting.exact_platform import ExactConstraint, evaluated
from gspcli.certification.counting.motion_equations import (
    MotionEquation,
    equations,
    with_moments,
)

#: A function of a motion that is no coordinate is a sum of at most this many products of two.
_PRODUCTS = 3
#: The most that sums and constants in an equation add to the heights of its numbers; twice this for
#: PL, LP and LL, which contain squares.
_CONSTANTS = 24


def _log_above(value: Fraction | int) -> float:
    """Return a number above the logarithm to base 2 of a number, at least 0."""
    bits = abs(value.numerator).bit_length() - value.denominator.bit_length() + 1
    return float(max(bits, 0))


def _sum_height(terms: Iterable[tuple[Term, Fraction]]) -> float:
    """Return a bound of the height of some terms, and so of their sums, with 1."""
    parts = [
        (abs(factor.numerator) * (math.isqrt(term.radicand) + 1), factor.denominator)
        for term, factor in terms
    ]
    denominator = math.lcm(*(q for _, q in parts))
    size = Fraction(sum(p * (denominator // q) for p, q in parts), denominator)
    return _log_above(denominator) + _log_above(size)


def height(element: FieldElement) -> float:
    """Return a bound, in bits, of the absolute logarithmic height of a number.

    Roots of unity have modulus one in every embedding, and so formally have ``exp(i r)``; pi is
    an independent variable, with coefficient one.
    """
    fraction = element.fraction
    if fraction is not None:
        return _log_above(fraction.denominator) + _log_above(fraction)
    return _sum_height(element.numerator.items()) + _sum_height(element.denominator.items())


def _vector_height(vector: Sequence[FieldElement]) -> float:
    """Return a bound of the height of some numbers with 1."""
    if any(x.denominator is not WHOLE and x.denominator.keys() != {ONE} for x in vector):
        return sum(height(x) for x in vector)
    return _sum_height(
        (term, factor if x.denominator is WHOLE else factor / x.denominator[ONE])
        for x in vector
        for term, factor in x.numerator.items()
    )


def equation_height(constraints: Sequence[ExactConstraint]) -> float:
    """Return a bound, in bits, of the height of every equation of a platform.

    The height of a polynomial is the mean over all embeddings of the logarithm of the sum of the
    moduli of its coefficients, plus that of a common denominator.
    """
    return max(_constraint_height(row) for row in constraints)


def _constraint_height(row: ExactConstraint) -> float:
    if all(number.fraction is not None for number in row.numbers):
        rational = equations([evaluated(row, _fraction)])
        return max(_rational_height(each) for each in with_moments(rational).equations)
    squared = row.kind in (DPL, DLP, DLL)
    vectors = sum(_vector_height(vector) for vector in (row.a, row.b, row.u, row.v))
    return 2 * vectors + height(row.value) + _CONSTANTS * (2 if squared else 1)


def lines_height(row: ExactConstraint, bits: int) -> float:
    """Return a bound of the height of the conditions for parallel lines of a DLL.

    That is of ``w . (R u x v)`` with random integers w of this many bits, times a coordinate or
    not, and of the distance of parallel lines (`motion_equations.parallel_lines`).
    """
    vectors = sum(_vector_height(vector) for vector in (row.a, row.b, row.u, row.v))
    return 2 * vectors + height(row.value) + 2 * _CONSTANTS + bits


def _fraction(element: FieldElement) -> fmpq:
    # This is quicker than the fractions of Python.
    value = element.fraction
    assert value is not None
    return fmpq(value.numerator, value.denominator)


def _rational_height(equation: MotionEquation) -> float:
    linear = [fmpq(x) for x in equation.linear.values()]
    denominator = _common_denominator(linear)
    size = _PRODUCTS * sum(map(abs, linear), fmpq(0))
    for weight, function in equation.squares:
        factors = [fmpq(x) for x in function.values()]
        square = int(fmpq(weight).q) * _common_denominator(factors) ** 2
        denominator = math.lcm(denominator, square)
        size += abs(fmpq(weight)) * sum(map(abs, factors), fmpq(0)) ** 2
    return _log_above(denominator) + _log_above(Fraction(int(size.p), int(size.q)))


def _common_denominator(numbers: Sequence[fmpq]) -> int:
    return math.lcm(*(int(x.q) for x in numbers))
