"""A lower bound of the modulus of an algebraic number that is not zero.

The number is written as U / L with algebraic integers U and L, whose conjugates are at most u and l
in modulus, of a field of degree D. If U is not zero its norm is a nonzero integer, so that
``|U| u^(D-1) >= 1``, and the number is at least ``1 / (u^(D-1) l)`` (C. Burnikel, S. Funke, K.
Mehlhorn, S. Schirra, S. Schmitt, A separation bound for real algebraic expressions, 2001). A
square root counts ``sqrt(U / L) = sqrt(U L) / L``; the cosine of a rational angle is half an
algebraic integer with conjugates of at most 2.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt, lcm
from typing import NamedTuple

from gspcli.geometry.evaluation import Expression


class _Bounds(NamedTuple):
    """The bounds u and l of an expression, its square roots, and the order of its root of unity."""

    above: int
    below: int
    roots: frozenset[Expression]
    order: int


def separation_bits(number: Expression) -> int | None:
    """Return b such that a number is zero or at least ``2^-b`` in modulus.

    The result is None if the number is not known to be algebraic.
    """
    found = _bounds(number)
    if found is None:
        return None
    degree = found.order << len(found.roots)
    return found.above.bit_length() * (degree - 1) + found.below.bit_length()


def _bounds(number: Expression) -> _Bounds | None:
    operation, arguments = number.operation, number.arguments
    if number.fraction is not None:
        p, q = number.fraction.as_integer_ratio()
        return _Bounds(abs(p), q, frozenset(), 1)
    if operation in ("sin", "cos", "tan"):
        return _trigonometric(operation, arguments[0])
    if operation not in ("neg", "sqrt", "+", "-", "*", "/"):
        return None
    parts = [_bounds(argument) for argument in arguments]
    if None in parts:
        return None
    first, second = parts[0], parts[-1]
    assert first is not None
    assert second is not None
    if operation == "neg":
        return first
    if operation == "sqrt":
        root = isqrt(first.above * first.below) + 1
        return first._replace(above=root, roots=first.roots | {number})
    both = first.roots | second.roots, lcm(first.order, second.order)
    if operation == "*":
        return _Bounds(first.above * second.above, first.below * second.below, *both)
    if operation == "/":
        return _Bounds(first.above * second.below, first.below * second.above, *both)
    return _Bounds(
        first.above * second.below + first.below * second.above, first.below * second.below, *both
    )


def _trigonometric(operation: str, angle: Expression) -> _Bounds | None:
    halves = multiple_of_pi(angle)
    if halves is None:
        return None
    # The sine is a cosine of an angle that is a quarter turn less.
    order = lcm(2 * halves.denominator, 4)
    # A tangent is a quotient of two such numbers.
    size = 4 if operation == "tan" else 2
    return _Bounds(size, size, frozenset(), order)


def multiple_of_pi(number: Expression) -> Fraction | None:
    """Return the rational factor if a number is written as a rational multiple of pi."""
    operation, arguments = number.operation, number.arguments
    if operation == "pi":
        return Fraction(1)
    if operation == "rational":
        return Fraction(0) if number.fraction == 0 else None
    if operation == "neg":
        factor = multiple_of_pi(arguments[0])
        return None if factor is None else -factor
    if operation not in ("+", "-", "*", "/"):
        return None
    left, right = map(multiple_of_pi, arguments)
    if operation in ("+", "-"):
        if left is None or right is None:
            return None
        return left + right if operation == "+" else left - right
    before: Fraction | None = arguments[0].fraction
    after: Fraction | None = arguments[1].fraction
    if left is not None and after is not None:
        return left * after if operation == "*" else left / after
    if right is not None and before is not None and operation == "*":
        return before * right
    return None
