"""Where a pose can be when its values change by so much, in any combination: proofs.

Let z be a Study point of a pose at values v, Y an approximate inverse of the Jacobian matrix there
(with the row z for the patch), and let every value change by at most a width. As in
native/tubes.cpp, with

    |Y F(z, w)| <= beta,  |1 - Y F'(z, w)| <= q  for all values w in the box,
    |Y (F'(x, w) - F'(y, w))| <= kappa |x - y|  within some reach of z,

there is for all w exactly one solution within r, the smaller root of
``kappa r^2 / 2 - (1 - q) r + beta``, if ``q + sqrt(2 kappa beta) < 1``, and it is not singular. So
the box holds no singularity of the mode.

Errors of rounding are bounded as there, with twice the constants.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.moving import Law, Shape
from gspcli.motion.following import MovingPlatform

Array = NDArray[np.float64]

#: How far from z second derivatives are bounded; z has norm one. The best of these is taken.
REACHES = (0.125, 0.03, 0.008, 0.002, 0.0005)
_ROUNDING = 2.0**-45
_OUTWARD = 1 + 2.0**-30
#: All combinations of signs up to a common one: the corners of a box, shape (32, 6).
SIGNS = np.array([(1, *rest) for rest in product((1, -1), repeat=5)], float)


@dataclass(frozen=True, eq=False)
class Box:
    """What is known of n poses when their values change within a box.

    Attributes
    ----------
    measure
        ``q + sqrt(2 kappa beta)``, shape (n,): below one, everything else is proved.
    radius
        How far from z the solutions are at most, shape (n,).
    shifts
        To first order, the change of z when a value changes by its width, shape (n, 6, 8).
    rest
        How far the solutions are at most from that first-order change, shape (n,).
    """

    measure: Array
    radius: Array
    shifts: Array
    rest: Array


class Neighbourhood:
    """The equations near n poses.

    Parameters
    ----------
    platform
        The equations.
    points
        Study points of norm one, shape (n, 8).
    values
        Internal values at them, shape (n, 6).
    """

    def __init__(self, platform: MovingPlatform, points: Array, values: Array) -> None:
        self.platform = platform
        self.points = points
        self.values = values
        equations = platform.equations
        jacobian = platform.jacobian(points, values)
        square = np.concatenate((jacobian, points[:, None]), axis=1)
        # A singular matrix gives numbers that prove nothing.
        with np.errstate(all="ignore"):
            regular = np.abs(np.linalg.det(square)) > 0
        safe = np.where(regular[:, None, None], square, np.eye(8))
        #: Approximate inverses without the column of the patch, shape (n, 8, 7).
        self.inverse = np.linalg.inv(safe)[:, :, :7]
        whole = np.linalg.inv(safe)
        self.sizes = np.linalg.norm(self.inverse, axis=1)
        gradients = np.einsum("kqij,nj->nkqi", equations.hessians, points)
        quadrics = np.einsum("nkqi,ni->nkq", gradients, points) / 2
        self._a, self._b = quadrics[..., 0], quadrics[..., 1]
        self._ga, self._gb = gradients[:, :, 0], gradients[:, :, 1]
        e = np.concatenate((points[:, :4], np.zeros_like(points[:, :4])), axis=1)
        self._n, self._gn = np.sum(e * e, axis=1)[:, None], 2 * e[:, None]
        form = equations.shapes
        #: What c multiplies in the equations, and its gradient.
        self.factors = np.select(
            [form == Shape.PLAIN, form == Shape.PRODUCT],
            [np.broadcast_to(self._n, self._a.shape), np.broadcast_to(self._n**2, self._a.shape)],
            self._n**2 - self._b**2,
        )
        slope = form[:, None]
        self.factor_gradients = np.select(
            [slope == Shape.PLAIN, slope == Shape.PRODUCT],
            [
                np.broadcast_to(self._gn, self._ga.shape),
                np.broadcast_to(2 * self._n[..., None] * self._gn, self._ga.shape),
            ],
            2 * (self._n[..., None] * self._gn - self._b[..., None] * self._gb),
        )
        self.defect = np.linalg.norm(whole @ safe - np.eye(8), axis=(1, 2))

    def _changes(self, widths: Array) -> tuple[Array, Array, Array, Array]:
        """Return first-order and whole changes of c by a width, and bounds of c, (n, 6) each."""
        equations, v = self.platform.equations, self.values
        laws = equations.laws
        angle = np.isin(laws, (Law.COSINE, Law.SINE))
        turn = np.where(laws == Law.COSINE, -np.sin(v), np.cos(v)) * equations.signs
        slope = np.select([laws == Law.SQUARE, laws == Law.LINEAR], [2 * v, np.ones_like(v)], turn)
        first = slope * widths
        second = np.select([laws == Law.SQUARE, angle], [widths**2, widths**2 / 2], 0.0)
        whole = np.abs(first) + second
        c = self.platform.coefficients(v)
        return first, whole, c - whole, c + whole

    def box(self, widths: Array) -> Box:
        """Return what is known when each value changes by at most a width.

        Parameters
        ----------
        widths
            Internal units, shape (6,) or (n, 6).
        """
        widths = np.broadcast_to(widths, self.values.shape)
        first, whole, low, high = self._changes(widths)
        equations = self.platform.equations
        largest = np.maximum(np.abs(low), np.abs(high))
        inverse, sizes = self.inverse[:, :, 1:], self.sizes[:, 1:]
        amounts = whole * np.abs(self.factors)
        # The largest of a convex function over a box is at a corner.
        corners = np.einsum("nik,nk,sk->nsi", inverse, amounts, SIGNS)
        beta = np.linalg.norm(corners, axis=2).max(axis=1)
        plain = equations.shapes == Shape.PLAIN
        common = np.einsum("nik,nk,sk->nsi", inverse, np.where(plain, whole, 0.0), SIGNS)
        slopes = np.linalg.norm(self.factor_gradients, axis=2)
        q = np.linalg.norm(common, axis=2).max(axis=1) * 2 * np.sqrt(self._n[:, 0])
        q += (sizes * whole * np.where(plain, 0.0, slopes)).sum(axis=1)
        errors, gradient_errors = self._errors(largest)
        residual = np.abs(self._residuals()) + errors
        beta = beta + (self.sizes * residual).sum(axis=1) + _ROUNDING
        q = q + self.defect + (self.sizes * gradient_errors).sum(axis=1)
        beta, q = beta * _OUTWARD, q * _OUTWARD + 2.0**-40
        measure, radius, kappa = np.full((3, len(beta)), np.inf)
        for reach, bound in self._kappas(low, high, largest):
            found, r = self._contraction(beta, q, bound * _OUTWARD, reach)
            better = found < measure
            measure = np.where(better, found, measure)
            radius = np.where(better, r, radius)
            kappa = np.where(better, bound, kappa)
        shifts = np.einsum("nik,nk->nki", inverse, first * self.factors)
        # What z moves beside the first order: by the second-order part of c, by q and by kappa.
        beyond = (sizes * (whole - np.abs(first)) * np.abs(self.factors)).sum(axis=1)
        with np.errstate(invalid="ignore"):
            rest = beyond + q * radius + kappa * radius**2 / 2
        rest += (self.sizes * residual).sum(axis=1)
        return Box(measure, radius, shifts, rest * _OUTWARD)

    def _contraction(
        self, beta: Array, q: Array, kappa: Array, reach: float
    ) -> tuple[Array, Array]:
        """Return the measure, infinite if there is no proof, and the radius, shape (n,) each."""
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            measure = (q + np.sqrt(2 * kappa * beta)) * _OUTWARD
            left = 1 - q
            radius = 2 * beta / (left + np.sqrt(np.maximum(left**2 - 2 * kappa * beta, 0.0)))
            radius = radius * _OUTWARD
            size = np.sqrt(self._n[:, 0])
            proved = (measure < 1) & (radius < reach) & (radius < size)
        return np.where(proved, measure, np.inf), radius

    def _residuals(self) -> Array:
        """Return the values of the seven equations, shape (n, 7)."""
        form = self.platform.equations.shapes
        c = self.platform.coefficients(self.values)
        plain = self._a - c * self._n
        values = np.select(
            [form == Shape.PLAIN, form == Shape.PRODUCT],
            [plain, self._n * plain - self._b**2],
            self._a**2 - c * (self._n**2 - self._b**2),
        )
        study = np.sum(self.points[:, :4] * self.points[:, 4:], axis=1)
        return np.concatenate((study[:, None], values), axis=1)

    def _errors(self, largest: Array) -> tuple[Array, Array]:
        """Bound what rounding does to the equations and to their gradients, (n, 7) each."""
        equations = self.platform.equations
        a, b = equations.moduli[:, 0] / 2, equations.moduli[:, 1] / 2
        form = equations.shapes
        value = np.select(
            [form == Shape.PLAIN, form == Shape.PRODUCT],
            [a + largest, a + largest + b**2],
            a**2 + largest * (1 + b**2),
        )
        one = np.ones_like(value[:, :1])
        value = np.concatenate((one, value), axis=1) * _ROUNDING
        return value, 4 * value

    def _kappas(self, low: Array, high: Array, largest: Array) -> Iterator[tuple[float, Array]]:
        """Yield bounds of kappa over the values within each reach, shape (n,)."""
        equations = self.platform.equations
        if (equations.shapes == Shape.PLAIN).all():
            yield REACHES[0], self._kappa_of_plain(low, high)
            return
        spectral = np.stack(
            [equations.spectral_between(a, b) for a, b in zip(low, high, strict=True)]
        )
        for reach in REACHES:
            yield reach, self._kappa(spectral, high - low, largest, reach)

    def _kappa(self, spectral: Array, spread: Array, largest: Array, reach: float) -> Array:
        equations = self.platform.equations
        form = equations.shapes
        size_e = np.sqrt(self._n) + reach
        sa, sb = equations.spectral[:, 0], equations.spectral[:, 1]
        ga, gb = np.linalg.norm(self._ga, axis=2), np.linalg.norm(self._gb, axis=2)
        first_a, first_b = ga + sa * reach, gb + sb * reach
        value_a = np.abs(self._a) + first_a * reach
        value_b = np.abs(self._b) + first_b * reach
        first_n, value_n = 2 * size_e, size_e**2
        # Of A - c N: at z, and how far it moves with c and within reach.
        c = self.platform.coefficients(self.values)
        moved = np.linalg.norm(self._ga - c[..., None] * self._gn, axis=2)
        moved_first = moved + spectral * reach + spread * first_n
        moved_value = np.abs(self._a - c * self._n) + spread * value_n + moved_first * reach
        of_b = 2 * (value_b * sb + first_b**2)
        curvature = np.select(
            [form == Shape.PLAIN, form == Shape.PRODUCT],
            [spectral, 2 * moved_value + value_n * spectral + 2 * first_n * moved_first + of_b],
            2 * (value_a * sa + first_a**2) + largest * (4 * value_n + 2 * first_n**2 + of_b),
        )
        kappa: Array = self.sizes[:, 0] + (self.sizes[:, 1:] * curvature).sum(axis=1)
        return kappa

    def _kappa_of_plain(self, low: Array, high: Array) -> Array:
        """Return the same if all equations are quadrics, in the directions of the inverse."""
        equations = self.platform.equations
        turning = np.diag([2.0] * 4 + [0.0] * 4)
        middle, half = (low + high) / 2, (high - low) / 2
        hessians = equations.hessians[None, :, 0] - middle[..., None, None] * turning
        study = np.broadcast_to(np.roll(np.eye(8), 4, axis=0), (len(low), 1, 8, 8))
        hessians = np.concatenate((study, hessians), axis=1)
        _, scales, directions = np.linalg.svd(self.inverse, full_matrices=False)
        combined = np.einsum("nrk,nkij->nrij", directions, hessians)
        norms = np.abs(np.linalg.eigvalsh(combined)).max(axis=2)
        spread = 2 * half + 2.0**-45 * (equations.moduli[:, 0] + np.abs(middle))
        kappa = np.sqrt(np.sum((scales * norms) ** 2, axis=1)) * (1 + 1e-9)
        total: Array = kappa + (self.sizes[:, 1:] * spread).sum(axis=1)
        return total
