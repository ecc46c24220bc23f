"""The numbers of an instance modulo a prime, by one ring homomorphism.

What holds between the numbers holds between their residues. The square root of a product is the
product of the square roots. Cosines of degrees come from one root of unity, and so do the square
roots of 2, 3 and 5 beside them.

An angle that is no small fraction of a turn is whole degrees and a remainder. The remainder stands
for a generic turn, and multiples of it for powers of that turn. For its sine and cosine are
algebraic of a degree beyond that of any condition here, or transcendental.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cache, cached_property
from math import isqrt, lcm
from random import Random

import sympy

from gspcli.catalogue.kinds import AHH
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Vector
from tools.oracle.number_parts import (
    Turn,
    UnknownNumberError,
    coprime_base,
    direction,
    linear,
    radicands,
    square_of,
    turn_of,
    turns,
    without_squares,
)

#: Whole turns are divided into this many parts at most: primes with more roots of unity are rare.
MOST_PARTS = 360_000
#: Roots of unity beside any angle: they make the square roots of 2, 3 and 5.
FEWEST_PARTS = 360
#: Below the 2^31 that msolve and Singular allow, above the 2^29 that 30-bit arithmetic needs.
FIRST_PRIME, LAST_PRIME = 2**29, 2**31
#: Square roots beside any angle are sums of roots of unity of these orders.
_OF_UNITY = {2: 8, 3: 12, 5: 5}


class Homomorphism:
    """The homomorphism of one instance to one prime field, made by `fields`."""

    def __init__(self, instance: Instance, prime: int, base: Sequence[int]) -> None:
        self.prime = prime
        self.unit = instance.units.angle
        angles = turns(instance)
        self._parts = _parts(angles)
        self._random = Random(f"{_sha256(instance)} {prime}")
        self._zeta = self._root_of_unity() if angles else 0
        self._leftover = lcm(*(_split(turn, self._parts)[1].denominator for turn, _, _ in angles))
        self._radian = lcm(*(radians.denominator for _, radians, _ in angles))
        self._generic = [self._random.randrange(2, prime) for _ in range(2)]
        self._roots: dict[int, int] = {}
        for factor in base:
            if angles and factor in _OF_UNITY:
                power = pow(self._zeta, self._parts // _OF_UNITY[factor], prime)
                both = power + pow(power, -1, prime)
                self._roots[factor] = (1 + 2 * both if factor == 5 else both) % prime
                continue
            root = sympy.sqrt_mod(factor, prime)
            if root is None:
                message = f"{factor} has no square root modulo {prime}"
                raise ValueError(message)
            self._roots[factor] = root if self._random.random() < 0.5 else prime - root

    def _root_of_unity(self) -> int:
        factors = sympy.primefactors(self._parts)
        while True:
            base = self._random.randrange(2, self.prime)
            zeta = pow(base, (self.prime - 1) // self._parts, self.prime)
            if all(pow(zeta, self._parts // q, self.prime) != 1 for q in factors):
                return zeta

    def rational(self, value: Fraction) -> int:
        """Return the residue of a fraction."""
        return value.numerator * pow(value.denominator, -1, self.prime) % self.prime

    def root(self, value: Fraction) -> int:
        """Return a square root; those of products are products of those of the factors."""
        if value == 0:
            return 0
        whole, rest = without_squares(value.numerator * value.denominator)
        root = whole * self.rational(Fraction(1, value.denominator))
        for factor, residue in self._roots.items():
            power = 0
            while rest % factor == 0:
                rest, power = rest // factor, power + 1
            root = root * pow(residue, power, self.prime) % self.prime
        if isqrt(rest) ** 2 != rest:
            message = f"no residue of the square root of {rest} is known"
            raise UnknownNumberError(message)
        return root * isqrt(rest) % self.prime

    def number(self, number: Number) -> int:
        """Return the residue of an exact number: fractions, their square roots, sines, cosines."""
        if number.fraction is not None:
            return self.rational(number.fraction)
        if number.operation == "sqrt" and number.arguments[0].fraction is not None:
            return self.root(number.arguments[0].fraction)
        if number.operation in ("sin", "cos"):
            z, sine = self._unit(linear(number.arguments[0])), number.operation == "sin"
            both = z - pow(z, -1, self.prime) if sine else z + pow(z, -1, self.prime)
            return both * pow(2 * self._i if sine else 2, -1, self.prime) % self.prime
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
                raise UnknownNumberError(message)
        return result % self.prime

    def vector(self, exact: Vector) -> list[int]:
        """Return the residues of the components of a vector."""
        return [self.number(x) for x in exact]

    def norm(self, exact: Vector) -> int:
        """Return the length of a direction."""
        return self.root(square_of(exact))

    def square(self, number: Number) -> int:
        """Return the square of a number: of a square root the radicand, whether it has one."""
        if number.operation == "sqrt":
            return self.number(number.arguments[0])
        return pow(self.number(number), 2, self.prime)

    @cached_property
    def _i(self) -> int:
        """A square root of -1: a quarter turn."""
        return pow(self._zeta, self._parts // 4, self.prime)

    def _unit(self, angle: Turn) -> int:
        """Return the cosine and i times the sine of an angle."""
        turn, radians, ratios = angle
        whole, left = _split(turn, self._parts)
        z = pow(self._zeta, int(whole * self._parts), self.prime)
        z = z * pow(self._generic[0], int(left * self._leftover), self.prime) % self.prime
        z = z * pow(self._generic[1], int(radians * self._radian), self.prime) % self.prime
        for cosine, sign in ratios:
            sine = sign * self.root(1 - cosine**2)
            z = z * (self.rational(cosine) + self._i * sine) % self.prime
        return z

    def cosine(self, constraint: Constraint) -> int:
        """Return the cosine of an angle, or the sine that takes its place in ALH and AHL."""
        z = self._unit(turn_of(constraint, self.unit))
        return (z + pow(z, -1, self.prime)) * pow(2, -1, self.prime) % self.prime

    def scalar_product(self, constraint: Constraint) -> int:
        """Return what an angle makes ``R u . v`` of directions of any length (Section 4)."""
        norms = self.norm(direction(constraint.platform)) * self.norm(direction(constraint.base))
        cosine = self.cosine(constraint)
        return (-1 if constraint.kind is AHH else 1) * cosine * norms % self.prime


def fields(instance: Instance, *, start: int = FIRST_PRIME) -> Iterator[Homomorphism]:
    """Yield the homomorphisms of an instance to prime fields, from some prime on.

    Raises
    ------
    UnknownNumberError
        If a number of the instance has none.
    """
    angles = turns(instance)
    step = _parts(angles) if angles else 2
    base = coprime_base([*(_OF_UNITY if angles else ()), *radicands(instance, angles)])
    from_root = _OF_UNITY if angles else {}
    candidate = start - start % step + 1
    while candidate < LAST_PRIME:
        candidate += step
        squares = (f in from_root or pow(f, candidate // 2, candidate) == 1 for f in base)
        # Of square roots the test is quicker than that of a prime.
        if all(squares) and sympy.isprime(candidate):
            yield Homomorphism(instance, candidate, base)


def _sha256(instance: Instance) -> str:
    return hashlib.sha256(repr(instance.constraints).encode()).hexdigest()


@cache
def _split(turn: Fraction, parts: int) -> tuple[Fraction, Fraction]:
    """Return a turn as a multiple of a part and a remainder."""
    whole = Fraction(round(turn * parts), parts)
    return whole, turn - whole


def _parts(angles: Sequence[Turn]) -> int:
    """Return into how many parts a turn is divided."""
    parts = FEWEST_PARTS
    for turn, _, _ in angles:
        finer = lcm(parts, turn.denominator)
        parts = finer if finer <= MOST_PARTS else parts
    return parts
