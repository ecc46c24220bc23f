"""Second derivatives of the equations along a chord, and bounds of the third ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.parametric_quadrics import Shape
from gspcli.motion.following.chord_equations import BENDS, ROUNDING, Chord, Parts

Array = NDArray[np.float64]


class Bends:
    """Second derivatives of the seven equations along chords.

    Parameters
    ----------
    parts
        The equations.
    chord
        The bounds of the equations along the chords.

    Attributes
    ----------
    values
        Coefficients of powers of tau, shape (n, 7, d, 8, 8).
    errors
        Bounds of the remainders, shape (n, 7).
    thirds
        Bounds of the third derivatives within `REACH`, shape (n, 7).
    """

    def __init__(self, parts: Parts, chord: Chord) -> None:
        self._chord = chord
        n = len(chord.z)
        self.values = np.zeros((n, 7, BENDS, 8, 8))
        self.errors, self.thirds = np.zeros((2, n, 7))
        self.values[:, 0, 0] = np.roll(np.eye(8), 4, axis=0)
        for shape, fill in (
            (Shape.PLAIN, self._plain),
            (Shape.PRODUCT, self._product),
            (Shape.LINES, self._lines),
        ):
            rows = np.flatnonzero(parts.shapes == shape)
            if len(rows):
                fill(parts, rows)

    def _plain(self, parts: Parts, rows: NDArray[np.intp]) -> None:
        chord = self._chord
        quadrics = parts.quadrics[:, rows, 0]
        self.values[:, rows + 1, : quadrics.shape[2]] = quadrics
        self.errors[:, rows + 1] = (
            parts.errors[:, rows, 0] + 2 * ROUNDING * chord.moduli[:, rows, 0] / chord.size**2
        )

    def _product(self, parts: Parts, rows: NDArray[np.intp]) -> None:
        """Fill in the second derivatives of ``N A - B^2``."""
        chord, at = self._chord, rows + 1
        (a, b), (ga, gb), (ha, hb) = self._forms(parts, rows)
        n, gn = chord.n[:, None], chord.gn[:, None]
        cross = _outer(ga, gn)
        self._add(at, _scaled(n, ha))
        self._add(at, _scaled(a, _TURNING))
        self._add(at, cross + np.swapaxes(cross, -1, -2))
        self._add(at, -2 * _scaled(b, hb))
        self._add(at, -2 * _outer(gb, gb))
        (sa, sb), (fa, fb), (_, mb) = self._bounds(rows)
        (ea, eb), (ua, ub), (oa, ob) = self._left_out(parts, rows)
        fn, mn = chord.first_n, chord.most_n
        self.thirds[:, at] = 3 * (2 * fa + fn * sa) + 6 * sb * fb
        moduli = chord.size**2 * chord.moduli[:, rows, 0] + chord.moduli[:, rows, 1] ** 2
        self.errors[:, at] = mn * ea + 2 * oa + 2 * fn * ua + 16 * ROUNDING * moduli / chord.size**2
        self.errors[:, at] += 2 * ((mb + ob) * eb + ob * sb + (2 * fb + ub) * ub)

    def _lines(self, parts: Parts, rows: NDArray[np.intp]) -> None:
        """Fill in the second derivatives of ``A^2 - c (N^2 - B^2)``."""
        chord, at = self._chord, rows + 1
        (a, b), (ga, gb), (ha, hb) = self._forms(parts, rows)
        n, gn = chord.n[:, None], chord.gn[:, None]
        c, off = parts.factors[:, rows], parts.factor_errors[:, rows]
        self._add(at, 2 * _scaled(a, ha))
        self._add(at, 2 * _outer(ga, ga))
        self._add(at, -2 * _scaled(c, _scaled(n, _TURNING)))
        self._add(at, -2 * _scaled(c, _outer(gn, gn)))
        self._add(at, 2 * _scaled(c, _scaled(b, hb)))
        self._add(at, 2 * _scaled(c, _outer(gb, gb)))
        size_c = np.abs(c) @ 0.5 ** np.arange(c.shape[2]) + off
        (sa, sb), (fa, fb), (ma, mb) = self._bounds(rows)
        (ea, eb), (ua, ub), (oa, ob) = self._left_out(parts, rows)
        fn, mn = chord.first_n, chord.most_n
        self.thirds[:, at] = 6 * sa * fa + size_c * (12 * fn + 6 * sb * fb)
        moduli = chord.moduli[:, rows, 0] ** 2
        moduli = moduli + size_c * (chord.size**4 + chord.moduli[:, rows, 1] ** 2)
        self.errors[:, at] = 16 * ROUNDING * moduli / chord.size**2
        self.errors[:, at] += 2 * ((ma + oa) * ea + oa * sa + (2 * fa + ua) * ua)
        self.errors[:, at] += 2 * size_c * ((mb + ob) * eb + ob * sb + (2 * fb + ub) * ub)
        self.errors[:, at] += off * (4 * mn + 2 * fn**2 + 2 * (mb * sb + fb**2))

    def _forms(self, parts: Parts, rows: NDArray[np.intp]) -> tuple[Array, Array, Array]:
        """Return values, gradients and Hessian matrices of A and B."""
        chord = self._chord
        whole = (chord.value, chord.gradient, parts.quadrics)
        a, b, c = (np.moveaxis(array[:, rows], 2, 0) for array in whole)
        return a, b, c

    def _bounds(self, rows: NDArray[np.intp]) -> tuple[Array, Array, Array]:
        """Return bounds of second derivatives, gradients and values of A and B."""
        chord = self._chord
        a, b, c = (
            np.moveaxis(array[:, rows], 2, 0) for array in (chord.spectral, chord.first, chord.most)
        )
        return a, b, c

    def _left_out(self, parts: Parts, rows: NDArray[np.intp]) -> tuple[Array, Array, Array]:
        """Return bounds of the remainders of the second derivatives."""
        chord = self._chord
        whole = (parts.errors, chord.slope_off, chord.off)
        a, b, c = (np.moveaxis(array[:, rows], 2, 0) for array in whole)
        return a, b, c

    def _add(self, rows: NDArray[np.intp], terms: Array) -> None:
        self.values[:, rows, : terms.shape[2]] += terms


#: The Hessian matrix of N, as a polynomial.
_TURNING = np.diag([2.0] * 4 + [0.0] * 4)[None]


def _scaled(a: Array, matrices: Array) -> Array:
    """Return products of polynomials and matrices of polynomials, (..., p) and (..., q, 8, 8)."""
    shape = np.broadcast_shapes(a.shape[:-1], matrices.shape[:-3])
    product = np.zeros((*shape, a.shape[-1] + matrices.shape[-3] - 1, 8, 8))
    for j in range(a.shape[-1]):
        product[..., j : j + matrices.shape[-3], :, :] += a[..., j, None, None, None] * matrices
    return product


def _outer(g: Array, h: Array) -> Array:
    """Return products of vectors of polynomials, (..., p, 8) and (..., q, 8)."""
    shape = np.broadcast_shapes(g.shape[:-2], h.shape[:-2])
    product = np.zeros((*shape, g.shape[-2] + h.shape[-2] - 1, 8, 8))
    for j in range(g.shape[-2]):
        product[..., j : j + h.shape[-2], :, :] += g[..., j, None, :, None] * h[..., None, :]
    return product
