"""The cases of Section 6 for which `gsp derive` has a triangular set."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import NamedTuple

from gspcli.errors import GspError
from gspcli.records import dataclass
from gspcli.symbolic.triangular import (
    Elimination,
    NonVanishing,
    Polynomial,
    Relation,
    TriangularPolynomial,
    TriangularSet,
    coefficient,
    coefficients,
)
from gspcli.wording import shown

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


#: The order of the unknowns in equations (12) and (13), ascending.
ORDER = ("r32", "r31", "r23", "r22", "r21", "r13", "r12", "r11", "r33")
PARAMETERS = ("d1", "d2", "d3", "l1", "m1", "n1", "l3", "m3", "n3", "m0", "n0", "m2", "n2")

_SYMBOLS = {
    "q": ("q1", "q2", "q3", "d4", "d5"),
    "k": tuple(f"k{i}" for i in range(1, 6)),
    "z": tuple(f"z{i}" for i in range(10, 39) if i != 29),
}
_NOTES = (
    "z30 = m2⁴ |s2 × s3|⁴ (l3² + m3²)².",
    "The paper's h2 has degree 3 in r32 without r31; the elimination gives degree 4, and "
    "no h2 of the printed shape exists (docs/types.md).",
    "The paper's h5 and h6 have the initial r31·r13; the relations chosen here ask for "
    "r31 ≠ 0 only.",
)


def derive_angles() -> TriangularSet:
    """Derive the triangular set (12) for three angles in general position."""
    ring = Elimination(ORDER, PARAMETERS, _SYMBOLS)
    r32, r31, r23, r22, r21, r13, r12, r11, r33 = ring[" ".join(ORDER)]
    d1, d2, d3, l1, m1, n1, l3, m3, n3, m0, n0, m2, n2 = ring[" ".join(PARAMETERS)]
    rotation = ((r11, r12, r13), (r21, r22, r23), (r31, r32, r33))
    system = (
        *(Relation(*item) for item in orthogonality(rotation)),
        Relation("angle 1", r33 - d1),
        Relation("angle 2", _bilinear((0, m0, n0), rotation, (0, m2, n2)) - d2),
        Relation("angle 3", _bilinear((l1, m1, n1), rotation, (l3, m3, n3)) - d3),
    )
    q1, q2, q3 = (ring.define(value, "q") for value in (m0 * m2, m0 * n2, n0 * m2))
    d4, d5 = (ring.define(value, "q") for value in (d1 * n0 * n2 - d2, d1 * n1 * n3 - d3))
    h4 = q1 * r22 + q2 * r23 + q3 * r32 + d4
    first = _first_polynomials(ring, (q1, q2, q3, d4, d5))
    elements = (
        first.h1,
        first.h2,
        first.h3,
        h4,
        r31 * r21 + r32 * r22 + d1 * r23,
        r13 - r32 * r21 + r31 * r22,
        r12 + d1 * r21 - r31 * r23,
        r11 + r32 * r23 - d1 * r22,
        r33 - d1,
    )
    return TriangularSet(
        case="AAA",
        title="three angles in general position",
        source="equations (11) and (12)",
        variables=ORDER,
        parameters=PARAMETERS,
        system=system,
        definitions=tuple(ring.definitions),
        elements=tuple(
            TriangularPolynomial(f"h{i + 1}", name, element)
            for i, (name, element) in enumerate(zip(ORDER, elements, strict=True))
        ),
        conditions=(
            NonVanishing(1 - d1**2, "the first two directions are parallel: d1 = ±1"),
            NonVanishing(
                coefficient(first.h1, "r32", 8),
                "s2 and s3, s4 and s5, or s4 and s6 are parallel (if all is real)",
                ("h1",),
            ),
            NonVanishing(first.initial_2, "two solutions have the same r32", ("h2",)),
            NonVanishing(first.initial_3, "two solutions have the same r31 and r32", ("h3",)),
            NonVanishing(q1, "s1 and s2, or s4 and s5, are parallel", ("h4",)),
            NonVanishing(r31, "a solution has r31 = 0, where h5 does not give r21", ("h5",)),
        ),
        steps=(
            Relation("r13", first.for_r13),
            Relation("r31² + r32² = 1 − d1²", r31**2 + r32**2 - (1 - d1**2)),
        ),
        notes=_NOTES,
    )


class _FirstPolynomials(NamedTuple):
    """The first three polynomials of the set, with the initials of two, and what gives r13."""

    h1: Polynomial
    h2: Polynomial
    h3: Polynomial
    initial_2: Polynomial
    initial_3: Polynomial
    for_r13: Polynomial


def _first_polynomials(ring: Elimination, mixed: Sequence[Polynomial]) -> _FirstPolynomials:
    """Eliminate all entries but r32, r31 and r23, with the values q1, q2, q3, d4, d5."""
    r32, r31, r23, r13 = ring["r32 r31 r23 r13"]
    d1, l1, m1, n1, l3, m3, n3 = ring["d1 l1 m1 n1 l3 m3 n3"]
    q1, q2, q3, d4, d5 = mixed

    # With r33 = d1, the other entries times 1 − d1² are bilinear in the rest of the third row
    # and of the third column, because R is its own matrix of cofactors.
    square = 1 - d1**2
    corner = (
        (-d1 * r31 * r13 - r32 * r23, r31 * r23 - d1 * r32 * r13, square * r13),
        (r32 * r13 - d1 * r31 * r23, -d1 * r32 * r23 - r31 * r13, square * r23),
        (square * r31, square * r32, ring.ring.zero),
    )
    second = q1 * corner[1][1] + q2 * corner[1][2] + q3 * corner[2][1] + square * d4
    third = _bilinear((l1, m1, n1), corner, (l3, m3, n3)) + square * d5
    slope, (at_r23, at_r13) = cramer([second, third], ("r23", "r13"), ((1, 0), (0, 1)))
    row = square - r32**2  # the square of r31
    slope, at_r23, at_r13 = (
        _modulo(form, r31, row).exquo(square) for form in (slope, at_r23, at_r13)
    )
    h3 = ring.named(slope * r23 + at_r23)
    slope, at_r23 = coefficient(h3, "r23", 1), coefficient(h3, "r23", 0)
    at_r13 = ring.named(at_r13, "k")
    # r23² + r13² = 1 − d1² after multiplication by slope².
    h2 = _modulo(at_r23**2 + at_r13**2 - square * slope**2, r31, row)
    h2 = ring.named(h2, divisor=square)
    times, plus = coefficient(h2, "r31", 1), coefficient(h2, "r31", 0)
    h1 = ring.named(plus**2 - row * times**2)
    return _FirstPolynomials(h1, h2, h3, times, slope, slope * r13 + at_r13)


def derive_example_6_2() -> TriangularSet:
    """Derive the triangular set (13) of Example 6.2: three pairs of perpendicular directions."""
    names = ("r32", "r31", "r23", "r21", "r13", "r12")
    ring = Elimination(names, ("d1", "d2", "d3"), {})
    r32, r31, r23, r21, r13, r12 = ring[" ".join(names)]
    d1, d2, d3 = ring["d1 d2 d3"]
    rotation = ((d3, r12, r13), (r21, d2, r23), (r31, r32, d1))
    system = tuple(Relation(*item) for item in orthogonality(rotation))
    # Cofactors: r11 = r22 r33 − r23 r32 and r22 = r11 r33 − r13 r31.
    product_23, product_13 = d1 * d2 - d3, d1 * d3 - d2
    square = 1 - d1**2
    # (r31 r13)² = (1 − d1² − r32²)(1 − d1² − r23²), times r32².
    h1 = (square - r32**2) * (square * r32**2 - product_23**2) - (product_13 * r32) ** 2
    elements = (
        -h1.exquo(square),
        r31**2 + r32**2 - square,
        r32 * r23 - product_23,
        r31 * r21 + d2 * r32 + d1 * r23,
        r31 * r13 - product_13,
        r12 + d1 * r21 - r31 * r23,
    )
    return TriangularSet(
        case="6.2",
        title="three angles between perpendicular triples",
        source="Example 6.2, equation (13)",
        variables=names,
        parameters=("d1", "d2", "d3"),
        system=system,
        definitions=(),
        elements=tuple(
            TriangularPolynomial(f"h{i + 1}", name, element)
            for i, (name, element) in enumerate(zip(names, elements, strict=True))
        ),
        conditions=(
            NonVanishing(square, "r33 = ±1: the first two directions are parallel"),
            NonVanishing(r32, "h1 has the root 0: d3 = d1·d2", ("h3",)),
            NonVanishing(r31, "h2 has the root 0: d2 = d1·d3", ("h4", "h5")),
        ),
        notes=(
            "r11 = d3, r22 = d2, r33 = d1.",
            "The paper's second, fourth and sixth polynomials have higher initials and vanish on "
            "the same set; here h2 is the norm of the third row.",
        ),
    )


def orthogonality(rotation: Sequence[Sequence[Polynomial]]) -> list[tuple[str, Polynomial]]:
    """Return the equations RᵀR = I and det R = 1 of a matrix."""
    columns = list(zip(*rotation, strict=True))
    equations = [
        (f"column {i + 1} · column {j + 1}", _dot(columns[i], columns[j]) - int(i == j))
        for i in range(3)
        for j in range(i, 3)
    ]
    return [*equations, ("det R", determinant(rotation) - 1)]


def _dot(a: Sequence[Polynomial], b: Sequence[Polynomial]) -> Polynomial:
    total = a[0] * b[0]
    for p, q in zip(a[1:], b[1:], strict=True):
        total = total + p * q
    return total


def _bilinear(
    left: Sequence[Polynomial | int],
    matrix: Sequence[Sequence[Polynomial]],
    right: Sequence[Polynomial | int],
) -> Polynomial:
    return _dot([_dot(row, right) for row in matrix], left)


def _modulo(polynomial: Polynomial, unknown: Polynomial, square: Polynomial) -> Polynomial:
    """Replace the square of an unknown until the unknown occurs linearly at most."""
    return sum(
        (
            part * unknown ** (degree % 2) * square ** (degree // 2)
            for (degree,), part in coefficients(polynomial, [str(unknown)]).items()
        ),
        start=polynomial.ring.zero,
    )


VARIABLES = ("x", "y", "z")

#: The monomials that the coefficients of each surface belong to, as in equation (15).
_FORMS = {
    "P": ("x", "y", "z", ""),
    "S": ("x", "y", "z", ""),
    "C": ("x x", "y y", "z z", "y z", "x z", "z", "x y", "y", "x", ""),
}
_WORDS = {"P": "plane", "S": "sphere", "C": "cylinder"}
_METHODS: dict[str, Callable[[Elimination, Sequence[Polynomial]], Reduction]] = {
    "PPP": three_planes,
    "PPC": line_and_quadric,
    "PPS": line_and_quadric,
    "SSS": three_spheres,
    "PSS": plane_and_two_spheres,
    "PCC": two_conics,
    "SSC": two_spheres,
    "PSC": two_conics,
    "CCC": three_quadrics,
    "SCC": three_quadrics,
}
#: The intersections in the order of Table 3.
INTERSECTIONS = tuple(_METHODS)
_SURFACE_SYMBOLS = {letter: [f"{letter}{i}" for i in range(1, 60)] for letter in "kz"}

_CYLINDER_NOTE = (
    "C is any quadric. For the cylinder of radius r about the line through a along u it is "
    "|u|²|p − a|² − (u·(p − a))² − |u|²r² with p = (x, y, z)."
)
_SURFACE_NOTES = {
    "PCC": ("For cylinders about u and v, z6 has the factor |u × v|²: 0 if they are parallel.",),
    "PSC": (
        "The paper prints the third polynomial of (16) with d1·z in place of d1·x.",
        "For a plane with normal n and a cylinder about u, z6 = |n × u|⁴: 0 if they meet in a "
        "circle, which meets the sphere in two points at infinity.",
    ),
    "SCC": (
        "h1 is k1³ times the resultant. For cylinders about u and v, k1 is "
        "2(u2·v2 + u3·v3)(u2·v3 − u3·v2); where it is 0, turn the axes of coordinates.",
    ),
    "CCC": (
        "h1 is k1³ times the resultant. Where k1 is 0, as in Example 6.8, turn the axes of "
        "coordinates.",
    ),
}


def derive_intersection(case: str) -> TriangularSet:
    """Derive the triangular set of one of the `INTERSECTIONS`."""
    parameters = [f"d{i}" for i in range(1, sum(len(_FORMS[letter]) for letter in case) + 1)]
    ring = Elimination(VARIABLES, parameters, _SURFACE_SYMBOLS)
    letters = iter(ring[" ".join(parameters)])
    surfaces = [_surface(ring, letter, letters) for letter in case]
    reduction = _METHODS[case](ring, surfaces)
    notes = _SURFACE_NOTES.get(case, ())
    return TriangularSet(
        case=case,
        title=_title(case),
        source="Proposition 6.7" + (", equation (16)" if case == "PSC" else ""),
        variables=VARIABLES,
        parameters=tuple(parameters),
        system=tuple(map(Relation, _names(case), surfaces)),
        definitions=tuple(ring.definitions),
        elements=tuple(
            map(TriangularPolynomial, ("h1", "h2", "h3"), VARIABLES, reduction.elements)
        ),
        conditions=reduction.conditions,
        steps=reduction.steps,
        notes=(*notes, _CYLINDER_NOTE) if "C" in case else notes,
    )


def derive_example_6_8() -> TriangularSet:
    """Derive the triangular set (18): the three cylinders (17) are linear in the squares."""
    parameters = ("r1", "r2", "r3")
    ring = Elimination(VARIABLES, parameters, {})
    x, y, z = ring["x y z"]
    r1, r2, r3 = ring["r1 r2 r3"]
    cylinders = (x**2 + y**2 - r1**2, x**2 + z**2 - r2**2, y**2 + z**2 - r3**2)
    value, rests = cramer(cylinders, VARIABLES, ((2, 0, 0), (0, 2, 0), (0, 0, 2)))
    squares = [-(value * unknown**2 + rest) for unknown, rest in zip((x, y, z), rests, strict=True)]
    return TriangularSet(
        case="6.8",
        title="three cylinders about the axes of coordinates",
        source="Example 6.8, equations (17) and (18)",
        variables=VARIABLES,
        parameters=parameters,
        system=tuple(map(Relation, _names("CCC"), cylinders)),
        definitions=(),
        elements=tuple(map(TriangularPolynomial, ("h1", "h2", "h3"), VARIABLES, squares)),
        conditions=(),
        notes=(
            "The paper prints (18), and Table 2, with r2 and r3 exchanged.",
            "The initials are constants: the set always describes all the solutions, with "
            "multiplicity where x, y or z is 0.",
        ),
    )


def _surface(ring: Elimination, letter: str, letters: Iterator[Polynomial]) -> Polynomial:
    x, y, z = ring["x y z"]
    surface = x**2 + y**2 + z**2 if letter == "S" else ring.ring.zero
    for form in _FORMS[letter]:
        term = next(letters)
        for variable in ring[form]:
            term *= variable
        surface += term
    return surface


def _names(case: str) -> list[str]:
    """Return S1, S2, P for SSP: numbered where a letter is not alone."""
    return [
        letter + (str(case[: i + 1].count(letter)) if case.count(letter) > 1 else "")
        for i, letter in enumerate(case)
    ]


def _title(case: str) -> str:
    articles = ("", "a ", "two ", "three ")
    words = [
        f"{articles[case.count(letter)]}{_WORDS[letter]}{'s' if case.count(letter) > 1 else ''}"
        for letter in dict.fromkeys(case)
    ]
    return " and ".join(words) if len(words) < 3 else f"{', '.join(words[:-1])} and {words[-1]}"


_OTHERS: dict[str, Callable[[], TriangularSet]] = {
    "AAA": derive_angles,
    "6.2": derive_example_6_2,
    "6.8": derive_example_6_8,
}
_NEVER_EXPANDED = ("CCC", "SCC")
#: All cases, the intersections first.
CASES = (*INTERSECTIONS, *_OTHERS)


def parse_case(text: str) -> str:
    """Return the case that a word means: letters in any order and case, ``Example 6.2``.

    Raises
    ------
    GspError
        If it is none of `CASES`.
    """
    word = text.strip().upper().removeprefix("EXAMPLE").strip(" -")
    for case in CASES:
        if sorted(word) == sorted(case) and (case not in _OTHERS or word == case):
            return case
    raise GspError(f"{shown(text)} is not a case; the cases are {', '.join(CASES)}")


@cache
def derive(case: str) -> TriangularSet:
    """Derive the triangular set of one of the `CASES`."""
    return _OTHERS[case]() if case in _OTHERS else derive_intersection(case)


def expand_case(case: str) -> TriangularSet:
    """Return the triangular set of a case with the coefficients in the parameters alone.

    Raises
    ------
    GspError
        For CCC and SCC: the coefficient of x⁸ in h1 is k1³ times the resultant of three general
        ternary quadrics, which has 21894 terms, and those of lower powers have more.
    """
    if case in _NEVER_EXPANDED:
        raise GspError(
            f"{case} is not written out in the parameters: for three quadrics the coefficient of "
            "x^8 alone has 21894 terms\nthe hierarchical form, without --expand, is complete"
        )
    return derive(case).expanded()
