"""Bounds of the probability that a random prime gives wrong counts.

A count modulo a prime is wrong only if the prime divides one of certain integers, which depend on
the platform only. They are minors of Macaulay's matrices, whose rows are the products of the
equations and monomials up to a degree (proof: docs/exact-counts.md). Hadamard's inequality
bounds their bits, and an integer with these bits has few prime factors above 2^60.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction

from flint import fmpq

from gspcli.catalogue.bounds import Variety, varieties
from gspcli.catalogue.kinds import DLL, DLP, DPL
from gspcli.certification.counting.elements import ONE, WHOLE, FieldElement, Term
from gspcli.certification.counting.modular_platform import Requirements
from gspcli.certification.counting.motion_equations import (
    Blocks,
    ExactConstraint,
    MotionEquation,
    equations,
    evaluated,
    with_moments,
)
from gspcli.records import dataclass

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


#: A lower bound for the number of primes between 2^60 and 2^61, by P. Dusart: x/(ln x - 1) is less
#: than pi(x), and x/(ln x - 1.1) more, for x above 60184.
PRIMES = 27_000_000_000_000_000
#: The logarithm to base 2 of the smallest of them.
_BITS = 60
#: The coefficients of linear forms and combinations are drawn from at least this many numbers.
_DRAWN_FROM = 2.0**60
#: A combination of commutators is a polynomial of degree 3 in random numbers: a bound of the
#: probability that one of fewer than a hundred vanishes by chance.
COMMUTATOR_TESTS = 300 / _DRAWN_FROM
#: The logarithm of the length of an equation of the motions: at most four terms, one or minus one.
_OF_MOTIONS = 1.0
#: The recorded varieties of the motions.
_COORDINATES = {
    Blocks.TRANSLATION: "R,T",
    Blocks.BODY: "R,U",
    Blocks.TRANSLATION | Blocks.BODY: "R,T,U",
    Blocks.TRANSLATION | Blocks.BODY | Blocks.DISTANCE: "R,T,U,rho",
}
#: Quadrics that contain a mutual moment are sums of products of degree 4 of the moments'
#: definitions, the motions' equations, and coordinates.
_MOMENT_EXCESS = 2


def field_degree(requirements: Requirements) -> int:
    """Return a bound of the degree of the number field that the numbers generate."""
    order = requirements.order
    degree = order
    for prime in requirements.order_primes:
        degree -= degree // prime
    return int(degree) << requirements.independent_roots


@dataclass(frozen=True)
class MinorBits:
    """Bits of the integers of which a prime with a wrong count is a factor."""

    #: The height of every equation.
    height: float
    #: The variety of the motions in the chosen coordinates.
    variety: Variety
    #: The number of further coordinates.
    moments: int

    @classmethod
    def of(cls, constraints: Sequence[ExactConstraint], blocks: Blocks) -> MinorBits:
        """Return the bits for a platform in some coordinates."""
        moments = sum(row.kind is DLL for row in constraints)
        return cls(equation_height(constraints), varieties()[_COORDINATES[blocks]], moments)

    def finite(self, reach: int) -> float:
        """Return the bits for a finite count that was found with products up to a degree.

        For each degree e up to this degree and each d below e there is one minor: that of the
        columns of degree above d.
        """
        degrees = self._degrees(reach)
        rows = [self._rows(e) for e in range(degrees.stop)]
        return sum(rows[e] - rows[d] for e in degrees for d in range(e))

    def infinite(self, reach: int) -> float:
        """Return the bits for infinitely many solutions: all leading minors of each degree."""
        return sum(self._monomials(e) * self._rows(e) for e in self._degrees(reach))

    def distinct(self, reach: int, points: int) -> float:
        """Return the bits for the number of distinct points: discriminants."""
        each = 2 * max(points - 1, 0) * points
        return each * self._entries(reach, points)

    def vanishing(self, reach: int, points: int, conditions: int) -> float:
        """Return the bits for zeros of conditions: coefficients of characteristic polynomials."""
        # Conditions are linear in coordinates, or squares of linear functions.
        return conditions * points * (2 * self._entries(reach, points) + self.height)

    def _degrees(self, reach: int) -> range:
        return range(2, reach + (_MOMENT_EXCESS if self.moments else 0) + 1)

    def _monomials(self, degree: int) -> int:
        """Return the number of monomials up to a degree."""
        return math.comb(self.variety.ambient_dimension + self.moments + degree, degree)

    def _functions(self, degree: int) -> int:
        """Return the number of monomials up to a degree that are independent on the motions."""
        dimension = self.variety.dimension + self.moments
        return sum(
            coefficient * math.comb(dimension + degree - k, dimension)
            for k, coefficient in enumerate(self.variety.hilbert_numerator)
            if k <= degree
        )

    def _rows(self, degree: int) -> float:
        """Return the bits of independent products of equations up to a degree.

        This is the number of products of the constraints' equations, after those of the motions.
        """
        return self.height * self._functions(degree) + _OF_MOTIONS * self._monomials(degree)

    def _entries(self, reach: int, points: int) -> float:
        """Return the bits of multiplication matrices with their common denominators."""
        variables = self.variety.ambient_dimension + self.moments
        constants = 4 * math.log2(max(points, 1) * variables)
        return sum(self._rows(e) + constants for e in self._degrees(reach))


@dataclass(frozen=True)
class ErrorBounds:
    """Bounds of the probability that a random prime has wrong counts, for one platform."""

    bits: MinorBits
    degree: int
    is_rational: bool

    @classmethod
    def of(
        cls, constraints: Sequence[ExactConstraint], requirements: Requirements, blocks: Blocks
    ) -> ErrorBounds:
        """Return the bounds for a platform with exact numbers in some coordinates."""
        is_rational = all(x.fraction is not None for row in constraints for x in row.numbers)
        bits = MinorBits.of(constraints, blocks)
        return cls(bits, field_degree(requirements), is_rational)

    def count(self, reach: int, *, finite: bool) -> float:
        """Return the bound for a count, or for the solutions being infinitely many."""
        bits = self.bits.finite(reach) if finite else self.bits.infinite(reach)
        return min(1.0, self._probability(bits) + COMMUTATOR_TESTS)

    def distinct(self, reach: int, points: int) -> float:
        """Return the bound for the number of distinct solutions, if the count is right."""
        # A form separates the points unless a difference of two vanishes on it, and a projection
        # of the sequence loses a factor of the minimal polynomial, of at most their number.
        form = (points * points + 2 * points) / _DRAWN_FROM
        return min(1.0, self._probability(self.bits.distinct(reach, points)) + form)

    def spurious(self, reach: int, points: int, moments: int) -> float:
        """Return the bound for the number of spurious solutions, if the counts are right."""
        # For each set of DLL and each subset the number of solutions with certain zero conditions.
        pairs: int = 3**moments
        form = pairs * (points * points + 3 * points) / _DRAWN_FROM
        conditions = 2 * moments * pairs
        return min(1.0, self._probability(self.bits.vanishing(reach, points, conditions)) + form)

    def vanishing(self, reach: int, points: int, conditions: int) -> float:
        """Return the bound for conditions that vanish at all of a number of points."""
        # Each condition has a random vector: it may vanish by chance at a point.
        form = conditions * points / _DRAWN_FROM
        bits = self.bits.vanishing(reach, points, conditions)
        return min(1.0, self._probability(bits) + form)

    def _probability(self, bits: float) -> float:
        # A transcendental number has a random image. Minors are polynomials in it, of degrees below
        # their bits, and vanish with a probability below degree / 2^60.
        of_images = 0.0 if self.is_rational else bits / _DRAWN_FROM
        return self.degree * bits / _BITS / PRIMES + of_images


def total(errors: Iterable[float]) -> float:
    """Return a bound of the probability that any of several events happens."""
    return min(1.0, sum(errors))
