"""The exact numbers of an instance taken apart: angles, square roots, and what these are of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import gcd, isqrt

import sympy

from gspcli.catalogue.kinds import AHH, ALL
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane, Point, Vector


class UnknownNumberError(Exception):
    """The instance has a number with which the way of counting can do nothing."""


def direction(geometry: Point | Line | Plane) -> Vector:
    """Return the direction of a line or the normal of a plane; zero for a point."""
    zero = Number.of(0)
    if isinstance(geometry, Point):
        return (zero, zero, zero)
    return geometry.direction if isinstance(geometry, Line) else geometry.normal


#: Turns, radians, and inverse cosines with their signs, that add up to an angle.
Turn = tuple[Fraction, Fraction, tuple[tuple[Fraction, int], ...]]


def turn_of(constraint: Constraint, unit: AngleUnit) -> Turn:
    """Return the angle whose cosine is used: turns, radians, and cosines of further angles."""
    turn, radians, cosines = linear(constraint.value)
    if unit is AngleUnit.DEGREE:
        if turn or cosines:
            message = f"no residue of {constraint.value} degrees is known"
            raise UnknownNumberError(message)
        turn, radians = radians / 360, Fraction(0)
    if constraint.kind not in (ALL, AHH):
        # The sine is the cosine of a quarter turn less the angle, or of the angle less that.
        turn -= Fraction(1, 4)
    return turn, radians, cosines


def linear(number: Number) -> Turn:
    """Return turns, radians and inverse cosines that add up to a number."""
    if number.fraction is not None:
        return Fraction(0), number.fraction, ()
    if number.operation == "pi":
        return Fraction(1, 2), Fraction(0), ()
    if number.operation in ("acos", "asin") and number.arguments[0].fraction is not None:
        # The inverse sine is a quarter turn less the inverse cosine.
        inverse = (number.arguments[0].fraction, 1 if number.operation == "acos" else -1)
        return Fraction(1 - (number.operation == "acos"), 4), Fraction(0), (inverse,)
    if number.operation in ("*", "/"):
        first, second = number.arguments
        if number.operation == "*" and first.fraction is not None:
            first, second = second, first
        if second.fraction is not None:
            factor = second.fraction if number.operation == "*" else 1 / second.fraction
            turn, radians, cosines = linear(first)
            if not cosines:
                return turn * factor, radians * factor, ()
    message = f"no residue of the sine and cosine of {number} is known"
    raise UnknownNumberError(message)


def turns(instance: Instance) -> list[Turn]:
    """Return the angles of an instance, and those of the sines and cosines in its numbers."""
    result = []
    for constraint in instance.constraints:
        numbers = [constraint.value] if constraint.kind.is_distance else []
        for body in (constraint.platform, constraint.base):
            numbers += [*body.position, *direction(body)]
        result += [linear(angle) for number in numbers for angle in _angles_within(number)]
        if not constraint.kind.is_distance:
            result.append(turn_of(constraint, instance.units.angle))
    return result


def _angles_within(number: Number) -> Iterator[Number]:
    if number.fraction is None:
        if number.operation in ("sin", "cos"):
            yield number.arguments[0]
        else:
            for argument in number.arguments:
                yield from _angles_within(argument)


def square_of(exact: Vector) -> Fraction:
    """Return the square of the length of a vector."""
    return sum(map(_square, exact), Fraction(0))


def _square(number: Number) -> Fraction:
    """Return the square of a number that is the root of a rational one."""
    if number.fraction is not None:
        return number.fraction**2
    arguments = number.arguments
    match number.operation:
        case "sqrt" if arguments[0].fraction is not None:
            square: Fraction = arguments[0].fraction
            return square
        case "neg":
            return _square(arguments[0])
        case "*":
            return _square(arguments[0]) * _square(arguments[1])
        case "/":
            return _square(arguments[0]) / _square(arguments[1])
    message = f"no residue of the length of {number}, ... is known"
    raise UnknownNumberError(message)


def radicands(instance: Instance, angles: Sequence[Turn]) -> Iterator[int]:
    """Yield numbers of which square roots are needed, without their square factors."""
    for constraint in instance.constraints:
        kind, value = constraint.kind, constraint.value
        sided = kind.is_distance and constraint.side is not Side.BOTH
        if not kind.is_distance or sided:
            for body in (constraint.platform, constraint.base):
                if not isinstance(body, Point):
                    yield from _radicand(square_of(direction(body)))
        # The square of a distance is enough, but for a signed one.
        if kind.is_distance and (sided or value.operation != "sqrt"):
            yield from _roots_within(value)
        for body in (constraint.platform, constraint.base):
            for number in (*body.position, *direction(body)):
                yield from _roots_within(number)
    for _, _, cosines in angles:
        for cosine, _ in cosines:
            yield from _radicand(1 - cosine**2)


def _roots_within(number: Number) -> Iterator[int]:
    if number.operation == "sqrt" and number.arguments[0].fraction is not None:
        yield from _radicand(number.arguments[0].fraction)
    elif number.fraction is None:
        for argument in number.arguments:
            yield from _roots_within(argument)


def _radicand(value: Fraction) -> Iterator[int]:
    rest = without_squares(value.numerator * value.denominator)[1]
    if rest > 1:
        yield rest


def without_squares(number: int) -> tuple[int, int]:
    """Return a factor whose square divides a number, and the number without it."""
    if number and isqrt(number) ** 2 == number:
        return isqrt(number), 1
    whole = 1
    for prime in sympy.primerange(100):
        while number and number % (prime * prime) == 0:
            number, whole = number // (prime * prime), whole * prime
    return whole, number


def coprime_base(numbers: Sequence[int]) -> list[int]:
    """Return numbers above one, coprime in pairs, of which the given ones are products."""
    base: list[int] = []
    waiting = [n for n in numbers if n > 1]
    while waiting:
        new = waiting.pop()
        for old in base:
            common = gcd(new, old)
            if common > 1:
                base.remove(old)
                waiting += [n for n in (new // common, old // common, common) if n > 1]
                break
        else:
            base.append(new)
    # A square of a base element has a rational root.
    return sorted({isqrt(n) if isqrt(n) ** 2 == n else n for n in base})
