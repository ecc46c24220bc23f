"""The reduction of three surfaces to a triangular set (paper, proof of Proposition 6.7).

Every function takes the surfaces as polynomials in ``x, y, z``. It returns ``h1(x)``, ``h2(x, y)``
and ``h3(x, y, z)`` with the conditions under which they describe all common points. The elements h2
and h3 are linear in their leading variables. The element h1 is the resultant of the surfaces with
respect to y and z; extraneous factors are stated.
"""

from __future__ import annotations

from collections.abc import Sequence

from gspcli.records import dataclass
from gspcli.symbolic.sparse_polynomials import Polynomial, coefficient, coefficients
from gspcli.symbolic.triangular import Elimination, NonVanishing, Relation

_AT_INFINITY = "a solution has gone to infinity, or the surfaces meet in a curve"
_SAME_X = "two solutions have the same x, or the surfaces meet in a curve"


@dataclass(frozen=True)
class Reduction:
    """The elements h1, h2, h3, when they hold, and the steps that lead to them."""

    elements: tuple[Polynomial, Polynomial, Polynomial]
    conditions: tuple[NonVanishing, ...]
    steps: tuple[Relation, ...] = ()


def determinant(rows: Sequence[Sequence[Polynomial]]) -> Polynomial:
    """Return a determinant, by expansion along the first row."""
    if len(rows) == 1:
        return rows[0][0]
    return sum(
        (
            (-1) ** j * entry * determinant([[*row[:j], *row[j + 1 :]] for row in rows[1:]])
            for j, entry in enumerate(rows[0])
            if entry
        ),
        start=rows[0][0] * 0,
    )


def cramer(
    polynomials: Sequence[Polynomial], variables: Sequence[str], keys: Sequence[tuple[int, ...]]
) -> tuple[Polynomial, list[Polynomial]]:
    """Solve for some monomials that occur linearly.

    Parameters
    ----------
    polynomials
        As many as there are monomials to solve for.
    variables
        The unknowns of those monomials.
    keys
        The exponents of each monomial in those unknowns.

    Returns
    -------
    tuple
        ``(D, rests)`` with ``D · monomial_i + rests_i = 0`` for each i.
    """
    split = [coefficients(polynomial, variables) for polynomial in polynomials]
    zero = polynomials[0].ring.zero
    matrix = [[part.get(key, zero) for key in keys] for part in split]
    gens = dict(zip(map(str, zero.ring.symbols), zero.ring.gens, strict=True))
    constants = []
    for polynomial, row in zip(polynomials, matrix, strict=True):
        rest = polynomial
        for entry, key in zip(row, keys, strict=True):
            term = entry
            for name, exponent in zip(variables, key, strict=True):
                term *= gens[name] ** exponent
            rest -= term
        constants.append(rest)
    rests = []
    for column in range(len(keys)):
        replaced = [
            [*row[:column], constant, *row[column + 1 :]]
            for row, constant in zip(matrix, constants, strict=True)
        ]
        rests.append(determinant(replaced))
    return determinant(matrix), rests


def three_planes(ring: Elimination, surfaces: Sequence[Polynomial]) -> Reduction:
    """Reduce PPP by Cramer's rule: the determinant is the initial of all three elements."""
    value, rests = cramer(surfaces, ("x", "y", "z"), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    slope = ring.define(value)
    h1, h2, h3 = (
        slope * unknown + ring.named(rest)
        for unknown, rest in zip(ring["x y z"], rests, strict=True)
    )
    meaning = "the normals of the planes are linearly dependent"
    return Reduction((h1, h2, h3), (NonVanishing(slope, meaning, ("h1", "h2", "h3")),))


def line_and_quadric(ring: Elimination, surfaces: Sequence[Polynomial]) -> Reduction:
    """Reduce two planes and any surface of degree two (PPC, PPS)."""
    first, second, quadric = surfaces
    value, rests = cramer([first, second], ("y", "z"), ((1, 0), (0, 1)))
    slope = ring.define(value)
    y, z = ring["y z"]
    at_y, at_z = map(ring.named, rests)
    h1 = sum(
        (
            part * (-at_y) ** i * (-at_z) ** j * slope ** (2 - i - j)
            for (i, j), part in coefficients(quadric, ("y", "z")).items()
        ),
        start=ring.ring.zero,
    )
    h1 = ring.named(h1)
    return Reduction(
        (h1, slope * y + at_y, slope * z + at_z),
        (
            NonVanishing(slope, "the planes are parallel, or x is constant on their line", _LINEAR),
            NonVanishing(coefficient(h1, "x", 2), _AT_INFINITY, ("h1",)),
        ),
    )


_LINEAR = ("h2", "h3")


def plane_and_two_spheres(ring: Elimination, surfaces: Sequence[Polynomial]) -> Reduction:
    """Reduce PSS: the spheres differ by a plane."""
    plane, one, other = surfaces
    radical = ring.named(one - other, "k")
    reduction = line_and_quadric(ring, [plane, radical, other])
    return _after(reduction, Relation("S1 − S2", radical))


def three_spheres(ring: Elimination, surfaces: Sequence[Polynomial]) -> Reduction:
    """Reduce SSS: the spheres differ by two planes."""
    one, two, three = surfaces
    radicals = [ring.named(one - three, "k"), ring.named(two - three, "k")]
    reduction = line_and_quadric(ring, [*radicals, three])
    return _after(reduction, *map(Relation, ("S1 − S3", "S2 − S3"), radicals))


def two_spheres(ring: Elimination, surfaces: Sequence[Polynomial]) -> Reduction:
    """Reduce SSC: the spheres differ by a plane."""
    one, other, quadric = surfaces
    radical = ring.named(one - other, "k")
    reduction = two_conics(ring, [radical, other, quadric])
    return _after(reduction, Relation("S1 − S2", radical))


def _after(reduction: Reduction, *steps: Relation) -> Reduction:
    return Reduction(reduction.elements, reduction.conditions, (*steps, *reduction.steps))


def two_conics(ring: Elimination, surfaces: Sequence[Polynomial]) -> Reduction:
    """Reduce a plane and two surfaces of degree two (PSC, PCC): equation (16).

    Putting z from the plane into the others gives two conics ``a y² + b y + c``. With the minors
    [ab], [ac], [bc] of their coefficients, ``[ab] y + [ac]`` is linear in y and
    ``[ac]² − [ab][bc]`` is the resultant. The minors are divisible by the plane's coefficient of
    z, and the resultant of the quotients by its square; these factors are taken out.
    """
    plane, *quadrics = surfaces
    depth, rest = coefficient(plane, "z", 1), coefficient(plane, "z", 0)
    conics = []
    for quadric in quadrics:
        terms = (coefficient(quadric, "z", k) * (-rest) ** k * depth ** (2 - k) for k in range(3))
        conics.append(ring.named(sum(terms, start=ring.ring.zero), "k"))
    a, b, c = ([coefficient(conic, "y", degree) for conic in conics] for degree in (2, 1, 0))
    (y,) = ring["y"]
    h2 = ring.named(_minor(a, b) * y + _minor(a, c), divisor=depth)
    ab, ac = coefficient(h2, "y", 1), coefficient(h2, "y", 0)
    bc = ring.named(_minor(b, c), "k", divisor=depth)
    h1 = ring.named(ac**2 - ab * bc, divisor=depth**2)
    return Reduction(
        (h1, h2, plane),
        (
            NonVanishing(depth, "the plane is parallel to the z axis", ("h3",)),
            NonVanishing(ab, _SAME_X, ("h2",)),
            NonVanishing(coefficient(h1, "x", 4), _AT_INFINITY, ("h1",)),
        ),
        (*map(Relation, ("conic 1", "conic 2"), conics), Relation("[bc]", bc)),
    )


def _minor(p: Sequence[Polynomial], q: Sequence[Polynomial]) -> Polynomial:
    return p[0] * q[1] - p[1] * q[0]


def three_quadrics(ring: Elimination, surfaces: Sequence[Polynomial]) -> Reduction:
    """Reduce any three surfaces of degree two (CCC, SCC).

    The surfaces are solved for y², yz and z². Then ``y·(yz) = z·(y²)`` and ``z·(yz) = y·(z²)``
    become two relations linear in y and z, which give h2 and h3, and z times the first is a
    third one; h1 is the determinant of the three. It has degree eight, so it is the
    resultant up to a factor without x, a power of the first determinant.
    """
    y, z = ring["y z"]
    value, rests = cramer(surfaces, ("y", "z"), _QUADRATIC)
    divisor = ring.define(value, "k")
    yy, yz, zz = (ring.named(rest, "k") for rest in rests)

    def reduced(polynomial: Polynomial) -> Polynomial:
        parts = coefficients(polynomial, ("y", "z"))
        rest = polynomial
        total = ring.ring.zero
        for key, monomial, rule in zip(_QUADRATIC, (y**2, y * z, z**2), (yy, yz, zz), strict=True):
            part = parts.get(key, ring.ring.zero)
            rest -= part * monomial
            total -= part * rule
        return total + divisor * rest

    first = ring.named(reduced(y * yz - z * yy), "k")
    second = ring.named(reduced(z * yz - y * zz), "k")
    third = ring.named(reduced(z * first), "k")
    slope_value, linear_rests = cramer([first, second], ("y", "z"), ((1, 0), (0, 1)))
    slope = ring.named(slope_value)
    at_y, at_z = map(ring.named, linear_rests)
    forms = [coefficients(form, ("y", "z")) for form in (first, second, third)]
    h1 = ring.named(determinant([[form[key] for key in _LINEAR_FORM] for form in forms]))
    solved = (
        Relation(name, divisor * monomial + rule)
        for name, monomial, rule in (("y²", y**2, yy), ("yz", y * z, yz), ("z²", z**2, zz))
    )
    return Reduction(
        (h1, slope * y + at_y, slope * z + at_z),
        (
            NonVanishing(divisor, "the parts of the surfaces in y², yz, z² are linearly dependent"),
            NonVanishing(slope, _SAME_X, _LINEAR),
            NonVanishing(coefficient(h1, "x", 8), _AT_INFINITY, ("h1",)),
        ),
        (
            *solved,
            *map(Relation, ("y·(yz) − z·(y²)", "z·(yz) − y·(z²)"), (first, second)),
            Relation("z·(y·(yz) − z·(y²))", third),
        ),
    )


_QUADRATIC = ((2, 0), (1, 1), (0, 2))
_LINEAR_FORM = ((1, 0), (0, 1), (0, 0))
