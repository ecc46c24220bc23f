"""Proof that a branch follows a chord while all coefficients of the equations move.

The theorem is that of native/segment_proof.hpp. There only the values move, and the quadrics stand
still; here they are polynomials in tau with bounded remainders (`gspcli.certification.taylor`).
Written down on its own, for any number of branches at a time; where only values move the two can
be compared.

Rounding: no term of an expression goes through more than 500 roundings, so that errors are below
2^-44 times the same expression of the moduli of its terms.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.chord_residuals import ExactChords
from gspcli.certification.moving import Shape
from gspcli.certification.taylor import MovingQuadrics

Array = NDArray[np.float64]

#: As in native/segment_proof.hpp.
REACH = 0.125
LONGEST = 0.5
_NORM = 1.07
_ROUNDING = 2.0**-44
_OUTWARD = 1 + 2.0**-30
#: Of p.z and its gradient, sums of eight products.
PATCH = 2.0**-49
#: Degree of the quadrics in tau; what is above counts as error.
DEGREE = 3
#: Coefficients of an equation along a chord and of its gradient: with c, it has the degree
#: of two quadrics and c.
VALUES, _SLOPES = 2 * (DEGREE + 2) + DEGREE + 1, 2 * (DEGREE + 2) + DEGREE


@dataclass(frozen=True, eq=False)
class Parts:
    """The equations on parts of the way, one for each of n branches.

    Attributes
    ----------
    shapes
        Of the six equations, shape (6,).
    quadrics, errors, factors, factor_errors
        As in `MovingQuadrics`, with a first axis of length n and of degree `DEGREE`.
    """

    shapes: NDArray[np.int32]
    quadrics: Array
    errors: Array
    factors: Array
    factor_errors: Array

    @classmethod
    def of(cls, shapes: NDArray[np.int32], parts: Sequence[MovingQuadrics]) -> Parts:
        """Stack the equations of some branches."""
        return cls(
            shapes,
            np.stack([part.quadrics for part in parts]),
            np.stack([part.errors for part in parts]),
            np.stack([part.factors for part in parts]),
            np.stack([part.factor_errors for part in parts]),
        )


def equations_at(
    shapes: NDArray[np.int32], quadrics: Array, factors: Array, points: Array
) -> tuple[Array, Array]:
    """Return the Study condition and the six equations, (n, 7), and derivatives, (n, 7, 8).

    Parameters
    ----------
    shapes
        Of the equations, shape (6,).
    quadrics
        Hessian matrices of A and B, shape (n, 6, 2, 8, 8).
    factors
        c, shape (n, 6).
    points
        Study points, shape (n, 8).
    """
    gradients = np.einsum("nkqxy,ny->nkqx", quadrics, points)
    (a, b) = np.moveaxis(np.einsum("nkqx,nx->nkq", gradients, points) / 2, 2, 0)
    ga, gb = gradients[:, :, 0], gradients[:, :, 1]
    e = np.concatenate((points[:, :4], np.zeros_like(points[:, :4])), axis=1)
    n, gn = np.sum(e * e, axis=1)[:, None], 2 * e[:, None]
    values = np.select(
        [shapes == Shape.PLAIN, shapes == Shape.PRODUCT],
        [a, n * a - b**2],
        a**2 - factors * (n**2 - b**2),
    )
    a, b, n, c = a[..., None], b[..., None], n[..., None], factors[..., None]
    form = shapes[:, None]
    rows = np.select(
        [form == Shape.PLAIN, form == Shape.PRODUCT],
        [ga, n * ga + a * gn - 2 * b * gb],
        2 * a * ga - 2 * c * (n * gn - b * gb),
    )
    study = np.roll(points, 4, axis=1)
    condition = np.sum(points[:, :4] * points[:, 4:], axis=1)
    return (
        np.concatenate((condition[:, None], values), axis=1),
        np.concatenate((study[:, None], rows), axis=1),
    )


@dataclass(frozen=True, eq=False)
class ChordProofs:
    """What is known of n chords.

    Attributes
    ----------
    measure
        Below one: proved.
    end
        How near the zeros at both ends are to the points, at least.
    uniqueness
        How near to the chord there is no other zero.
    radius
        How near to the chord the zeros are all along, at least.
    """

    measure: Array
    end: Array
    uniqueness: Array
    radius: Array


def prove(
    parts: Parts, first: Array, last: Array, exact: Sequence[ExactChords] | None = None
) -> ChordProofs:
    """Try to prove that branches follow chords.

    Parameters
    ----------
    parts
        The equations.
    first, last
        The ends, Study points of norm about one, shape (n, 8).
    exact
        The same equations in balls, for modes that are very near to each other.
    """
    patch, z, d = on_patch(first, last)
    chord = _Chord(parts, z, d)
    for k, one in enumerate(exact or ()):
        chord.values[k], chord.value_errors[k] = one.residuals(z[k], d[k], VALUES)
    matrix = np.concatenate((chord.slopes[:, :, 0], patch[:, None]), axis=1)
    with np.errstate(all="ignore"):
        regular = np.abs(np.linalg.det(matrix)) > 0
        inverse = np.linalg.inv(np.where(regular[:, None, None], matrix, np.eye(8)))
        sizes = np.linalg.norm(inverse, axis=1)
        q = np.linalg.norm(inverse @ matrix - np.eye(8), axis=(1, 2))
        inner, size = inverse[:, :, :7], sizes[:, :7]
        moved = np.einsum("nxr,nrdy->ndxy", inner, chord.slopes[:, :, 1:])
        # The first in the spectral norm.
        norms = np.linalg.norm(moved, axis=(2, 3))
        q += 0.5 * np.linalg.norm(moved[:, 0], ord=2, axis=(1, 2)) + _ROUNDING * norms[:, 0]
        q += norms[:, 1:] @ 0.5 ** np.arange(2, _SLOPES)
        q += np.sum(size * chord.slope_errors, axis=1) + sizes[:, 7] * PATCH
        constant, linear, rest = _split(chord.values)
        # What is left at the ends, in the directions in which the inverse is large or not.
        shifts = np.stack([np.einsum("nxr,nr->nx", inner, part) for part in (constant, linear)])
        lost = chord.value_errors + _ROUNDING * (np.abs(chord.values) @ 0.5 ** np.arange(VALUES))
        end = np.linalg.norm(shifts, axis=2).T @ (1.0, 0.5) + np.sum(size * lost, axis=1)
        end += sizes[:, 7] * 2 * PATCH
        bent = np.linalg.norm(np.einsum("nxr,nrd->ndx", inner, rest), axis=2) @ _WEIGHTS
        beta, q, end = (end + bent) * _OUTWARD, q * _OUTWARD, end * _OUTWARD
        kappa = np.sum(size * chord.curvatures, axis=1) * _OUTWARD
        left = 1 - q
        measure = (q + np.sqrt(2 * kappa * beta)) * _OUTWARD
        uniqueness = np.minimum(left / kappa, REACH) / _OUTWARD
        radius = 2 * beta / left * _OUTWARD
        e, de = np.linalg.norm(z[:, :4], axis=1), np.linalg.norm(d[:, :4], axis=1)
        good = regular & (left > 0) & (radius < uniqueness)
        good &= (np.linalg.norm(d, axis=1) < LONGEST) & (np.linalg.norm(z, axis=1) < _NORM)
        good &= (np.sum(patch * z, axis=1) > 0.9) & (e - de / 2 > radius * _OUTWARD)
        measure = np.where(good, measure, np.fmax(measure, 2.0))
        return ChordProofs(
            np.where(np.isnan(measure), np.inf, measure),
            2 * end / left * _OUTWARD,
            np.where(good, uniqueness, 0.0),
            np.where(good, radius, np.inf),
        )


def on_patch(first: Array, last: Array) -> tuple[Array, Array, Array]:
    """Return a patch p for each chord, its middle and its direction, all of shape (n, 8).

    The chord is ``z + tau d`` with ``p.z = 1`` and ``p.d = 0``, tau from -1/2 to 1/2.
    """
    patch = first + last
    patch = patch / np.linalg.norm(patch, axis=1, keepdims=True)
    x, y = (z / np.sum(patch * z, axis=1, keepdims=True) for z in (first, last))
    return patch, (x + y) / 2, y - x


#: Maxima of (1/4 - tau^2) |tau|^j, rounded up.
_WEIGHTS = np.array(
    [0.5 / (j + 2) * (j / (4 * (j + 2))) ** (j / 2) * (1 + 1e-12) for j in range(VALUES - 2)]
)


def _split(values: Array) -> tuple[Array, Array, Array]:
    """Return r0, r1 and G with ``F = r0 + r1 tau + (tau^2 - 1/4) G``."""
    rest = values[..., 2:].copy()
    for j in range(rest.shape[-1] - 3, -1, -1):
        rest[..., j] += 0.25 * rest[..., j + 2]
    return values[..., 0] + 0.25 * rest[..., 0], values[..., 1] + 0.25 * rest[..., 1], rest


class _Chord:
    """The seven equations along ``z + tau d``, with bounds near it.

    Attributes
    ----------
    values, slopes
        Coefficients of powers of tau of the equations, shape (n, 7, d), and of their gradients,
        shape (n, 7, d - 1, 8).
    value_errors, slope_errors
        Bounds of what is left out, shape (n, 7).
    curvatures
        Bounds of second derivatives within `REACH`, shape (n, 7).
    """

    def __init__(self, parts: Parts, z: Array, d: Array) -> None:
        n = len(z)
        self.values = np.zeros((n, 7, VALUES))
        self.slopes = np.zeros((n, 7, _SLOPES, 8))
        self.value_errors, self.slope_errors, self.curvatures = np.zeros((3, n, 7))
        self._z, self._d = z, d
        half = np.linalg.norm(d, axis=1)[:, None] / 2
        #: Bounds of |z| on the chord and in the tube, and how far the tube goes from the middle.
        self._size = np.linalg.norm(z, axis=1)[:, None] + half
        self._wide, self._reach = self._size + REACH, half + REACH
        self._prepare(parts)
        self._study()
        for shape, fill in (
            (Shape.PLAIN, self._plain),
            (Shape.PRODUCT, self._product),
            (Shape.LINES, self._lines),
        ):
            rows = np.flatnonzero(parts.shapes == shape)
            if len(rows):
                fill(parts, rows)

    def _prepare(self, parts: Parts) -> None:
        """Expand A, B and N along the chord, and bound them."""
        z, d = self._z, self._d
        n, k, two, degree, _, _ = parts.quadrics.shape
        by_z = np.einsum("nkqdxy,ny->nkqdx", parts.quadrics, z)
        gradient = np.zeros((n, k, two, degree + 1, 8))
        gradient[:, :, :, :-1] = by_z
        gradient[:, :, :, 1:] += np.einsum("nkqdxy,ny->nkqdx", parts.quadrics, d)
        value = np.zeros((n, k, two, degree + 2))
        value[..., :-1] = np.einsum("nkqdx,nx->nkqd", gradient, z) / 2
        value[..., 1:] += np.einsum("nkqdx,nx->nkqd", gradient, d) / 2
        self._value, self._gradient = value, gradient
        e, de = (np.concatenate((x[:, :4], np.zeros_like(x[:, :4])), axis=1) for x in (z, d))
        self._n = np.stack([np.sum(a * b, axis=1) for a, b in ((e, e), (2 * e, de), (de, de))], 1)
        self._gn = 2 * np.stack((e, de), axis=1)
        size = self._size[..., None]
        frobenius = np.linalg.norm(parts.quadrics, axis=(4, 5))
        halves = 0.5 ** np.arange(degree)
        moves = frobenius[..., 1:] @ halves[1:] + parts.errors
        self._spectral = np.abs(np.linalg.eigvalsh(parts.quadrics[:, :, :, 0])).max(axis=3)
        self._spectral = self._spectral + _ROUNDING * frobenius[..., 0] + moves
        reach, wide = self._reach[..., None], self._wide[..., None]
        middle = np.linalg.norm(by_z[:, :, :, 0], axis=3)
        #: Bounds in the tube of gradients and values of A and B.
        self._first = middle + self._spectral * reach + moves * wide
        self._most = np.abs(value[..., 0]) + self._first * reach + moves * wide**2 / 2
        #: Of what is left out of the values and gradients on the chord.
        self._off = parts.errors * size**2 / 2
        self._slope_off = parts.errors * size
        #: The expressions of moduli.
        self._moduli = (frobenius @ halves) * size**2 / 2
        far = np.linalg.norm(z[:, :4], axis=1)[:, None] + self._reach
        self._first_n, self._most_n = 2 * far, far**2

    def _study(self) -> None:
        z, d = self._z, self._d
        self.slopes[:, 0, 0], self.slopes[:, 0, 1] = np.roll(z, 4, axis=1), np.roll(d, 4, axis=1)
        swapped = self.slopes[:, 0, 0]
        self.values[:, 0, 0] = np.sum(swapped * z, axis=1) / 2
        self.values[:, 0, 1] = np.sum(swapped * d, axis=1)
        self.values[:, 0, 2] = np.sum(self.slopes[:, 0, 1] * d, axis=1) / 2
        self.curvatures[:, 0] = 1.0
        self.value_errors[:, 0] = _ROUNDING * self._size[:, 0] ** 2
        self.slope_errors[:, 0] = _ROUNDING * self._size[:, 0]

    def _plain(self, parts: Parts, rows: NDArray[np.intp]) -> None:
        at, size = rows + 1, self._size
        self.values[:, at, : DEGREE + 3] = self._value[:, rows, 0]
        self.slopes[:, at, : DEGREE + 2] = self._gradient[:, rows, 0]
        self.curvatures[:, at] = self._spectral[:, rows, 0]
        moduli = _ROUNDING * self._moduli[:, rows, 0]
        self.value_errors[:, at] = self._off[:, rows, 0] + moduli
        self.slope_errors[:, at] = self._slope_off[:, rows, 0] + 2 * moduli / size

    def _product(self, parts: Parts, rows: NDArray[np.intp]) -> None:
        """Fill in ``N A - B^2``."""
        at, size = rows + 1, self._size
        a, b = self._value[:, rows, 0], self._value[:, rows, 1]
        ga, gb = self._gradient[:, rows, 0], self._gradient[:, rows, 1]
        n, gn = self._n[:, None], self._gn[:, None]
        _add(self.values, at, _times(n, a))
        _add(self.values, at, -_times(b, b))
        _add(self.slopes, at, _along(n, ga))
        _add(self.slopes, at, _along(a, gn))
        _add(self.slopes, at, -2 * _along(b, gb))
        sa, sb = self._spectral[:, rows, 0], self._spectral[:, rows, 1]
        fa, fb = self._first[:, rows, 0], self._first[:, rows, 1]
        ma, mb = self._most[:, rows, 0], self._most[:, rows, 1]
        fn, mn = self._first_n, self._most_n
        self.curvatures[:, at] = 2 * ma + mn * sa + 2 * fn * fa + 2 * (mb * sb + fb**2)
        oa, ob = self._off[:, rows, 0], self._off[:, rows, 1]
        ua, ub = self._slope_off[:, rows, 0], self._slope_off[:, rows, 1]
        moduli = size**2 * self._moduli[:, rows, 0] + self._moduli[:, rows, 1] ** 2
        moduli *= _ROUNDING
        self.value_errors[:, at] = mn * oa + (2 * mb + ob) * ob + moduli
        self.slope_errors[:, at] = (
            mn * ua + fn * oa + 2 * (fb * ob + (mb + ob) * ub) + 4 * moduli / size
        )

    def _lines(self, parts: Parts, rows: NDArray[np.intp]) -> None:
        """Fill in ``A^2 - c (N^2 - B^2)``."""
        at, size = rows + 1, self._size
        a, b = self._value[:, rows, 0], self._value[:, rows, 1]
        ga, gb = self._gradient[:, rows, 0], self._gradient[:, rows, 1]
        n, gn = self._n[:, None], self._gn[:, None]
        c, off = parts.factors[:, rows], parts.factor_errors[:, rows]
        gap = _less(_times(n, n), _times(b, b))
        _add(self.values, at, _times(a, a))
        _add(self.values, at, -_times(c, gap))
        _add(self.slopes, at, 2 * _along(a, ga))
        _add(self.slopes, at, -2 * _along(_times(c, n), gn))
        _add(self.slopes, at, 2 * _along(_times(c, b), gb))
        size_c = np.abs(c) @ 0.5 ** np.arange(c.shape[2]) + off
        sa, sb = self._spectral[:, rows, 0], self._spectral[:, rows, 1]
        fa, fb = self._first[:, rows, 0], self._first[:, rows, 1]
        ma, mb = self._most[:, rows, 0], self._most[:, rows, 1]
        fn, mn = self._first_n, self._most_n
        self.curvatures[:, at] = 2 * (ma * sa + fa**2) + size_c * (
            4 * mn + 2 * fn**2 + 2 * (mb * sb + fb**2)
        )
        oa, ob = self._off[:, rows, 0], self._off[:, rows, 1]
        ua, ub = self._slope_off[:, rows, 0], self._slope_off[:, rows, 1]
        moduli = self._moduli[:, rows, 0] ** 2
        moduli = _ROUNDING * (moduli + size_c * (size**4 + self._moduli[:, rows, 1] ** 2))
        self.value_errors[:, at] = (
            (2 * ma + oa) * oa + off * (mn**2 + mb**2) + size_c * (2 * mb + ob) * ob + moduli
        )
        self.slope_errors[:, at] = (
            2 * (fa * oa + (ma + oa) * ua)
            + 2 * off * (mn * fn + mb * fb)
            + 2 * size_c * (fb * ob + (mb + ob) * ub)
            + 4 * moduli / size
        )


def _times(a: Array, b: Array) -> Array:
    """Return products of polynomials, (..., p) and (..., q)."""
    shape = np.broadcast_shapes(a.shape[:-1], b.shape[:-1])
    product = np.zeros((*shape, a.shape[-1] + b.shape[-1] - 1))
    for j in range(a.shape[-1]):
        product[..., j : j + b.shape[-1]] += a[..., j, None] * b
    return product


def _along(a: Array, g: Array) -> Array:
    """Return products of polynomials and vectors of polynomials, (..., p) and (..., q, 8)."""
    shape = np.broadcast_shapes(a.shape[:-1], g.shape[:-2])
    product = np.zeros((*shape, a.shape[-1] + g.shape[-2] - 1, g.shape[-1]))
    for j in range(a.shape[-1]):
        product[..., j : j + g.shape[-2], :] += a[..., j, None, None] * g
    return product


def _less(a: Array, b: Array) -> Array:
    """Return the difference of polynomials."""
    difference = np.zeros((*b.shape[:-1], max(a.shape[-1], b.shape[-1])))
    difference[..., : a.shape[-1]] += a
    difference[..., : b.shape[-1]] -= b
    return difference


def _add(target: Array, rows: NDArray[np.intp], terms: Array) -> None:
    """Add polynomials of lower degree to those of some equations."""
    target[:, rows, : terms.shape[2]] += terms
