"""The exact numbers of instances modulo a prime."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from fractions import Fraction
from functools import cached_property

import sympy

from gspcli.catalogue.kinds import AHL, ALH
from gspcli.geometry.instance import AngleUnit, Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point, Vector

#: Sines and cosines are those of multiples of half a degree: sums of roots of unity of this order.
ROOT_ORDER = 720
FIRST_PRIME = 500_000_000


class NoRootError(Exception):
    """A square root of the instance does not exist modulo the prime."""


def primes(instance: Instance) -> Iterator[int]:
    """Yield primes modulo which the sines and cosines of an instance exist."""
    turning = any(_has_cosines(number) for number in _coordinates(instance))
    prime = FIRST_PRIME
    while True:
        prime = sympy.nextprime(prime)
        if not turning or prime % ROOT_ORDER == 1:
            yield prime


def _coordinates(instance: Instance) -> Iterator[Number]:
    for constraint in instance.constraints:
        if constraint.kind.is_distance:
            yield constraint.value
        for body in (constraint.platform, constraint.base):
            yield from body.position
            yield from () if isinstance(body, Point) else direction(body)


def direction(geometry: object) -> Vector:
    """Return the direction of a line or the normal of a plane; zero for a point."""
    zero = Number.of(0)
    if isinstance(geometry, Point):
        return (zero, zero, zero)
    return getattr(geometry, "direction", None) or geometry.normal  # type: ignore[attr-defined]


def _has_cosines(number: Number) -> bool:
    return number.operation in ("sin", "cos") or any(
        isinstance(argument, Number) and _has_cosines(argument) for argument in number.arguments
    )


class Residues:
    """The numbers of an instance modulo a prime.

    Square roots of rational numbers are products of those of primes, so that relations among
    them hold. Modulo a prime that is 1 modulo 720 cosines come from one root of unity, and the
    roots of 2, 3 and 5 from the same, so that relations between both kinds hold as well.
    """

    def __init__(self, prime: int) -> None:
        self.prime = prime

    @cached_property
    def _unity(self) -> int:
        """A primitive root of unity of order 720: half a degree."""
        if self.prime % ROOT_ORDER != 1:
            message = f"no cosines modulo {self.prime}"
            raise SystemExit(message)
        return pow(sympy.primitive_root(self.prime), (self.prime - 1) // ROOT_ORDER, self.prime)

    def cosine_of(self, half_degrees: int) -> int:
        """Return the cosine of a multiple of half a degree."""
        power = pow(self._unity, half_degrees % ROOT_ORDER, self.prime)
        return (power + pow(power, -1, self.prime)) * pow(2, -1, self.prime) % self.prime

    def rational(self, value: Fraction) -> int:
        """Return the residue of a fraction."""
        return value.numerator * pow(value.denominator, -1, self.prime) % self.prime

    def root(self, value: Fraction) -> int:
        """Return a square root; those of products are products of those of the factors."""
        product = value.numerator * value.denominator
        root = self.rational(Fraction(1, value.denominator))
        for factor, power in sympy.factorint(product).items():
            root = root * pow(factor, power // 2, self.prime) % self.prime
            if power % 2:
                root = root * self._root_of_prime(factor) % self.prime
        return root

    def _root_of_prime(self, factor: int) -> int:
        if self.prime % ROOT_ORDER == 1 and factor in (2, 3, 5):
            # sqrt 2 = 2 cos 45, sqrt 3 = 2 cos 30, sqrt 5 = 4 cos 36 - 1.
            if factor == 5:
                return 4 * self.cosine_of(72) - 1
            return 2 * self.cosine_of({2: 90, 3: 60}[factor])
        root = sympy.sqrt_mod(factor, self.prime)
        if root is None:
            raise NoRootError
        return int(root)

    def number(self, number: Number) -> int:
        """Return the residue of an exact number of fractions, square roots, sines and cosines."""
        if number.fraction is not None:
            return self.rational(number.fraction)
        if number.operation == "sqrt":
            return self.root(_exact(number.arguments[0]))
        if number.operation in ("sin", "cos"):
            half_degrees = _half_degrees(number.arguments[0])
            return self.cosine_of(half_degrees if number.operation == "cos" else 180 - half_degrees)
        parts = [self.number(argument) for argument in number.arguments]
        match number.operation:
            case "+":
                result = parts[0] + parts[1]
            case "-":
                result = parts[0] - parts[1]
            case "*":
                result = parts[0] * parts[1]
            case "/":
                result = parts[0] * pow(parts[1], -1, self.prime)
            case "neg":
                result = -parts[0]
            case operation:
                message = f"no residue of {operation} is known"
                raise SystemExit(message)
        return result % self.prime

    def square(self, number: Number) -> int:
        """Return the square of a number: of a square root the radicand, whether it has one."""
        if number.operation == "sqrt":
            return self.number(number.arguments[0])
        return self.number(number) ** 2 % self.prime

    def norm(self, vector: Vector) -> int:
        """Return the length of a vector whose square is rational."""
        return self.root(sum((_exact_square(x) for x in vector), Fraction(0)))

    def cosine(self, constraint: Constraint, unit: AngleUnit) -> int:
        """Return the cosine, of a generic angle if it is no multiple of 30 degrees.

        Of ALH and AHL the sine, which is the cosine of the rest to a right angle.
        """
        angle = constraint.value
        if constraint.kind in (ALH, AHL):
            angle = Number.of(90 - (angle.fraction or Fraction(0)))
        degrees = angle.fraction
        if unit is AngleUnit.DEGREE and degrees is not None and degrees % 30 == 0:
            exact = sympy.cos(sympy.pi * int(degrees) / 180)
            sign = -1 if exact < 0 else 1
            square = sympy.Rational(exact**2)
            return sign * self.root(Fraction(int(square.p), int(square.q)))
        return random.Random(f"{angle} {self.prime}").randrange(self.prime)


def _exact(number: Number) -> Fraction:
    """Return a number that is rational, whatever it is made of."""
    if number.fraction is not None:
        return number.fraction
    value = sympy.nsimplify(sympy.sympify(str(number)), rational=False)
    if not value.is_Rational:
        message = f"{number} is not rational"
        raise SystemExit(message)
    return Fraction(int(value.p), int(value.q))


def _exact_square(number: Number) -> Fraction:
    if number.fraction is not None:
        return number.fraction**2
    value = sympy.expand(sympy.sympify(str(number)) ** 2)
    if not value.is_Rational:
        message = f"the square of {number} is not rational"
        raise SystemExit(message)
    return Fraction(int(value.p), int(value.q))


class _HalfTurns:
    """Arithmetic in which pi is one, for arguments of cosines."""

    def rational(self, value: Fraction) -> Fraction:
        return value

    def pi(self) -> Fraction:
        return Fraction(1)

    def function(self, name: str, argument: Fraction) -> Fraction:
        message = f"{name}({argument}) in the argument of a cosine"
        raise SystemExit(message)


def _half_degrees(number: Number) -> int:
    """Return an angle that is a multiple of half a degree in half degrees."""
    turns = number.evaluate(_HalfTurns())
    half_degrees = turns * 360
    if not math.isclose(float(turns) * math.pi, number.value, abs_tol=1e-12) or (
        half_degrees.denominator != 1
    ):
        message = f"{number} is not a multiple of half a degree"
        raise SystemExit(message)
    return int(half_degrees)
