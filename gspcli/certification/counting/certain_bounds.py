"""Upper bounds of the number of poses that no choice of a prime can make wrong.

A count modulo a prime is certain as a lower bound. It is an upper bound unless solutions go to
infinity modulo the prime. So the solutions at infinity are stated over the rational numbers, by
exact functionals. All else follows from ranks modulo one prime, which are never too large.

Let P_d be the polynomials of degree up to d in the coordinates that the linear constraints leave
free. Let q_j be the quadrics that vanish on the motions, in these coordinates, and I their ideal.
Let V be the span of the products of monomials and q_j up to degree D, over Q or modulo p, and let
``top`` take the terms of degree D.

- Suppose that m independent rational functionals vanish on top(V) over Q, and that top(V) has
  codimension m modulo p. Then it has codimension m over Q, and its integral points are saturated
  at p. So every element of V modulo p without terms of degree D lifts to one over Q. Proof: let Z
  lift it. Then top(Z) / p is the top of an element Y of V that is integral at p, and Z - p Y has
  no terms of degree D.
- Add to V the products of the variables and of these lifts, F. If top(V) is then all forms modulo
  p, it is so over Q. Then each polynomial of degree D is one of degree D - 1 modulo I, and by
  induction so is every polynomial. So P/I has at most the dimension of P_{D-1} / F. Further rounds
  lift in the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import chain, combinations_with_replacement, product
from math import isqrt
from typing import Any

from flint import fmpq, fmpq_mat, fmpz, fmpz_mat, nmod_mat

from gspcli.certification.counting.elements import NoElementError
from gspcli.certification.counting.exact_platform import (
    EvaluatedConstraint,
    evaluated,
    exact_constraints,
)
from gspcli.certification.counting.motion_equations import equations
from gspcli.certification.counting.residue_counts import motion_forms
from gspcli.certification.equations import study
from gspcli.geometry.instance import Instance
from gspcli.records import dataclass

#: A monomial: the numbers of its variables from 1, ascending.
Monomial = tuple[int, ...]
#: A quadric: integer coefficients by monomials of degree up to two.
Quadric = dict[Monomial, int]

#: 1, R, T, U and T.T, which the linear constraints are combinations of; 1 is the first.
_FUNCTIONS = (study.NORM, *chain(*study.ROTATION), *study.TRANSLATION, *study.BODY, study.RHO)
#: Free coordinates that six independent linear constraints leave: more are too much work.
_VARIABLES = len(_FUNCTIONS) - 1 - 6
#: Degrees D that are tried.
_DEGREES = (3, 4)
#: The prime of all ranks; the functionals are found modulo the next ones, this many at most.
_PRIME = 2**61 - 1
_MOST_PRIMES = 64
#: A fraction is accepted that needs so many bits fewer than it could have. It is then verified.
_SPARE_BITS = 40


def certain_bound(instance: Instance, enough: int = 0) -> int | None:
    """Return a number of poses that a platform cannot exceed, multiplicities counted.

    Parameters
    ----------
    instance
        A platform, for the sides asked for.
    enough
        A bound that need not be lowered any more.

    Returns
    -------
    int or None
        None if a number is not rational, if a constraint is not linear in R, T, U and T.T, or if
        the argument does not succeed.
    """
    try:
        exact = exact_constraints(instance)
    except NoElementError:
        return None
    if any(number.fraction is None for row in exact for number in row.numbers):
        return None
    rows = [evaluated(row, lambda number: _rational(number.fraction)) for row in exact]
    total = 0
    for signs in product(*(row.sides for row in exact)):
        bound = _of_side([row.on_side(sign) for row, sign in zip(rows, signs, strict=True)], enough)
        if bound is None:
            return None
        total += bound
    return total


def _rational(number: Any) -> fmpq:
    return fmpq(number.numerator, number.denominator)


def _of_side(rows: Sequence[EvaluatedConstraint], enough: int) -> int | None:
    linear = equations(rows).equations
    if any(equation.squares for equation in linear):
        return None
    functions = _free_coordinates([equation.linear for equation in linear])
    if functions is None:
        return 0
    if len(functions[0]) - 1 > _VARIABLES:
        return None
    quadrics = _in_free_coordinates(functions)
    for degree in _DEGREES:
        bound = _Products(quadrics, len(functions[0]) - 1, degree).bound(enough)
        if bound is not None:
            return bound
    return None


def _free_coordinates(linear: Sequence[dict[int, Any]]) -> list[list[fmpq]] | None:
    """Return the functions as combinations of 1 and free ones; None if no motion has them all."""
    count = len(_FUNCTIONS)
    # The last functions come first in the elimination; 1 is the last.
    order = [*range(count - 1, 0, -1), 0]
    column = {_FUNCTIONS[k]: place for place, k in enumerate(order)}
    matrix = fmpq_mat(len(linear), count)
    for r, equation in enumerate(linear):
        for function, coefficient in equation.items():
            matrix[r, column[function]] += coefficient
    echelon, rank = matrix.rref()
    pivots = _pivots(echelon, rank)
    if count - 1 in pivots:
        return None
    free = [k for k in range(count - 1) if k not in pivots]
    found = [[fmpq(0)] * (1 + len(free)) for _ in range(count)]
    found[0][0] = fmpq(1)
    for place, k in enumerate(free):
        found[order[k]][1 + place] = fmpq(1)
    for r, pivot in enumerate(pivots):
        found[order[pivot]] = [-echelon[r, k] for k in (count - 1, *free)]
    return found


@cache
def _relations() -> list[dict[tuple[int, int], int]]:
    """Return the quadrics that vanish on the motions: coefficients of products of `_FUNCTIONS`."""
    forms = motion_forms()
    quadratic = list(combinations_with_replacement(range(8), 2))
    monomials = combinations_with_replacement(range(8), 4)
    places: dict[Monomial, int] = {m: k for k, m in enumerate(monomials)}
    pairs = list(combinations_with_replacement(range(len(_FUNCTIONS)), 2))
    each = [
        {(i, j): int(forms[k][i][j]) * (1 + (i != j)) for i, j in quadratic} for k in _FUNCTIONS
    ]
    study_quadric = {(i, i + 4): 1 for i in range(4)}
    factors = [(each[i], each[j]) for i, j in pairs]
    # Multiples of e.f vanish, too.
    factors += [(study_quadric, {square: 1}) for square in quadratic]
    matrix = fmpz_mat(len(places), len(factors))
    for c, (one, other) in enumerate(factors):
        for (x, a), (y, b) in product(one.items(), other.items()):
            if a and b:
                matrix[places[tuple(sorted(x + y))], c] += a * b
    kernel, nullity = matrix.nullspace()
    relations = [
        {pair: int(kernel[r, c]) for r, pair in enumerate(pairs) if kernel[r, c]}
        for c in range(nullity)
    ]
    return [relation for relation in relations if relation]


def _in_free_coordinates(functions: Sequence[Sequence[fmpq]]) -> list[Quadric]:
    """Return the quadrics that vanish on the motions with integer coefficients."""
    found = []
    for relation in _relations():
        quadric: dict[Monomial, fmpq] = {}
        for (i, j), c in relation.items():
            for (a, x), (b, y) in product(enumerate(functions[i]), enumerate(functions[j])):
                if x and y:
                    monomial = tuple(sorted(k for k in (a, b) if k))
                    quadric[monomial] = quadric.get(monomial, fmpq(0)) + c * x * y
        scale = _denominator(quadric.values())
        whole = {monomial: int((x * scale).p) for monomial, x in quadric.items() if x}
        if whole:
            found.append(whole)
    return found


def _denominator(numbers: Any) -> fmpz:
    common = fmpz(1)
    for number in numbers:
        common = common * number.q // common.gcd(number.q)
    return common


@dataclass(frozen=True)
class _Functionals:
    """Functionals on forms: at each pivot fractions, one for each free column, where it is one."""

    pivots: list[int]
    free: list[int]
    fractions: list[list[fmpq]]


class _Products:
    """The products of monomials and quadrics up to a degree, as sparse rows of integers."""

    def __init__(self, quadrics: Sequence[Quadric], variables: int, degree: int) -> None:
        self.quadrics, self.variables = quadrics, variables

        def monomials(d: int) -> list[Monomial]:
            return list(combinations_with_replacement(range(1, variables + 1), d))

        # The terms of the highest degree come first.
        columns = [m for d in range(degree, -1, -1) for m in monomials(d)]
        self.places = {m: k for k, m in enumerate(columns)}
        self.columns = columns
        self.top = len(monomials(degree))
        multipliers = [m for d in range(degree - 2, -1, -1) for m in monomials(d)]
        self.rows = [
            [(self.places[tuple(sorted(m + x))], k, x) for x in quadric]
            for m in multipliers
            for k, quadric in enumerate(quadrics)
        ]
        #: This many rows, the first, have terms of the highest degree.
        self.highest = len(monomials(degree - 2)) * len(quadrics)

    def bound(self, enough: int) -> int | None:
        """Return a bound of the dimension of P/I; None if this degree proves none."""
        width = len(self.columns)
        echelon, rank = self._modulo(_PRIME, range(len(self.rows)), width).rref()
        pivots = _pivots(echelon, rank)
        leading = sum(pivot < self.top for pivot in pivots)
        if leading < self.top and not self._has_functionals(self.top - leading):
            return None
        while True:
            kept = [[int(echelon[r, c]) for c in range(width)] for r in range(rank)]
            products = [
                self._times(row, k) for row in kept[leading:] for k in range(self.variables)
            ]
            matrix = nmod_mat(rank + len(products), width, list(chain(*kept, *products)), _PRIME)
            echelon, larger = matrix.rref()
            leading = sum(pivot < self.top for pivot in _pivots(echelon, larger))
            if leading < self.top:
                return None
            if larger == rank or width - larger <= enough:
                return width - larger
            rank = larger

    def _times(self, row: Sequence[int], variable: int) -> list[int]:
        """Return a row without terms of the highest degree, times a variable."""
        found = [0] * len(row)
        for place in range(self.top, len(row)):
            if row[place]:
                monomial = tuple(sorted((*self.columns[place], variable + 1)))
                found[self.places[monomial]] = row[place]
        return found

    def _modulo(self, prime: int, rows: Sequence[int], width: int) -> nmod_mat:
        values = [{x: c % prime for x, c in quadric.items()} for quadric in self.quadrics]
        entries = [0] * (len(rows) * width)
        for r, row in enumerate(rows):
            for column, k, x in self.rows[row]:
                if column < width:
                    entries[r * width + column] += values[k][x]
        return nmod_mat(len(rows), width, entries, prime)

    def _has_functionals(self, number: int) -> bool:
        """Whether this many independent rational functionals vanish on the highest terms."""
        found = self._functionals(number)
        return found is not None and self._vanish(found)

    def _functionals(self, number: int) -> _Functionals | None:
        """Return functionals found modulo several primes, not verified."""
        rows: Sequence[int] = range(self.highest)
        pivots: list[int] = []
        residues: list[int] = []
        modulus, prime = 1, _PRIME
        for _ in range(_MOST_PRIMES):
            prime = _next_prime(prime)
            matrix = self._modulo(prime, rows, self.top)
            echelon, rank = matrix.rref()
            leads = _pivots(echelon, rank)
            if self.top - rank != number or (pivots and leads != pivots):
                return None
            pivots = leads
            free = [c for c in range(self.top) if c not in set(pivots)]
            new = [-int(echelon[r, c]) % prime for c in free for r in range(rank)]
            if modulus == 1:
                residues = new
                # The same independent rows serve for all primes.
                transposed, _ = matrix.transpose().rref()
                rows = _pivots(transposed, rank)
            else:
                inverse = pow(modulus, -1, prime)
                residues = [
                    one + modulus * ((other - one) * inverse % prime)
                    for one, other in zip(residues, new, strict=True)
                ]
            modulus *= prime
            fractions = _fractions(residues, modulus)
            if fractions is not None:
                parts = [fractions[k * rank : (k + 1) * rank] for k in range(number)]
                return _Functionals(pivots, free, parts)
        return None

    def _vanish(self, found: _Functionals) -> bool:
        """Whether functionals vanish on the highest terms of all products, exactly."""
        for place, numbers in zip(found.free, found.fractions, strict=True):
            scale = _denominator(numbers)
            values = [fmpz(0)] * self.top
            values[place] = scale
            for pivot, number in zip(found.pivots, numbers, strict=True):
                values[pivot] = (number * scale).p
            for row in self.rows[: self.highest]:
                terms = ((c, self.quadrics[k][x]) for c, k, x in row if c < self.top)
                if sum((values[c] * number for c, number in terms), fmpz(0)) != 0:
                    return False
        return True


def _pivots(echelon: Any, rank: int) -> list[int]:
    """Return the columns where the rows of an echelon form lead."""
    found, column = [], 0
    for row in range(rank):
        while not echelon[row, column]:
            column += 1
        found.append(column)
    return found


def _next_prime(prime: int) -> int:
    """Return the largest prime below an odd one."""
    prime -= 2
    while not fmpz(prime).is_prime():
        prime -= 2
    return prime


def _fractions(residues: Sequence[int], modulus: int) -> list[fmpq] | None:
    """Return the fractions with these residues, if all are much smaller than the modulus."""
    limit, most = isqrt(modulus // 2), modulus.bit_length() - _SPARE_BITS
    found = []
    for residue in residues:
        r0, r1, t0, t1 = modulus, residue, 0, 1
        while r1 > limit:
            quotient = r0 // r1
            r0, r1, t0, t1 = r1, r0 - quotient * r1, t1, t0 - quotient * t1
        if not t1 or r1.bit_length() + abs(t1).bit_length() > most:
            return None
        found.append(fmpq(r1, t1))
    return found
