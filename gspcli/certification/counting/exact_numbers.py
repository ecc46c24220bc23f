"""Exact arithmetic with the numbers of instance files: square roots, cosines, pi.

An element is a quotient of two sums of terms ``c sqrt(n) exp(2 pi i q) exp(i r) pi^k`` with
rational c, q and r and integers n > 0 and k. Products of terms are terms, so sums of them are a
ring, in which cosines and sines of ``2 pi q + r`` lie. A square root is taken of rational
elements only, and nothing is known of inverse functions: those numbers have no element.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from gspcli.geometry.instance import AngleUnit
from gspcli.geometry.numbers import Number

_HALF = Fraction(1, 2)


class NoElementError(ValueError):
    """A number lies outside the ring; the message says which part of it."""


class Term(NamedTuple):
    """What a term is, but for its rational factor.

    Attributes
    ----------
    radicand
        n of ``sqrt(n)``, a positive integer that is 1 or no square.
    turn
        q of ``exp(2 pi i q)``, in [0, 1/2): a half turn is the factor -1.
    radians
        r of ``exp(i r)``.
    pi
        The power of pi.
    """

    radicand: int
    turn: Fraction
    radians: Fraction
    pi: int


ONE = Term(1, Fraction(0), Fraction(0), 0)
Sum = Mapping[Term, Fraction]


def _square_root(n: int) -> int | None:
    root = math.isqrt(n)
    return root if root * root == n else None


def _collected(pairs: Iterable[tuple[Term, Fraction]]) -> dict[Term, Fraction]:
    """Return the sum of terms, those whose roots have a rational quotient as one."""
    result: dict[Term, Fraction] = {}
    for given, factor in pairs:
        turn = given.turn % 1
        if turn >= _HALF:
            turn, factor = turn - _HALF, -factor
        term = Term(given.radicand, turn, given.radians, given.pi)
        if term not in result and term.radicand != 1:
            for other in result:
                root = _square_root(other.radicand * term.radicand)
                if root is not None and other[1:] == term[1:]:
                    term, factor = other, factor * Fraction(root, other.radicand)
                    break
        result[term] = result.get(term, Fraction(0)) + factor
    return {term: factor for term, factor in result.items() if factor != 0}


def _scaled(terms: Sum, factor: Fraction) -> dict[Term, Fraction]:
    return {term: factor * x for term, x in terms.items()}


def _root(n: int) -> tuple[int, int]:
    """Return m and k with ``sqrt(n) = k sqrt(m)``, m = 1 for a square."""
    root = _square_root(n)
    return (n, 1) if root is None else (1, root)


def _times(a: Sum, b: Sum) -> dict[Term, Fraction]:
    pairs = []
    for s, x in a.items():
        for t, y in b.items():
            common = math.gcd(s.radicand, t.radicand)
            radicand, square = _root((s.radicand // common) * (t.radicand // common))
            term = Term(radicand, s.turn + t.turn, s.radians + t.radians, s.pi + t.pi)
            pairs.append((term, x * y * common * square))
    return _collected(pairs)


@dataclass(frozen=True)
class Element:
    """A number of the ring's quotient field.

    Attributes
    ----------
    numerator, denominator
        Sums of terms.
    """

    numerator: Sum
    denominator: Sum

    @classmethod
    def of(cls, value: Fraction | int) -> Element:
        """Return the element of a rational number."""
        return cls({ONE: Fraction(value)} if value else {}, {ONE: Fraction(1)})

    @property
    def is_zero(self) -> bool:
        """Whether it is zero as a sum of terms; sums of roots of unity may hide other zeros."""
        return not self.numerator

    @property
    def fraction(self) -> Fraction | None:
        """The rational number that it is as a sum of terms, if it is one."""
        if not self.numerator:
            return Fraction(0)
        term, factor = next(iter(self.denominator.items()))
        for other, x in self.numerator.items():
            root = _square_root(other.radicand * term.radicand)
            if root is not None and other[1:] == term[1:]:
                quotient = x * Fraction(root, term.radicand) / factor
                rest = self - Element(_scaled(self.denominator, quotient), self.denominator)
                return None if rest.numerator else quotient
        return None

    def __add__(self, other: Element) -> Element:
        if self.denominator == other.denominator:
            parts = [self.numerator, other.numerator]
            denominator = self.denominator
        else:
            parts = [
                _times(self.numerator, other.denominator),
                _times(other.numerator, self.denominator),
            ]
            denominator = _times(self.denominator, other.denominator)
        return Element(_collected(pair for part in parts for pair in part.items()), denominator)

    def __neg__(self) -> Element:
        return Element(_scaled(self.numerator, Fraction(-1)), self.denominator)

    def __sub__(self, other: Element) -> Element:
        return self + -other

    def __mul__(self, other: Element) -> Element:
        return Element(
            _times(self.numerator, other.numerator), _times(self.denominator, other.denominator)
        )

    def __truediv__(self, other: Element) -> Element:
        if other.is_zero:
            message = "a division by zero"
            raise NoElementError(message)
        return Element(
            _times(self.numerator, other.denominator), _times(self.denominator, other.numerator)
        )

    def sqrt(self) -> Element:
        """Return the nonnegative square root of a nonnegative rational element.

        Raises
        ------
        NoElementError
            If the element is not rational.
        """
        value = self.fraction
        if value is None or value < 0:
            message = "a square root of an irrational number"
            raise NoElementError(message)
        if value == 0:
            return self
        radicand, root = _root(value.numerator * value.denominator)
        return Element(
            {ONE._replace(radicand=radicand): Fraction(root, value.denominator)},
            {ONE: Fraction(1)},
        )

    def _angle(self) -> tuple[Fraction, Fraction]:
        """Return q and r of an angle ``2 pi q + r``."""
        if self.denominator.keys() == {ONE}:
            pi = ONE._replace(pi=1)
            if self.numerator.keys() <= {ONE, pi}:
                unit = self.denominator[ONE]
                zero = Fraction(0)
                turn = self.numerator.get(pi, zero) / unit / 2
                return turn, self.numerator.get(ONE, zero) / unit
        message = "an angle that is not rational in degrees or radians"
        raise NoElementError(message)

    def cos(self) -> Element:
        """Return the cosine of an angle in radians, rational in degrees or in radians."""
        return _cosine(*self._angle())

    def sin(self) -> Element:
        """Return the sine of such an angle."""
        turn, radians = self._angle()
        return _cosine(turn - Fraction(1, 4), radians)

    def tan(self) -> Element:
        """Return the tangent of such an angle."""
        return self.sin() / self.cos()


def _cosine(turn: Fraction, radians: Fraction) -> Element:
    """Return the cosine of a part of a turn and some radians."""
    turn = turn if radians else abs((turn + _HALF) % 1 - _HALF)
    if not radians and turn in _SQUARED_COSINES:
        square = Element.of(_SQUARED_COSINES[turn])
        return square.sqrt() if turn < Fraction(1, 4) else -square.sqrt()
    terms = [(Term(1, sign * turn, sign * radians, 0), _HALF) for sign in (1, -1)]
    return Element(_collected(terms), {ONE: Fraction(1)})


#: The squares of the cosines of the multiples of 30 and 45 degrees, by parts of a turn.
_SQUARED_COSINES = {
    Fraction(part, 24): Fraction(fourths, 4)
    for part, fourths in {0: 4, 2: 3, 3: 2, 4: 1, 6: 0, 8: 1, 9: 2, 10: 3, 12: 4}.items()
}


class _ElementField:
    """Evaluates a `Number` to its element."""

    def rational(self, value: Fraction) -> Element:
        return Element.of(value)

    def pi(self) -> Element:
        return Element({ONE._replace(pi=1): Fraction(1)}, {ONE: Fraction(1)})

    def function(self, name: str, argument: Element) -> Element:
        known = {
            "sqrt": argument.sqrt,
            "cos": argument.cos,
            "sin": argument.sin,
            "tan": argument.tan,
        }
        if name not in known:
            message = f"the inverse function {name}"
            raise NoElementError(message)
        return known[name]()


_FIELD = _ElementField()


def element(number: Number) -> Element:
    """Return the element of a number of an instance file.

    Raises
    ------
    NoElementError
        If it has none.
    """
    if number.fraction is not None:
        return Element.of(number.fraction)
    return number.evaluate(_FIELD)


def squared(number: Number) -> Element:
    """Return the square of a number; there is one of any square root of an element.

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


def in_radians(angle: Number, unit: AngleUnit) -> Element:
    """Return an angle of an instance in radians."""
    value = element(angle)
    if unit is AngleUnit.RADIAN:
        return value
    return value * _FIELD.pi() / Element.of(180)
