"""Polynomials in the variables of an elimination; the functions of a motion as polynomials."""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb, arb_mat, fmpq

from gspcli.certification.counting.motion_equations import MotionEquations
from gspcli.certification.counting.residue_counts import EliminationTrace
from gspcli.certification.equations import study

#: A polynomial, by packed exponents; and a vector over normal monomials, by their positions.
Polynomial = dict[int, arb]
Vector = dict[int, arb]

ONE = arb(1)
#: The relations of the coordinates have fractions with denominators and numerators below these.
_MAX_DENOMINATOR, _MAX_NUMERATOR = 64, 2**20


class NotFollowedError(ValueError):
    """An elimination that cannot be followed; says why."""


def add(vector: dict[int, arb], at: int, value: arb) -> None:
    """Add a value at one place."""
    present = vector.get(at)
    vector[at] = value if present is None else present + value


def add_multiple(polynomial: Polynomial, other: Polynomial, factor: arb) -> None:
    """Add a multiple of another polynomial."""
    for monomial, value in other.items():
        add(polynomial, monomial, value * factor)


def add_product(polynomial: Polynomial, first: Polynomial, second: Polynomial, factor: arb) -> None:
    """Add a multiple of the product of two polynomials."""
    for a, x in first.items():
        scaled = x * factor
        for b, y in second.items():
            add(polynomial, a + b, scaled * y)


def small_fraction(residue: int, prime: int) -> arb:
    """Return the fraction of small integers with a residue."""
    for denominator in range(1, _MAX_DENOMINATOR):
        numerator = residue * denominator % prime
        numerator -= prime if numerator > prime // 2 else 0
        if abs(numerator) < _MAX_NUMERATOR:
            return arb(fmpq(numerator, denominator))
    message = f"the relation {residue} of the coordinates modulo {prime} is no small fraction"
    raise NotFollowedError(message)


def products_of_coordinates(position: int, has_translation: bool) -> list[tuple[int, int, int]]:
    """Return products of coordinates, and signs: a function without a coordinate is their sum."""
    rotation = study.ROTATION
    if position == study.RHO:
        vector = study.TRANSLATION if has_translation else study.BODY
        return [(k, k, 1) for k in vector]
    if position in study.BODY:
        j = study.BODY.index(position)
        return [(rotation[i][j], study.TRANSLATION[i], 1) for i in range(3)]
    if position in study.TRANSLATION:
        i = study.TRANSLATION.index(position)
        return [(rotation[i][j], study.BODY[j], 1) for j in range(3)]
    i, j = divmod(position - study.MOMENT[0][0], 3)
    turned = i if has_translation else j
    after, last = (turned + 1) % 3, (turned + 2) % 3
    if has_translation:  # (T x R)_ij
        first, second = study.TRANSLATION[after], study.TRANSLATION[last]
        return [(rotation[last][j], first, 1), (rotation[after][j], second, -1)]
    first, second = study.BODY[last], study.BODY[after]  # (R x U)_ij
    return [(rotation[i][after], first, 1), (rotation[i][last], second, -1)]


def solved_rows(
    rows: Sequence[Vector], pivots: Sequence[int], others: Sequence[int]
) -> list[list[arb]]:
    """Return the other columns of the rows, reduced: each pivot is 1 and alone in its column."""
    if not rows:
        return []
    zero = arb(0)
    matrix = arb_mat([[row.get(c, zero) for c in pivots] for row in rows])
    right = arb_mat([[row.get(c, zero) for c in others] for row in rows])
    entries = matrix.solve(right, algorithm="approx").entries() if others else []
    width = len(others)
    return [entries[k * width : (k + 1) * width] for k in range(len(pivots))]


def affine_forms(
    equations: MotionEquations, trace: EliminationTrace, units: Sequence[int]
) -> dict[int, Polynomial]:
    """Return the coordinates in use as affine forms, by the linear equations."""
    forms: dict[int, Polynomial] = {study.NORM: {0: ONE}}
    forms |= {k: {unit: ONE} for k, unit in zip(trace.variables, units, strict=True)}
    pivots = [k for k in trace.coordinates if k not in forms]
    if pivots:
        others = [study.NORM, *trace.variables]
        rows = [
            {k: arb(value) for k, value in equation.linear.items()}
            for number, equation in enumerate(equations.equations)
            if number not in trace.quadrics
        ]
        for pivot, row in zip(pivots, solved_rows(rows, pivots, others), strict=True):
            forms[pivot] = {
                monomial: -value for monomial, value in zip([0, *units], row, strict=True)
            }
    return forms
