"""Eigenvalues and eigenvectors of a real matrix in high precision, without error bounds.

The method uses a Hessenberg matrix, its characteristic polynomial and the roots of this. It is
quick, but each of the three loses digits, so the working precision must be much higher than that of
the result. FLINT's own method is more stable and takes ten times as long. If few eigenvalues are
much larger than all others, powers of the matrix give their eigenvectors.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import log2
from random import Random
from typing import Any

from flint import acb, acb_mat, acb_poly, arb, arb_mat, arb_poly, ctx

from gspcli.certification.numbers.balls import power_of_two

_ISOLATED_BITS = 30
#: The binary logarithm of the ratio from which roots are of different sizes: each part of a
#: polynomial gives them to so many bits, about.
_APART_BITS = 20
#: The most times that all of them are improved together.
_SWEEPS = 40
#: The power of the matrix in which the largest eigenvalues dominate.
_POWERS = 6


class SpectrumError(ValueError):
    """The precision does not suffice to separate the eigenvalues."""


def eigenvectors(matrix: arb_mat, entries: Sequence[int]) -> list[tuple[acb, ...]]:
    """Return some entries of each right eigenvector of a matrix with distinct eigenvalues.

    Parameters
    ----------
    matrix
        A square matrix; only its midpoints are used.
    entries
        The entries to return.

    Raises
    ------
    SpectrumError
        If the eigenvalues cannot be separated.
    """
    size = matrix.nrows()
    flat = [entry.mid() for entry in matrix.entries()]
    rows = [flat[size * i : size * (i + 1)] for i in range(size)]
    steps = _to_hessenberg(rows)
    restoring = arb_mat([_restoring_row(k, size, steps) for k in entries])
    result: list[tuple[acb, ...]] = []
    for value in _eigenvalues(rows):
        column = (restoring * acb_mat(size, 1, _vector(rows, value))).entries()
        result.append(tuple(x.mid() for x in column))
        if isinstance(value, acb):
            result.append(tuple(x.conjugate().mid() for x in column))
    return result


def largest_eigenvectors(
    matrix: arb_mat, entries: Sequence[int], number: int
) -> list[tuple[acb, ...]]:
    """Return some entries of each right eigenvector of the largest eigenvalues.

    This saves a third of the time of a first solution if poses are far away because of rounding
    (`tools.verify.realistic`, hexapods in floating point).

    Parameters
    ----------
    matrix, entries
        As for `eigenvectors`; the errors are the same.
    number
        The number of eigenvalues that are much larger than the others. If they are not, the result
        is meaningless.
    """
    size, random = matrix.nrows(), Random(0)
    # The sizes of the entries of these eigenvectors are proportional to those of the rows.
    sums = (matrix * arb_mat(size, 1, [1] * size)).entries()
    scales = [power_of_two(float(abs(x).mid())) for x in sums]
    image, forms = (
        arb_mat([[sign * x for sign in random.choices((-1, 1), k=number)] for x in each])
        for each in (scales, [1 / x for x in scales])
    )
    for _ in range(_POWERS):
        basis, image = image, (matrix * image).mid()
    forms = forms.transpose()
    small = (forms * basis).solve(forms * image, algorithm="approx")
    flat = basis.entries()
    rows = arb_mat([flat[number * k : number * (k + 1)] for k in entries])
    found = eigenvectors(small, range(number))
    columns = ((rows * acb_mat(number, 1, vector)).entries() for vector in found)
    return [tuple(x.mid() for x in column) for column in columns]


def _to_hessenberg(rows: list[list[arb]]) -> list[tuple[int, int, list[arb]]]:
    """Make a matrix Hessenberg in place, by eliminations with pivots; return the steps."""
    size = len(rows)
    steps = []
    for m in range(1, size - 1):
        pivot = max(range(m, size), key=lambda i: abs(rows[i][m - 1]))
        if rows[pivot][m - 1].is_zero():
            message = "the matrix is reducible"
            raise SpectrumError(message)
        rows[m], rows[pivot] = rows[pivot], rows[m]
        for row in rows:
            row[m], row[pivot] = row[pivot], row[m]
        leading, upper = rows[m][m - 1], rows[m]
        factors = []
        for i in range(m + 1, size):
            row = rows[i]
            factor = (row[m - 1] / leading).mid()
            factors.append(factor)
            if factor.is_zero():
                continue
            row[m - 1] = arb(0)
            row[m:] = [(x - factor * y).mid() for x, y in zip(row[m:], upper[m:], strict=True)]
        for row in rows:
            total = row[m]
            for factor, x in zip(factors, row[m + 1 :], strict=True):
                total += factor * x
            row[m] = total.mid()
        steps.append((m, pivot, factors))
    return steps


def _eigenvalues(rows: Sequence[Sequence[arb]]) -> list[arb | acb]:
    """Return the real eigenvalues of a Hessenberg matrix, and one of each pair of conjugates."""
    polynomials = [arb_poly([1])]
    for k in range(len(rows)):
        current = arb_poly([-rows[k][k], 1]) * polynomials[k]
        product = arb(1)
        for i in range(k - 1, -1, -1):
            product = (product * rows[i + 1][i]).mid()
            current -= polynomials[i] * (rows[i][k] * product)
        polynomials.append(arb_poly([x.mid() for x in current.coeffs()]))
    last = polynomials[-1]
    parts = _parts(last)
    try:
        roots = [[unit * root for root in part.complex_roots()] for part, unit in parts]
    except ValueError as error:
        raise SpectrumError(str(error)) from None
    if len(parts) > 1:
        return _together(acb_poly(last), [root.mid() for each in roots for root in each])
    # Balls about the roots are disjoint: one that contains a real number has a real root.
    real = [root.real.mid() for root in roots[0] if root.imag.contains(0)]
    upper = [root.mid() for root in roots[0] if root.imag > 0]
    return [
        *(_polished(last, root) for root in real),
        *(_polished(acb_poly(last), root) for root in upper),
    ]


def _parts(polynomial: arb_poly) -> list[tuple[arb_poly, arb]]:
    """Return polynomials with the roots of one of about equal sizes, in units of these.

    Poses that are 1e24 lengths away have eigenvalues of this size. FLINT does not find the roots of
    a polynomial whose sizes differ so much. The slopes of its Newton polygon are their logarithms,
    and the coefficients between two corners give the roots of one size, up to the ratio of sizes.
    """
    coefficients = polynomial.coeffs()
    # Corners of the polygon, and the logarithms of the sizes between them.
    corners: list[tuple[int, float]] = []
    for k, x in enumerate(coefficients):
        if x.is_zero():
            continue
        here = (k, _logarithm(x))
        while len(corners) > 1 and _slope(corners[-2], here) >= _slope(corners[-2], corners[-1]):
            corners.pop()
        corners.append(here)
    kept = corners[:1]
    for k in range(1, len(corners) - 1):
        sizes = [-_slope(corners[k + i - 1], corners[k + i]) for i in (0, 1)]
        if sizes[1] - sizes[0] > _APART_BITS:
            kept.append(corners[k])
    kept.append(corners[-1])
    result = []
    for first, last in pairwise(kept):
        unit = arb(2) ** round(-_slope(first, last))
        part = coefficients[first[0] : last[0] + 1]
        scaled = [(x * unit**k).mid() for k, x in enumerate(part)]
        result.append((arb_poly(scaled), unit))
    return result


def _together(polynomial: acb_poly, roots: list[acb]) -> list[arb | acb]:
    """Return all real roots and one of each pair of conjugates, from bad approximations of all.

    Each step keeps away from the other roots (O. Aberth, Iteration methods for finding all zeros of
    a polynomial simultaneously, Mathematics of Computation 27, 1973).
    """
    derivative = polynomial.derivative()
    for _ in range(_SWEEPS):
        largest = arb(0)
        for k, root in enumerate(roots):
            step = polynomial(root).mid() / derivative(root).mid()
            others = sum((1 / (root - x) for i, x in enumerate(roots) if i != k), acb(0)).mid()
            step = (step / (1 - step * others)).mid()
            roots[k] = (root - step).mid()
            largest = max(largest, abs(step / root).mid())
        if largest < arb(2) ** (-ctx.prec // 4):
            break
    least = arb(2) ** (-ctx.prec // 8)
    real = [x for x in roots if abs(x.imag) <= least * abs(x)]
    return [*(x.real for x in real), *(x for x in roots if x.imag > least * abs(x))]


def _logarithm(x: arb) -> float:
    """Return the logarithm of the size of a number for the base 2."""
    mantissa, exponent = x.mid().man_exp()
    return float(int(exponent)) + log2(abs(int(mantissa)))


def _slope(first: tuple[int, float], last: tuple[int, float]) -> float:
    return (last[1] - first[1]) / (last[0] - first[0])


def _polished(polynomial: Any, root: Any) -> Any:
    """Return a root of a polynomial in the working precision, by Newton's method."""
    derivative = polynomial.derivative()
    # FLINT's roots have some thirty correct bits at least, and each step doubles them.
    for _ in range(max(ctx.prec // _ISOLATED_BITS, 1).bit_length() + 1):
        root = (root - (polynomial(root) / derivative(root)).mid()).mid()
    return root


def _vector(rows: Sequence[Sequence[arb]], value: Any) -> list[Any]:
    """Return an eigenvector of a Hessenberg matrix from its last entry upwards."""
    size = len(rows)
    vector: list[Any] = [arb(0)] * size
    vector[-1] = arb(1)
    for i in range(size - 1, 0, -1):
        row = rows[i]
        total = value * vector[i]
        for x, y in zip(row[i:], vector[i:], strict=True):
            total -= x * y
        vector[i - 1] = (total / row[i - 1]).mid()
    return vector


def _restoring_row(k: int, size: int, steps: Sequence[tuple[int, int, Sequence[arb]]]) -> list[arb]:
    """Return the row that gives an entry of an eigenvector from that of the Hessenberg form."""
    row = [arb(0)] * size
    row[k] = arb(1)
    for m, pivot, factors in steps:
        row[m], row[pivot] = row[pivot], row[m]
        total = row[m]
        for factor, x in zip(factors, row[m + 1 :], strict=True):
            if not x.is_zero():
                total += factor * x
        row[m] = total.mid()
    return row
