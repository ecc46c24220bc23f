"""The constraints of an instance as polynomials in the entries of the motion, for msolve.

The coordinates are R (by rows), T, U = R^T T, rho = T.T, and for each DLL its mutual moment. The
equations of a rotation and those of U and rho define the rigid motions among them. DPP, DPH, DHP
and angles are linear. Nothing is shared with the equations in quaternions of `quaternion_counts`,
nor with those of the package, so that the ways of counting are independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain
from typing import Any

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.geometry.instance import Constraint, Instance, Side
from tools.oracle.homomorphisms import Homomorphism
from tools.oracle.number_parts import direction
from tools.oracle.rational_numbers import Rationals

Monomial = tuple[str, ...]
#: Coefficients are residues, or fractions where the characteristic is zero.
Polynomial = dict[Monomial, Any]

ROTATION = [[f"r{i}{j}" for j in range(3)] for i in range(3)]
TRANSLATION, BODY, RHO = ["t0", "t1", "t2"], ["u0", "u1", "u2"], "w"


class Ring:
    """Polynomials with coefficients modulo a prime, or rational ones for the prime 0."""

    def __init__(self, prime: int) -> None:
        self.prime = prime

    def reduced(self, polynomial: Polynomial) -> Polynomial:
        """Return a polynomial with reduced coefficients and without zeros."""
        if self.prime:
            polynomial = {m: value % self.prime for m, value in polynomial.items()}
        return {monomial: value for monomial, value in polynomial.items() if value}

    def inverse(self, value: Any) -> Any:
        """Return the inverse of a coefficient."""
        return pow(value, -1, self.prime) if self.prime else Fraction(1, value)

    def sum(self, *polynomials: Polynomial) -> Polynomial:
        """Return a sum."""
        total: Polynomial = {}
        for polynomial in polynomials:
            for monomial, value in polynomial.items():
                total[monomial] = total.get(monomial, 0) + value
        return self.reduced(total)

    def product(self, first: Polynomial, second: Polynomial) -> Polynomial:
        """Return a product."""
        total: Polynomial = {}
        for m, a in first.items():
            for n, b in second.items():
                key = tuple(sorted(m + n))
                total[key] = total.get(key, 0) + a * b
        return self.reduced(total)

    def times(self, factor: Any, polynomial: Polynomial) -> Polynomial:
        """Return a multiple."""
        return self.sum({m: factor * a for m, a in polynomial.items()})

    def dot(self, first: Sequence[Polynomial], second: Sequence[Polynomial]) -> Polynomial:
        """Return a scalar product."""
        return self.sum(*(self.product(a, b) for a, b in zip(first, second, strict=True)))

    def square(self, vector: Sequence[Polynomial]) -> Polynomial:
        """Return the scalar product of a vector with itself."""
        return self.dot(vector, vector)

    def cross(self, a: Sequence[Polynomial], b: Sequence[Polynomial]) -> list[Polynomial]:
        """Return a vector product."""
        return [
            self.sum(self.product(a[i], b[j]), self.times(-1, self.product(a[j], b[i])))
            for i, j in ((1, 2), (2, 0), (0, 1))
        ]

    def less(self, first: Sequence[Polynomial], second: Sequence[Polynomial]) -> list[Polynomial]:
        """Return a difference of vectors."""
        return [self.sum(a, self.times(-1, b)) for a, b in zip(first, second, strict=True)]


def variable(name: str) -> Polynomial:
    """Return a variable."""
    return {(name,): 1}


def constant(value: Any) -> Polynomial:
    """Return a constant."""
    return {(): value} if value else {}


R = [[variable(name) for name in row] for row in ROTATION]
COLUMNS = [list(column) for column in zip(*R, strict=True)]
T, U = [variable(name) for name in TRANSLATION], [variable(name) for name in BODY]


@dataclass(frozen=True)
class Ideal:
    """Polynomials in named variables modulo a prime, or rational ones for the prime 0."""

    names: list[str]
    polynomials: list[Polynomial]
    prime: int


def motions(ring: Ring) -> list[Polynomial]:
    """Return the equations of the rigid motions."""
    result = []
    for i in range(3):
        for j in range(i, 3):
            one = constant(-1 if i == j else 0)
            result += [ring.sum(ring.dot(rows[i], rows[j]), one) for rows in (R, COLUMNS)]
    for i in range(3):
        # The rows of a rotation are a right-handed system.
        result += ring.less(ring.cross(R[i], R[(i + 1) % 3]), R[(i + 2) % 3])
        result += ring.less([ring.dot(R[i], U), ring.dot(COLUMNS[i], T)], [T[i], U[i]])
    rho = variable(RHO)
    return result + ring.less([ring.square(T), ring.square(U)], [rho, rho])


def equations(instance: Instance, field: Homomorphism | Rationals) -> Ideal:
    """Return the ideal of the poses of an instance.

    A DLL is the equation of Section 4, which holds at any distance where its lines are parallel;
    for the distance zero the one of which that is the square.
    """
    ring = Ring(field.prime)
    return _of_poses(instance, field, ring, motions(ring))


def square_system(instance: Instance, field: Homomorphism | Rationals) -> Ideal:
    """Return as many equations as unknowns: those of `equations` without the needless ones.

    All are quadratic. Reflections of the platform are solutions, too. U, rho and mutual moments
    each have an equation in which they are linear, before any other in which they occur.
    """
    ring = Ring(field.prime)
    polynomials = ring.less([ring.dot(column, T) for column in COLUMNS], U)
    polynomials.append(ring.sum(ring.square(T), ring.times(-1, variable(RHO))))
    for i in range(3):
        for j in range(i, 3):
            one = constant(-1 if i == j else 0)
            polynomials.append(ring.sum(ring.dot(R[i], R[j]), one))
    return _of_poses(instance, field, ring, polynomials)


def _of_poses(
    instance: Instance, field: Homomorphism | Rationals, ring: Ring, moving: list[Polynomial]
) -> Ideal:
    names = [*chain.from_iterable(ROTATION), *TRANSLATION, *BODY, RHO]
    polynomials = list(moving)
    for number, constraint in enumerate(instance.constraints):
        if constraint.kind is DLL:
            names.append(f"m{number}")
        polynomials += _constraint(constraint, field, ring, variable(f"m{number}"))
    return Ideal(names, polynomials, field.prime)


def _constraint(
    constraint: Constraint, field: Homomorphism | Rationals, ring: Ring, moment: Polynomial
) -> list[Polynomial]:
    kind = constraint.kind
    y = [constant(value) for value in field.vector(constraint.platform.position)]
    x = [constant(value) for value in field.vector(constraint.base.position)]
    u = [constant(value) for value in field.vector(direction(constraint.platform))]
    v = [constant(value) for value in field.vector(direction(constraint.base))]
    turned = [ring.dot(row, u) for row in R]
    if not kind.is_distance:
        return [ring.sum(ring.dot(turned, v), constant(-field.scalar_product(constraint)))]
    if kind is DPP:
        placed = [ring.dot(row, y) for row in R]
        linear = ring.sum(ring.dot(y, U), ring.times(-1, ring.dot(x, [*map(ring.sum, T, placed)])))
        known = ring.sum(ring.square(y), ring.square(x))
        squared = constant(-field.square(constraint.value))
        return [ring.sum(variable(RHO), ring.times(2, linear), known, squared)]
    # From the base's primitive to the platform's point, in the frame of the base, or the reverse.
    from_base = ring.less([ring.sum(ring.dot(row, y), t) for row, t in zip(R, T, strict=True)], x)
    from_platform = ring.less([ring.dot(column, x) for column in COLUMNS], [*map(ring.sum, U, y)])
    if kind in (DPH, DHP):
        normal, offset = (v, from_base) if kind is DPH else (u, from_platform)
        height = ring.dot(normal, offset)
        if constraint.value.fraction == 0:
            # There are no two sides; the square would count each pose twice.
            return [height]
        if constraint.side is not Side.BOTH:
            plane = constraint.base if kind is DPH else constraint.platform
            signed = field.number(constraint.value) * field.norm(direction(plane))
            signed = signed if constraint.side is Side.POSITIVE else -signed
            return [ring.sum(height, constant(-signed))]
        squared = ring.times(field.square(constraint.value), ring.square(normal))
        return [ring.sum(ring.square([height]), ring.times(-1, squared))]
    if kind in (DPL, DLP):
        along, offset = (v, from_base) if kind is DPL else (u, from_platform)
        squared = ring.times(field.square(constraint.value), ring.square(along))
        return [ring.sum(ring.square(ring.cross(offset, along)), ring.times(-1, squared))]
    if constraint.value.fraction == 0:
        # The square of this is zero, too, but counts each pose twice.
        return [moment, ring.dot(from_base, ring.cross(turned, v))]
    common = ring.dot(turned, v)
    # (R y + T - x) . (R u x v), of which T . (R u x v) is bilinear.
    triple = ring.dot(from_base, ring.cross(turned, v))
    spread = ring.sum(
        ring.product(ring.square(u), ring.square(v)), ring.times(-1, ring.square([common]))
    )
    squared = ring.times(field.square(constraint.value), spread)
    return [
        ring.sum(moment, ring.times(-1, triple)),
        ring.sum(ring.square([moment]), ring.times(-1, squared)),
    ]


def parallel(
    constraint: Constraint, field: Homomorphism | Rationals, ring: Ring
) -> list[Polynomial]:
    """Return polynomials that vanish if the two lines of a DLL are parallel."""
    u = [constant(value) for value in field.vector(direction(constraint.platform))]
    v = [constant(value) for value in field.vector(direction(constraint.base))]
    return ring.cross([ring.dot(row, u) for row in R], v)


def without_linear(ideal: Ideal) -> Ideal:
    """Return the ideal in fewer variables: each linear equation is solved for one variable."""
    ring = Ring(ideal.prime)
    linear = [p for p in ideal.polynomials if all(len(m) <= 1 for m in p)]
    rest = [p for p in ideal.polynomials if any(len(m) > 1 for m in p)]
    known: dict[str, Polynomial] = {}
    for polynomial in linear:
        reduced = _substituted(polynomial, known, ring)
        pivot = next((n for n in reversed(ideal.names) if (n,) in reduced), None)
        if pivot is None:
            rest += [reduced] if reduced else []
            continue
        inverse = ring.inverse(-reduced.pop((pivot,)))
        solved = {pivot: ring.times(inverse, reduced)}
        known = {name: _substituted(p, solved, ring) for name, p in known.items()} | solved
    names = [name for name in ideal.names if name not in known]
    reduced_rest = (_substituted(polynomial, known, ring) for polynomial in rest)
    return Ideal(names, [p for p in reduced_rest if p], ideal.prime)


def _substituted(polynomial: Polynomial, known: dict[str, Polynomial], ring: Ring) -> Polynomial:
    terms: list[Polynomial] = []
    for monomial, value in polynomial.items():
        term: Polynomial = {(): value}
        for name in monomial:
            term = ring.product(term, known.get(name, variable(name)))
        terms.append(term)
    return ring.sum(*terms)
