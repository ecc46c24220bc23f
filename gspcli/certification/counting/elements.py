"""Exact arithmetic with square roots, roots of unity, exponentials and pi.

An element is a quotient of two sums of terms ``c sqrt(n) exp(2 pi i q) exp(i r) pi^k`` with
rational c, q and r and integers n > 0 and k. Products of terms are terms, so sums of them are a
ring, in which cosines and sines of ``2 pi q + r`` lie.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import NamedTuple

from gspcli.records import dataclass

HALF = Fraction(1, 2)


class NoElementError(ValueError):
    """A number is not in the ring; the message names the part that is not."""


class Term(NamedTuple):
    """A term without its rational factor.

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
    """A number of the ring's quotient field.

    Attributes
    ----------
    numerator, denominator
        Sums of terms.
    """

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
            message = "a division by zero"
            raise NoElementError(message)
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
            message = "a square root of an irrational number"
            raise NoElementError(message)
        if value == 0:
            return self
        radicand, root = _root(value.numerator * value.denominator)
        return FieldElement(
            {ONE._replace(radicand=radicand): Fraction(root, value.denominator)},
            WHOLE,
        )
