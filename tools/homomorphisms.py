"""The numbers of an instance modulo a prime, by one ring homomorphism.

What holds between the numbers holds between their residues: the square root of a product is the
product of the square roots, cosines of degrees come from one root of unity, and so do the square
roots of 2, 3 and 5 beside them. Of an angle that is no small fraction of a turn the part that is
left over after whole degrees is a generic turn, the same power of it for the same multiple: its
sine and cosine are algebraic of a degree beyond that of any condition here, or transcendental.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cache
from math import gcd, isqrt, lcm
from random import Random

import flint
import sympy
from residues import direction

from gspcli.catalogue.kinds import AHH, ALL
from gspcli.certification.balls import ball
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point, Vector

#: Whole turns are divided into so many parts at most: primes with so many roots of unity are rare.
MOST_PARTS = 360_000
#: Roots of unity beside any angle: they make the square roots of 2, 3 and 5.
FEWEST_PARTS = 360
#: Below the 2^31 that msolve and Singular allow, above the 2^29 that 30-bit arithmetic needs.
FIRST_PRIME, LAST_PRIME = 2**29, 2**31


#: Square roots beside any angle are sums of roots of unity of these orders.
_OF_UNITY = {2: 8, 3: 12, 5: 5}


class NoHomomorphismError(Exception):
    """The instance has a number of which no residue is known for any prime."""


class Homomorphism:
    """The homomorphism of one instance to one prime field, made by `fields`."""

    def __init__(self, instance: Instance, prime: int, base: Sequence[int]) -> None:
        self.prime = prime
        self.unit = instance.units.angle
        angles = [_turn(c, self.unit) for c in instance.constraints if not c.kind.is_distance]
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
        whole, rest = _without_squares(value.numerator * value.denominator)
        root = whole * self.rational(Fraction(1, value.denominator))
        for factor, residue in self._roots.items():
            power = 0
            while rest % factor == 0:
                rest, power = rest // factor, power + 1
            root = root * pow(residue, power, self.prime) % self.prime
        if isqrt(rest) ** 2 != rest:
            message = f"no residue of the square root of {rest} is known"
            raise NoHomomorphismError(message)
        return root * isqrt(rest) % self.prime

    def number(self, number: Number) -> int:
        """Return the residue of an exact number made of fractions and their square roots."""
        if number.fraction is not None:
            return self.rational(number.fraction)
        if number.operation == "sqrt" and number.arguments[0].fraction is not None:
            return self.root(number.arguments[0].fraction)
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
                raise NoHomomorphismError(message)
        return result % self.prime

    def vector(self, exact: Vector) -> list[int]:
        """Return the residues of the components of a vector."""
        return [self.number(x) for x in exact]

    def norm(self, exact: Vector) -> int:
        """Return the length of a direction."""
        return self.root(_square(exact))

    def square(self, number: Number) -> int:
        """Return the square of a number: of a square root the radicand, whether it has one."""
        if number.operation == "sqrt":
            return self.number(number.arguments[0])
        return pow(self.number(number), 2, self.prime)

    def cosine(self, constraint: Constraint, unit: AngleUnit) -> int:
        """Return the cosine of an angle, or the sine that takes its place in ALH and AHL."""
        turn, radians, ratios = _turn(constraint, unit)
        whole, left = _split(turn, self._parts)
        z = pow(self._zeta, int(whole * self._parts), self.prime)
        z = z * pow(self._generic[0], int(left * self._leftover), self.prime) % self.prime
        z = z * pow(self._generic[1], int(radians * self._radian), self.prime) % self.prime
        i = pow(self._zeta, self._parts // 4, self.prime)
        for cosine, sign in ratios:
            sine = sign * self.root(1 - cosine**2)
            z = z * (self.rational(cosine) + i * sine) % self.prime
        doubled = z + pow(z, -1, self.prime)
        half = pow(2, -1, self.prime)
        return doubled * half % self.prime

    def scalar_product(self, constraint: Constraint) -> int:
        """Return what an angle makes ``R u . v`` of directions of any length (Section 4)."""
        norms = self.norm(direction(constraint.platform)) * self.norm(direction(constraint.base))
        cosine = self.cosine(constraint, self.unit)
        return (-1 if constraint.kind is AHH else 1) * cosine * norms % self.prime


class Rationals:
    """The numbers of an instance that has only rational ones, with the methods of `Homomorphism`.

    Methods raise `NoHomomorphismError` where a number is irrational.
    """

    prime = 0

    def __init__(self, instance: Instance) -> None:
        self.unit = instance.units.angle

    def number(self, number: Number) -> Fraction:
        """Return a number."""
        if number.fraction is None:
            message = f"{number} is irrational"
            raise NoHomomorphismError(message)
        return number.fraction

    def vector(self, exact: Vector) -> list[Fraction]:
        """Return a vector."""
        return [self.number(x) for x in exact]

    def norm(self, exact: Vector) -> Fraction:
        """Return the length of a direction."""
        return _rational_root(_square(exact))

    def square(self, number: Number) -> Fraction:
        """Return the square of a number."""
        if number.operation == "sqrt":
            return self.number(number.arguments[0])
        return self.number(number) ** 2

    def scalar_product(self, constraint: Constraint) -> Fraction:
        """Return what an angle makes ``R u . v`` of directions of any length (Section 4)."""
        turn, radians, cosines = _turn(constraint, self.unit)
        of_turn = _RATIONAL_COSINES.get(turn % 1)
        if radians or len(cosines) > 1 or (cosines and turn):
            of_turn = None
        if of_turn is None:
            message = f"the cosine of {constraint.value} is irrational"
            raise NoHomomorphismError(message)
        cosine = cosines[0][0] if cosines else of_turn
        square = _square(direction(constraint.platform)) * _square(direction(constraint.base))
        norms = _rational_root(square) if cosine else Fraction(0)
        return (-1 if constraint.kind is AHH else 1) * cosine * norms


class Rounded(Rationals):
    """Rational numbers near those of an instance: irrational ones are rounded."""

    def __init__(self, instance: Instance, decimals: int) -> None:
        super().__init__(instance)
        self.decimals = decimals

    def _rounded(self, ball: flint.arb) -> Fraction:
        scaled = ball * flint.arb(10) ** self.decimals
        return Fraction(int(scaled.mid().floor().unique_fmpz()), 10**self.decimals)

    def _root(self, value: Fraction) -> Fraction:
        with flint.ctx.workdps(self.decimals + 30):
            return self._rounded(flint.arb(_rational(value)).sqrt())

    def number(self, number: Number) -> Fraction:
        """Return a number, rounded if it is irrational."""
        if number.fraction is not None:
            return number.fraction
        with flint.ctx.workdps(self.decimals + 30):
            return self._rounded(ball(number))

    def norm(self, exact: Vector) -> Fraction:
        """Return the length of a direction."""
        try:
            return super().norm(exact)
        except NoHomomorphismError:
            return self._root(_square(exact))

    def scalar_product(self, constraint: Constraint) -> Fraction:
        """Return what an angle makes ``R u . v`` of directions of any length (Section 4)."""
        try:
            return super().scalar_product(constraint)
        except NoHomomorphismError:
            pass
        turn, radians, cosines = _turn(constraint, self.unit)
        with flint.ctx.workdps(self.decimals + 30):
            angle = flint.arb(_rational(turn)) * 2 * flint.arb.pi() + flint.arb(_rational(radians))
            for cosine, sign in cosines:
                angle += sign * flint.arb(_rational(cosine)).acos()
            square = _square(direction(constraint.platform)) * _square(direction(constraint.base))
            product = self._rounded(angle.cos() * flint.arb(_rational(square)).sqrt())
        return (-1 if constraint.kind is AHH else 1) * product


def _rational(value: Fraction) -> flint.fmpq:
    return flint.fmpq(value.numerator, value.denominator)


_RATIONAL_COSINES = {
    Fraction(turn, 12): Fraction(cosine, 2)
    for turn, cosine in ((0, 2), (2, 1), (3, 0), (4, -1), (6, -2), (8, -1), (9, 0), (10, 1))
}


def _rational_root(value: Fraction) -> Fraction:
    root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
    if root**2 != value:
        message = f"the square root of {value} is irrational"
        raise NoHomomorphismError(message)
    return root


def fields(instance: Instance, *, start: int = FIRST_PRIME) -> Iterator[Homomorphism]:
    """Yield the homomorphisms of an instance to prime fields, from some prime on.

    Raises
    ------
    NoHomomorphismError
        If a number of the instance has none.
    """
    unit = instance.units.angle
    angles = [_turn(c, unit) for c in instance.constraints if not c.kind.is_distance]
    step = _parts(angles) if angles else 2
    base = _coprime_base([*(_OF_UNITY if angles else ()), *_radicands(instance, angles)])
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


#: Turns, radians, and inverse cosines with their signs, that add up to an angle.
Turn = tuple[Fraction, Fraction, tuple[tuple[Fraction, int], ...]]


def _turn(constraint: Constraint, unit: AngleUnit) -> Turn:
    """Return the angle whose cosine is used: turns, radians, and cosines of further angles."""
    turn, radians, cosines = _linear(constraint.value)
    if unit is AngleUnit.DEGREE:
        if turn or cosines:
            message = f"no residue of {constraint.value} degrees is known"
            raise NoHomomorphismError(message)
        turn, radians = radians / 360, Fraction(0)
    if constraint.kind not in (ALL, AHH):
        # The sine is the cosine of a quarter turn less the angle, or of the angle less that.
        turn -= Fraction(1, 4)
    return turn, radians, cosines


def _linear(number: Number) -> Turn:
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
            turn, radians, cosines = _linear(first)
            if not cosines:
                return turn * factor, radians * factor, ()
    message = f"no residue of the sine and cosine of {number} is known"
    raise NoHomomorphismError(message)


@cache
def _split(turn: Fraction, parts: int) -> tuple[Fraction, Fraction]:
    """Return a turn as a multiple of a part and what is left over."""
    whole = Fraction(round(turn * parts), parts)
    return whole, turn - whole


def _parts(angles: Sequence[Turn]) -> int:
    """Return into how many parts a turn is divided."""
    parts = FEWEST_PARTS
    for turn, _, _ in angles:
        finer = lcm(parts, turn.denominator)
        parts = finer if finer <= MOST_PARTS else parts
    return parts


def _square(exact: Vector) -> Fraction:
    total = Fraction(0)
    for x in exact:
        if x.fraction is None:
            squared = Number("*", (x, x)) if x.operation != "sqrt" else x.arguments[0]
            if squared.fraction is None:
                message = f"no residue of the length of {x}, ... is known"
                raise NoHomomorphismError(message)
            total += squared.fraction
        else:
            total += x.fraction**2
    return total


def _radicands(instance: Instance, angles: Sequence[Turn]) -> Iterator[int]:
    """Yield numbers of which square roots are needed, without their square factors."""
    for constraint in instance.constraints:
        kind, value = constraint.kind, constraint.value
        sided = kind.is_distance and constraint.side is not Side.BOTH
        if not kind.is_distance or sided:
            for body in (constraint.platform, constraint.base):
                if not isinstance(body, Point):
                    yield from _radicand(_square(direction(body)))
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
    rest = _without_squares(value.numerator * value.denominator)[1]
    if rest > 1:
        yield rest


def _without_squares(number: int) -> tuple[int, int]:
    """Return a factor whose square divides a number, and the number without it."""
    if number and isqrt(number) ** 2 == number:
        return isqrt(number), 1
    whole = 1
    for prime in sympy.primerange(100):
        while number and number % (prime * prime) == 0:
            number, whole = number // (prime * prime), whole * prime
    return whole, number


def _coprime_base(numbers: Sequence[int]) -> list[int]:
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
