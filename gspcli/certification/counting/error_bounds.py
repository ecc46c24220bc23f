"""How likely a random prime is to give other counts than the rational numbers.

A count modulo a prime is wrong only if the prime divides certain integers, the contents and leading
coefficients of Chow forms of the intersections of the first k equations in Study coordinates
(docs/exact-counts.md). Their sizes follow from the arithmetic theorem of Bezout (T. Krick,
L. M. Pardo and M. Sombra, Sharp estimates for the arithmetic Nullstellensatz, Duke Math. J. 109
(2001), Corollary 2.11), and so many bits make few primes above 2^60.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction

from gspcli.catalogue.kinds import DLL, DLP, DPL, Kind
from gspcli.certification.counting.elements import Element, Sum
from gspcli.certification.counting.exact_platform import ExactConstraint
from gspcli.certification.counting.homomorphism import Requirements

#: A lower bound for the number of primes between 2^60 and 2^61, by P. Dusart: x/(ln x - 1) is less
#: than pi(x), and x/(ln x - 1.1) more, for x above 60184.
PRIMES = 27_000_000_000_000_000
#: The logarithm to base 2 of the smallest of them.
_BITS = 60
#: The coefficients of linear forms and combinations are drawn from as many numbers at least.
_DRAWN_FROM = 2.0**60
#: A combination of commutators is a polynomial of degree 3 in random numbers: a bound of the
#: probability that one of fewer than a hundred vanishes by chance.
COMMUTATOR_TESTS = 300 / _DRAWN_FROM
#: The Study quadric lies in P^7, has degree 2, and its height is below this number of bits.
_AMBIENT, _DEGREE, _HEIGHT = 7, 2, 16
#: The forms of the functions of a motion have at most 16 terms with coefficients of at most 4 bits;
#: a product of two, with the sums in an equation, stays below this number of bits.
_FORM = 24


def _log_above(value: Fraction | int) -> float:
    """Return a number above the logarithm to base 2 of a number, at least 0."""
    bits = abs(value.numerator).bit_length() - value.denominator.bit_length() + 1
    return float(max(bits, 0))


def _sum_height(terms: Sum) -> float:
    denominator = math.lcm(*(factor.denominator for factor in terms.values()))
    size = sum(
        (abs(factor) * (math.isqrt(term.radicand) + 1) for term, factor in terms.items()),
        Fraction(0),
    )
    return _log_above(denominator) + _log_above(size)


def height(element: Element) -> float:
    """Return a bound, in bits, of the absolute logarithmic height of a number.

    Roots of unity have modulus one in every embedding, and so formally have ``exp(i r)``; pi is
    an independent variable, with coefficient one.
    """
    fraction = element.fraction
    if fraction is not None:
        return _log_above(fraction.denominator) + _log_above(fraction)
    return _sum_height(element.numerator) + _sum_height(element.denominator)


def chow_height(constraints: Sequence[ExactConstraint]) -> float:
    """Return a bound, in bits, of the heights of all intersections of the equations.

    Parameters
    ----------
    constraints
        The exact constraints. Their equations are forms of degree 2 in Study coordinates, of PL, LP
        and LL of degree 4, of degree at most 2 in each of a, b, u and v and 1 in the value.
    """
    degrees = [_study_degree(row.kind) for row in constraints]
    total = float(_HEIGHT)
    for row, degree in zip(constraints, degrees, strict=True):
        vectors = sum(height(x) for x in (*row.a, *row.b, *row.u, *row.v))
        total += _DEGREE * (2 * vectors + height(row.value) + _FORM * degree / 2) / degree
        total += _DEGREE * math.log2(_AMBIENT + 1)
    return math.prod(degrees) * total


def _study_degree(kind: Kind) -> int:
    return 4 if kind in (DPL, DLP, DLL) else 2


def field_degree(requirements: Requirements) -> int:
    """Return a bound of the degree of the number field that the numbers generate."""
    order = requirements.order
    degree = order
    for prime in requirements.order_primes:
        degree -= degree // prime
    return int(degree) << requirements.independent_roots


def error_bounds(
    constraints: Sequence[ExactConstraint], requirements: Requirements, points: int
) -> tuple[float, float]:
    """Return bounds of the probability that a random prime has other counts.

    Parameters
    ----------
    constraints, requirements
        The exact numbers.
    points
        The number of solutions, an upper bound of the number of distinct ones.

    Returns
    -------
    count, distinct
        For whether the solutions are finite in number and how many, with multiplicity; and for how
        many of them are distinct, given that the first is right.
    """
    bits = chow_height(constraints)
    degree = field_degree(requirements)
    # Six steps of intersection, infinity, and once more for what leaves to infinity; N is a
    # quadric, so twice.
    finite = 2 * 8 * bits
    # The discriminant of a separating linear form with coefficients below points^2.
    separation = 2 * max(points - 1, 0) * (bits + points * (2 * math.log2(max(points, 1)) + 3))
    # A form separates the points unless a difference of two vanishes on it, and a projection of the
    # sequence loses a factor of the minimal polynomial, of at most their number.
    form = (points * points + 2 * points) / _DRAWN_FROM
    return (
        min(1.0, degree * finite / _BITS / PRIMES + COMMUTATOR_TESTS),
        min(1.0, degree * separation / _BITS / PRIMES + form),
    )


def total(errors: Iterable[float]) -> float:
    """Return a bound of the probability that any of several events happens."""
    return min(1.0, sum(errors))
