"""Three angles as a triangular set in the entries of R (paper, Section 6.1).

The system is equation (11): ``s1·R s4 = d1``, ``s2·R s5 = d2``, ``s3·R s6 = d3`` with R a
rotation. The frames of base and platform are chosen as in the paper:
``s1 = s4 = (0, 0, 1)``, ``s2 = (0, m0, n0)``, ``s5 = (0, m2, n2)``, ``s3 = (l1, m1, n1)``,
``s6 = (l3, m3, n3)``. Nothing is used of the length of s2, s3, s5 and s6.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from gspcli.symbolic.eliminations import cramer, determinant
from gspcli.symbolic.sparse_polynomials import Polynomial, coefficient, coefficients
from gspcli.symbolic.triangular import (
    Elimination,
    NonVanishing,
    Relation,
    TriangularPolynomial,
    TriangularSet,
)

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
