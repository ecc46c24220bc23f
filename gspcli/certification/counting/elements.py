"""Exact arithmetic with square roots, roots of unity, exponentials and pi.

An element is a quotient of two sums of terms ``c sqrt(n) exp(2 pi i q) exp(i r) pi^k`` with
rational c, q and r and integers n > 0 and k. Products of terms are terms, so sums of them are a
ring, in which cosines and sines of ``2 pi q + r`` lie. Square roots are taken of rational elements
only. Values of inverse functions are not in the ring, but cosines and sines of their integer
multiples are.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import NamedTuple

from gspcli.geometry.instance import AngleUnit
from gspcli.geometry.numbers import RATIONAL_OPERATIONS, Number, multiple_of_pi
from gspcli.records import dataclass

HALF = Fraction(1, 2)


class NoElementError(ValueError):
    """A number is not in the ring; the message names the part that is not."""


class Term(NamedTuple):
    """A term without its rational factor."""

    #: N of ``sqrt(n)``, a positive integer that is 1 or no square.
    radicand: int
    #: Q of ``exp(2 pi i q)``, in [0, 1/2): a half turn is the factor -1.
    turn: Fraction
    #: R of ``exp(i r)``.
    radians: Fraction
    #: The power of pi.
    pi: int

    def __hash__(self) -> int:
        """Return a hash without hashes of fractions, which are slow."""
        turn, radians = self.turn, self.radians
        return hash((self.radicand, turn.numerator, radians.numerator, radians.denominator))


ONE = Term(1, Fraction(0), Fraction(0), 0)
Sum = Mapping[Term, Fraction]
#: The denominator one.
WHOLE: Sum = {ONE: Fraction(1)}


def _square_root(n: int) -> int | None:
    root = math.isqrt(n)
    return root if root * root == n else None


def collected(pairs: Iterable[tuple[Term, Fraction]]) -> dict[Term, Fraction]:
    """Return the sum of terms; terms whose roots have a rational quotient are joined."""
    result: dict[Term, Fraction] = {}
    for given, factor in pairs:
        term = given
        if given.turn.numerator:
            turn = given.turn % 1
            if turn >= HALF:
                turn, factor = turn - HALF, -factor
            term = Term(given.radicand, turn, given.radians, given.pi)
        known = result.get(term)
        if known is None and term.radicand != 1:
            for other in result:
                root = _square_root(other.radicand * term.radicand)
                if root is not None and other[1:] == term[1:]:
                    term, factor = other, factor * Fraction(root, other.radicand)
                    known = result[other]
                    break
        result[term] = factor if known is None else known + factor
    if all(factor.numerator for factor in result.values()):
        return result
    return {term: factor for term, factor in result.items() if factor}


def _scaled(terms: Sum, factor: Fraction) -> dict[Term, Fraction]:
    return {term: factor * x for term, x in terms.items()}


def _root(n: int) -> tuple[int, int]:
    """Return m and k with ``sqrt(n) = k sqrt(m)``, m = 1 for a square."""
    root = _square_root(n)
    return (n, 1) if root is None else (1, root)


def _times(a: Sum, b: Sum) -> Sum:
    # Most denominators are one, and most factors rational numbers.
    if a is WHOLE:
        return b
    if b is WHOLE:
        return a
    for one, other in ((a, b), (b, a)):
        if len(one) == 1:
            [(term, factor)] = one.items()
            if term is ONE:
                return other if factor == 1 else _scaled(other, factor)
    pairs = []
    for s, x in a.items():
        for t, y in b.items():
            common = math.gcd(s.radicand, t.radicand)
            radicand, square = _root((s.radicand // common) * (t.radicand // common))
            term = Term(radicand, s.turn + t.turn, s.radians + t.radians, s.pi + t.pi)
            pairs.append((term, x * y * common * square))
    return collected(pairs)


@dataclass(frozen=True)
class FieldElement:
    """A number of the ring's quotient field."""

    #: Sums of terms.
    numerator: Sum
    denominator: Sum

    @classmethod
    def of(cls, value: Fraction | int) -> FieldElement:
        """Return the element of a rational number."""
        factor = value if type(value) is Fraction else Fraction(value)
        return cls({ONE: factor} if factor.numerator else {}, WHOLE)

    @property
    def is_zero(self) -> bool:
        """Whether the sum of terms is empty; a sum of roots of unity may be zero otherwise."""
        return not self.numerator

    @property
    def fraction(self) -> Fraction | None:
        """The rational number, if the sum of terms is one."""
        if not self.numerator:
            return Fraction(0)
        if self.denominator is WHOLE and len(self.numerator) == 1:
            # The usual case, without hashes of terms.
            [(term, factor)] = self.numerator.items()
            if term is ONE:
                return factor
        if self.denominator.keys() == {ONE}:
            # Terms with different roots are not joined, so no other element is rational.
            if self.numerator.keys() != {ONE}:
                return None
            return self.numerator[ONE] / self.denominator[ONE]
        term, factor = next(iter(self.denominator.items()))
        for other, x in self.numerator.items():
            root = _square_root(other.radicand * term.radicand)
            if root is not None and other[1:] == term[1:]:
                quotient = x * Fraction(root, term.radicand) / factor
                rest = self - FieldElement(_scaled(self.denominator, quotient), self.denominator)
                return None if rest.numerator else quotient
        return None

    def __add__(self, other: FieldElement) -> FieldElement:
        same = self.denominator is other.denominator
        if same or self.denominator == other.denominator:
            parts = [self.numerator, other.numerator]
            denominator = self.denominator
        else:
            parts = [
                _times(self.numerator, other.denominator),
                _times(other.numerator, self.denominator),
            ]
            denominator = _times(self.denominator, other.denominator)
        return FieldElement(collected(pair for part in parts for pair in part.items()), denominator)

    def __neg__(self) -> FieldElement:
        return FieldElement(_scaled(self.numerator, Fraction(-1)), self.denominator)

    def __sub__(self, other: FieldElement) -> FieldElement:
        return self + -other

    def __mul__(self, other: FieldElement) -> FieldElement:
        return FieldElement(
            _times(self.numerator, other.numerator), _times(self.denominator, other.denominator)
        )

    def __truediv__(self, other: FieldElement) -> FieldElement:
        if other.is_zero:
            raise NoElementError("a division by zero")
        if len(other.numerator) == 1:
            [(term, factor)] = other.numerator.items()
            if term is ONE:
                inverse_times = _scaled(self.numerator, 1 / factor)
                return FieldElement(_times(inverse_times, other.denominator), self.denominator)
            inverse = Term(term.radicand, -term.turn, -term.radians, -term.pi)
            one_over = collected([(inverse, 1 / (factor * term.radicand))])
            return FieldElement(
                _times(_times(self.numerator, one_over), other.denominator), self.denominator
            )
        return FieldElement(
            _times(self.numerator, other.denominator), _times(self.denominator, other.numerator)
        )

    def sqrt(self) -> FieldElement:
        """Return the nonnegative square root of a nonnegative rational element.

        Raises
        ------
        NoElementError
            If the element is not rational.
        """
        value = self.fraction
        if value is None or value < 0:
            raise NoElementError("a square root of an irrational number")
        if value == 0:
            return self
        radicand, root = _root(value.numerator * value.denominator)
        return FieldElement(
            {ONE._replace(radicand=radicand): Fraction(root, value.denominator)}, WHOLE
        )


_ZERO, _UNIT = FieldElement.of(0), FieldElement.of(1)
_PI_TERM = ONE._replace(pi=1)
_PI = FieldElement({_PI_TERM: Fraction(1)}, WHOLE)
_I = FieldElement({ONE._replace(turn=Fraction(1, 4)): Fraction(1)}, WHOLE)


def element(number: Number) -> FieldElement:
    """Return the element of a number of an instance file.

    Raises
    ------
    NoElementError
        If it has none.
    """
    if number.fraction is not None:
        return FieldElement.of(number.fraction)
    arguments = number.arguments
    match number.operation:
        case "pi":
            return _PI
        case operation if operation in RATIONAL_OPERATIONS:
            result: FieldElement = RATIONAL_OPERATIONS[operation](*map(element, arguments))
            return result
        case "sqrt":
            return element(arguments[0]).sqrt()
        case "cos":
            return Angle.of(arguments[0]).cos()
        case "sin":
            return Angle.of(arguments[0]).sin()
        case "tan":
            return Angle.of(arguments[0]).sin() / Angle.of(arguments[0]).cos()
        case operation:
            raise NoElementError(f"{operation} outside an angle")


def squared(number: Number) -> FieldElement:
    """Return the square of a number; square roots of all elements have one.

    Raises
    ------
    NoElementError
        If it has none.
    """
    if number.fraction is None:
        parts = number.arguments
        match number.operation:
            case "sqrt":
                return element(parts[0])
            case "neg":
                return squared(parts[0])
            case "*":
                return squared(parts[0]) * squared(parts[1])
            case "/":
                return squared(parts[0]) / squared(parts[1])
    value = element(number)
    return value * value


_ARCS = ("acos", "asin", "atan")
_QUARTER = Fraction(1, 4)
#: Four times the squares of the cosines of the multiples of 30 and 45 degrees, by 24ths of a turn.
_SQUARED_COSINES = {0: 4, 2: 3, 3: 2, 4: 1, 6: 0, 8: 1, 9: 2, 10: 3, 12: 4}
_NONE = Fraction(0)


@dataclass(frozen=True)
class Angle:
    """An angle in radians: a multiple of pi, a rational number, and integer multiples of arcs."""

    #: The part without arcs.
    constant: FieldElement
    #: Pairs of an arccosine, arcsine or arctangent and its factor.
    arcs: tuple[tuple[Number, FieldElement], ...] = ()

    @classmethod
    def of(cls, number: Number) -> Angle:
        """Return the angle of a number.

        Raises
        ------
        NoElementError
            If the angle is not in the ring.
        """
        arguments = number.arguments
        if number.fraction is not None:
            return cls(FieldElement.of(number.fraction))
        factor = multiple_of_pi(number)
        if factor is not None:
            return cls(FieldElement({_PI_TERM: factor} if factor else {}, WHOLE))
        match number.operation:
            case "+":
                return cls.of(arguments[0]) + cls.of(arguments[1])
            case "-":
                return cls.of(arguments[0]) + cls.of(arguments[1]).times(-_UNIT)
            case "neg":
                return cls.of(arguments[0]).times(-_UNIT)
            case "*":
                first, second = cls.of(arguments[0]), cls.of(arguments[1])
                return second.times(first.constant) if first.is_constant else first * second
            case "/":
                return cls.of(arguments[0]) * cls(_UNIT / element(arguments[1]))
            case operation if operation in _ARCS:
                return cls(_ZERO, ((number, _UNIT),))
        return cls(element(number))

    @property
    def is_constant(self) -> bool:
        """Whether it contains no arcs."""
        return not self.arcs

    def times(self, factor: FieldElement) -> Angle:
        """Return a multiple."""
        arcs = tuple((arc, coefficient * factor) for arc, coefficient in self.arcs)
        return Angle(self.constant * factor, arcs)

    def __add__(self, other: Angle) -> Angle:
        return Angle(self.constant + other.constant, self.arcs + other.arcs)

    def __mul__(self, other: Angle) -> Angle:
        if not other.is_constant:
            raise NoElementError("a product of arcs")
        return self.times(other.constant)

    def cos(self) -> FieldElement:
        """Return the cosine."""
        if self.is_constant:
            return _cosine(*self._turn_and_radians())
        plus, minus = self._exponentials()
        return (plus + minus) / FieldElement.of(2)

    def sin(self) -> FieldElement:
        """Return the sine."""
        if self.is_constant:
            turn, radians = self._turn_and_radians()
            return _cosine(turn - _QUARTER, radians)
        plus, minus = self._exponentials()
        return (plus - minus) / (FieldElement.of(2) * _I)

    def _turn_and_radians(self) -> tuple[Fraction, Fraction]:
        """Return q and r of the constant part ``2 pi q + r``."""
        numerator, denominator = self.constant.numerator, self.constant.denominator
        if denominator is WHOLE and len(numerator) == 1 and _PI_TERM in numerator:
            # The usual case.
            return numerator[_PI_TERM] / 2, _NONE
        radians = self.constant.fraction
        if radians is not None:
            return Fraction(0), radians
        if numerator.keys() <= {ONE, _PI_TERM} and denominator.keys() == {ONE}:
            unit = denominator[ONE]
            turn = numerator.get(_PI_TERM, _NONE) / unit / 2
            return turn, numerator.get(ONE, _NONE) / unit
        raise NoElementError("an angle that is not rational in degrees or radians")

    def _exponentials(self) -> tuple[FieldElement, FieldElement]:
        """Return ``exp(i x)`` and ``exp(-i x)``."""
        turn, radians = self._turn_and_radians()
        results = [
            FieldElement(collected([(Term(1, s * turn, s * radians, 0), Fraction(1))]), WHOLE)
            for s in (1, -1)
        ]
        for arc, coefficient in self.arcs:
            times = coefficient.fraction
            if times is None or times.denominator != 1:
                raise NoElementError(f"a part of {arc.operation}")
            pair = _arc_exponentials(arc)
            for _ in range(abs(int(times))):
                for k in (0, 1):
                    results[k] *= pair[k if times > 0 else 1 - k]
        return results[0], results[1]


def _arc_exponentials(arc: Number) -> tuple[FieldElement, FieldElement]:
    """Return ``exp(i x)`` and ``exp(-i x)`` of an arccosine, arcsine or arctangent."""
    x = element(arc.arguments[0])
    if arc.operation == "atan":
        size = (_UNIT + x * x).sqrt()
        real, imaginary = _UNIT / size, x / size
    else:
        real, imaginary = x, (_UNIT - x * x).sqrt()
        if arc.operation == "asin":
            real, imaginary = imaginary, real
    return real + _I * imaginary, real - _I * imaginary


def _cosine(turn: Fraction, radians: Fraction) -> FieldElement:
    """Return the cosine of a part of a turn and some radians."""
    if radians:
        terms = [(Term(1, sign * turn, sign * radians, 0), HALF) for sign in (1, -1)]
        return FieldElement(collected(terms), WHOLE)
    whole = turn.denominator
    part = turn.numerator % whole
    part = min(part, whole - part)
    twentyfourths, rest = divmod(24 * part, whole)
    if not rest and twentyfourths in _SQUARED_COSINES:
        square = FieldElement.of(Fraction(_SQUARED_COSINES[twentyfourths], 4))
        return square.sqrt() if twentyfourths < 6 else -square.sqrt()
    # exp(-2 pi i q) is minus exp(2 pi i (1/2 - q)).
    terms_of_both = {
        Term(1, Fraction(part, whole), _NONE, 0): HALF,
        Term(1, Fraction(whole - 2 * part, 2 * whole), _NONE, 0): -HALF,
    }
    return FieldElement(terms_of_both, WHOLE)


def in_radians(angle: Number, unit: AngleUnit) -> Angle:
    """Return an angle of an instance in radians."""
    value = Angle.of(angle)
    return value if unit is AngleUnit.RADIAN else value.times(_PI / FieldElement.of(180))
