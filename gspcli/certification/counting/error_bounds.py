"""Bounds of the probability that a random prime gives wrong counts.

A count modulo a prime is wrong only if the prime divides one of certain integers, which depend on
the platform only. They are minors of Macaulay's matrices, whose rows are the products of the
equations and monomials up to a degree (proof: docs/exact-counts.md). Hadamard's inequality
bounds their bits, and an integer with these bits has few prime factors above 2^60.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.recorded_varieties import Variety, varieties
from gspcli.certification.counting.coordinate_choice import Blocks
from gspcli.certification.counting.equation_heights import equation_height
from gspcli.certification.counting.exact_platform import ExactConstraint
from gspcli.certification.counting.homomorphism import Requirements
from gspcli.records import dataclass

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
    """Bits of the integers of which a prime with a wrong count is a factor.

    Attributes
    ----------
    height
        The height of every equation.
    variety
        The variety of the motions in the chosen coordinates.
    moments
        The number of further coordinates.
    """

    height: float
    variety: Variety
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
