"""The equations along the chord between two poses, while all coefficients move.

They are polynomials in tau, from -1/2 to 1/2 along the chord, with bounds of the remainders of the
quadrics (`gspcli.certification.branches.taylor`) and of rounding. No term is rounded more than 500
times, so errors are below 2^-44 times the same expression of the moduli of its terms.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.parametric_quadrics import Shape
from gspcli.certification.branches.taylor import MovingQuadrics
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Distance from a chord within which second and third derivatives are bounded, as in
#: native/segment_proof.hpp.
REACH = 0.125
ROUNDING = 2.0**-44
#: Degree of the quadrics in tau; higher terms count as error.
DEGREE = 3
#: Coefficients of an equation along a chord, of its gradient and of its second derivatives: with
#: c, it has the degree of two quadrics and c.
VALUES = 2 * (DEGREE + 2) + DEGREE + 1
SLOPES, BENDS = VALUES - 1, VALUES - 2


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


class Chord:
    """The seven equations along ``z + tau d``, with bounds near it.

    Attributes
    ----------
    values, slopes
        Coefficients of powers of tau of the equations, shape (n, 7, d), and of their gradients,
        shape (n, 7, d - 1, 8).
    value_errors, slope_errors
        Bounds of the remainders, shape (n, 7).
    curvatures
        Bounds of second derivatives within `REACH`, shape (n, 7).
    value, gradient, n, gn
        Coefficients of A and B, shape (n, 6, 2, d), of their gradients, of N and of its gradient.
    spectral, first, most
        Bounds of second derivatives, gradients and values of A and B within `REACH`, (n, 6, 2).
    first_n, most_n
        The same of N, shape (n, 1).
    off, slope_off
        Bounds of the remainders of A and B and of their gradients on the chord, (n, 6, 2).
    moduli
        Bounds of A and B with all terms replaced by their moduli, shape (n, 6, 2).
    size
        Upper bound of |z| on the chord, shape (n, 1).
    """

    def __init__(self, parts: Parts, z: Array, d: Array) -> None:
        n = len(z)
        self.values = np.zeros((n, 7, VALUES))
        self.slopes = np.zeros((n, 7, SLOPES, 8))
        self.value_errors, self.slope_errors, self.curvatures = np.zeros((3, n, 7))
        self.z, self.d = z, d
        half = np.linalg.norm(d, axis=1)[:, None] / 2
        #: Bounds of |z| on the chord and in the tube, and how far the tube goes from the middle.
        self.size = np.linalg.norm(z, axis=1)[:, None] + half
        self._wide, self._reach = self.size + REACH, half + REACH
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
        z, d = self.z, self.d
        n, k, two, degree, _, _ = parts.quadrics.shape
        by_z = np.einsum("nkqdxy,ny->nkqdx", parts.quadrics, z)
        gradient = np.zeros((n, k, two, degree + 1, 8))
        gradient[:, :, :, :-1] = by_z
        gradient[:, :, :, 1:] += np.einsum("nkqdxy,ny->nkqdx", parts.quadrics, d)
        value = np.zeros((n, k, two, degree + 2))
        value[..., :-1] = np.einsum("nkqdx,nx->nkqd", gradient, z) / 2
        value[..., 1:] += np.einsum("nkqdx,nx->nkqd", gradient, d) / 2
        self.value, self.gradient = value, gradient
        e, de = (np.concatenate((x[:, :4], np.zeros_like(x[:, :4])), axis=1) for x in (z, d))
        self.n = np.stack([np.sum(a * b, axis=1) for a, b in ((e, e), (2 * e, de), (de, de))], 1)
        self.gn = 2 * np.stack((e, de), axis=1)
        size = self.size[..., None]
        frobenius = np.linalg.norm(parts.quadrics, axis=(4, 5))
        halves = 0.5 ** np.arange(degree)
        moves = frobenius[..., 1:] @ halves[1:] + parts.errors
        self.spectral = np.abs(np.linalg.eigvalsh(parts.quadrics[:, :, :, 0])).max(axis=3)
        self.spectral = self.spectral + ROUNDING * frobenius[..., 0] + moves
        reach, wide = self._reach[..., None], self._wide[..., None]
        middle = np.linalg.norm(by_z[:, :, :, 0], axis=3)
        #: Bounds in the tube of gradients and values of A and B.
        self.first = middle + self.spectral * reach + moves * wide
        self.most = np.abs(value[..., 0]) + self.first * reach + moves * wide**2 / 2
        #: Bounds of the remainders of values and gradients on the chord.
        self.off = parts.errors * size**2 / 2
        self.slope_off = parts.errors * size
        #: The expressions of moduli.
        self.moduli = (frobenius @ halves) * size**2 / 2
        far = np.linalg.norm(z[:, :4], axis=1)[:, None] + self._reach
        self.first_n, self.most_n = 2 * far, far**2

    def _study(self) -> None:
        z, d = self.z, self.d
        self.slopes[:, 0, 0], self.slopes[:, 0, 1] = np.roll(z, 4, axis=1), np.roll(d, 4, axis=1)
        swapped = self.slopes[:, 0, 0]
        self.values[:, 0, 0] = np.sum(swapped * z, axis=1) / 2
        self.values[:, 0, 1] = np.sum(swapped * d, axis=1)
        self.values[:, 0, 2] = np.sum(self.slopes[:, 0, 1] * d, axis=1) / 2
        self.curvatures[:, 0] = 1.0
        self.value_errors[:, 0] = ROUNDING * self.size[:, 0] ** 2
        self.slope_errors[:, 0] = ROUNDING * self.size[:, 0]

    def _plain(self, parts: Parts, rows: NDArray[np.intp]) -> None:
        at, size = rows + 1, self.size
        self.values[:, at, : DEGREE + 3] = self.value[:, rows, 0]
        self.slopes[:, at, : DEGREE + 2] = self.gradient[:, rows, 0]
        self.curvatures[:, at] = self.spectral[:, rows, 0]
        moduli = ROUNDING * self.moduli[:, rows, 0]
        self.value_errors[:, at] = self.off[:, rows, 0] + moduli
        self.slope_errors[:, at] = self.slope_off[:, rows, 0] + 2 * moduli / size

    def _product(self, parts: Parts, rows: NDArray[np.intp]) -> None:
        """Fill in ``N A - B^2``."""
        at, size = rows + 1, self.size
        a, b = self.value[:, rows, 0], self.value[:, rows, 1]
        ga, gb = self.gradient[:, rows, 0], self.gradient[:, rows, 1]
        n, gn = self.n[:, None], self.gn[:, None]
        add(self.values, at, times(n, a))
        add(self.values, at, -times(b, b))
        add(self.slopes, at, along(n, ga))
        add(self.slopes, at, along(a, gn))
        add(self.slopes, at, -2 * along(b, gb))
        sa, sb = self.spectral[:, rows, 0], self.spectral[:, rows, 1]
        fa, fb = self.first[:, rows, 0], self.first[:, rows, 1]
        ma, mb = self.most[:, rows, 0], self.most[:, rows, 1]
        fn, mn = self.first_n, self.most_n
        self.curvatures[:, at] = 2 * ma + mn * sa + 2 * fn * fa + 2 * (mb * sb + fb**2)
        oa, ob = self.off[:, rows, 0], self.off[:, rows, 1]
        ua, ub = self.slope_off[:, rows, 0], self.slope_off[:, rows, 1]
        moduli = size**2 * self.moduli[:, rows, 0] + self.moduli[:, rows, 1] ** 2
        moduli *= ROUNDING
        self.value_errors[:, at] = mn * oa + (2 * mb + ob) * ob + moduli
        self.slope_errors[:, at] = (
            mn * ua + fn * oa + 2 * (fb * ob + (mb + ob) * ub) + 4 * moduli / size
        )

    def _lines(self, parts: Parts, rows: NDArray[np.intp]) -> None:
        """Fill in ``A^2 - c (N^2 - B^2)``."""
        at, size = rows + 1, self.size
        a, b = self.value[:, rows, 0], self.value[:, rows, 1]
        ga, gb = self.gradient[:, rows, 0], self.gradient[:, rows, 1]
        n, gn = self.n[:, None], self.gn[:, None]
        c, off = parts.factors[:, rows], parts.factor_errors[:, rows]
        gap = less(times(n, n), times(b, b))
        add(self.values, at, times(a, a))
        add(self.values, at, -times(c, gap))
        add(self.slopes, at, 2 * along(a, ga))
        add(self.slopes, at, -2 * along(times(c, n), gn))
        add(self.slopes, at, 2 * along(times(c, b), gb))
        size_c = np.abs(c) @ 0.5 ** np.arange(c.shape[2]) + off
        sa, sb = self.spectral[:, rows, 0], self.spectral[:, rows, 1]
        fa, fb = self.first[:, rows, 0], self.first[:, rows, 1]
        ma, mb = self.most[:, rows, 0], self.most[:, rows, 1]
        fn, mn = self.first_n, self.most_n
        self.curvatures[:, at] = 2 * (ma * sa + fa**2) + size_c * (
            4 * mn + 2 * fn**2 + 2 * (mb * sb + fb**2)
        )
        oa, ob = self.off[:, rows, 0], self.off[:, rows, 1]
        ua, ub = self.slope_off[:, rows, 0], self.slope_off[:, rows, 1]
        moduli = self.moduli[:, rows, 0] ** 2
        moduli = ROUNDING * (moduli + size_c * (size**4 + self.moduli[:, rows, 1] ** 2))
        self.value_errors[:, at] = (
            (2 * ma + oa) * oa + off * (mn**2 + mb**2) + size_c * (2 * mb + ob) * ob + moduli
        )
        self.slope_errors[:, at] = (
            2 * (fa * oa + (ma + oa) * ua)
            + 2 * off * (mn * fn + mb * fb)
            + 2 * size_c * (fb * ob + (mb + ob) * ub)
            + 4 * moduli / size
        )


def times(a: Array, b: Array) -> Array:
    """Return products of polynomials, (..., p) and (..., q)."""
    shape = np.broadcast_shapes(a.shape[:-1], b.shape[:-1])
    product = np.zeros((*shape, a.shape[-1] + b.shape[-1] - 1))
    for j in range(a.shape[-1]):
        product[..., j : j + b.shape[-1]] += a[..., j, None] * b
    return product


def along(a: Array, g: Array) -> Array:
    """Return products of polynomials and vectors of polynomials, (..., p) and (..., q, 8)."""
    shape = np.broadcast_shapes(a.shape[:-1], g.shape[:-2])
    product = np.zeros((*shape, a.shape[-1] + g.shape[-2] - 1, g.shape[-1]))
    for j in range(a.shape[-1]):
        product[..., j : j + g.shape[-2], :] += a[..., j, None, None] * g
    return product


def less(a: Array, b: Array) -> Array:
    """Return the difference of polynomials."""
    difference = np.zeros((*b.shape[:-1], max(a.shape[-1], b.shape[-1])))
    difference[..., : a.shape[-1]] += a
    difference[..., : b.shape[-1]] -= b
    return difference


def add(target: Array, rows: NDArray[np.intp], terms: Array) -> None:
    """Add polynomials of lower degree to those of some equations."""
    target[:, rows, : terms.shape[2]] += terms
