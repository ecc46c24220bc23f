"""Proved enclosures of a pose when its values change within a box.

Let z be a Study point of a pose at values v. Let Y be an approximate inverse of the Jacobian matrix
at z, with the row z for the patch. Let every value change by at most a width. As in
native/segment_proof.hpp, with

    |Y F(z, w)| <= beta,  |1 - Y F'(z, w)| <= q  for all values w in the box,
    |Y (F'(x, w) - F'(y, w))| <= kappa |x - y|  within some reach of z,

there is for all w exactly one solution within r, the smaller root of
``kappa r^2 / 2 - (1 - q) r + beta``, if ``q + sqrt(2 kappa beta) < 1``, and it is not singular. So
the box holds no singularity of the mode.

The theorem holds in any norm. Near a singularity z moves mainly along the first singular vector of
Y, and the second derivative along it decides. So several norms are tried, which weigh the
components of z along the singular vectors by ``(s_1 / s_k)^a``. A ball in such a norm is within the
ball of the Euclidean norm.

Errors of rounding are bounded as in native/segment_proof.hpp, with twice the constants.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.parametric_quadrics import Shape, ValueFunction
from gspcli.motion.following.branch_follower import MovingPlatform
from gspcli.records import dataclass
from gspcli.ties import definite_pairs

Array = NDArray[np.float64]

#: Distances from z within which second derivatives are bounded; z has norm one. The best is taken.
REACHES = (0.125, 0.03, 0.008, 0.002, 0.0005)
#: The exponents a of the norms. The best is taken, too.
EXPONENTS = (0.0, 0.3, 0.5, 0.7, 0.85, 1.0)
_ROUNDING = 2.0**-45
_OUTWARD = 1 + 2.0**-30
#: Relative error of computed singular vectors and of products with them.
_BASIS = 2.0**-46


def corners(count: int) -> Array:
    """Return all combinations of signs up to a common one: corners of a box, (2^(count-1), count).

    There is one, without columns, if the count is zero.
    """
    return np.array(
        [(1, *rest)[:count] for rest in product((1, -1), repeat=max(count - 1, 0))], float
    )


SIGNS = corners(6)


@dataclass(frozen=True, eq=False)
class Box:
    """Bounds of n poses when their values change within a box.

    Attributes
    ----------
    measure
        ``q + sqrt(2 kappa beta)``, shape (n,); infinite if it is not below one. If it is finite,
        all numbers here are proved.
    q, root
        Its two terms with the least kappa, also without a proof, shape (n,).
    radius
        A bound of the distance of the solutions from z, shape (n,).
    shifts
        To first order, the change of z when a value changes by its width, shape (n, 6, 8).
    rest
        A bound of the distance of the solutions from that first-order change, shape (n,).
    """

    measure: Array
    q: Array
    root: Array
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
        #: Derivatives of the seven equations, shape (n, 7, 8).
        self.jacobian = platform.jacobian(points, values)
        square = np.concatenate((self.jacobian, points[:, None]), axis=1)
        # Nothing is proved about a singular matrix.
        with np.errstate(all="ignore"):
            regular = np.abs(np.linalg.det(square)) > 0
        safe = np.where(regular[:, None, None], square, np.eye(8))
        whole = np.linalg.inv(safe)
        #: Approximate inverses without the column of the patch, shape (n, 8, 7).
        self.inverse = whole[:, :, :7]
        defect = np.linalg.norm(whole @ safe - np.eye(8), axis=(1, 2))
        self.defect = np.where(regular, defect, np.inf)
        self._jets()

    def _jets(self) -> None:
        """Prepare the quadrics at the points, with their gradients and sizes."""
        equations, z = self.platform.equations, self.points
        gradients = np.einsum("kqij,nj->nkqi", equations.hessians, z)
        quadrics = np.einsum("nkqi,ni->nkq", gradients, z) / 2
        self._a, self._b = quadrics[..., 0], quadrics[..., 1]
        self._ga, self._gb = gradients[:, :, 0], gradients[:, :, 1]
        e = np.concatenate((z[:, :4], np.zeros_like(z[:, :4])), axis=1)
        self._n, self._gn = np.sum(e * e, axis=1)[:, None], 2 * e[:, None]
        n, gn = self._n, np.broadcast_to(self._gn, self._ga.shape)
        form = equations.shapes
        #: The factor of c in the equations, and its gradient.
        self.factors = np.select(
            [form == Shape.PLAIN, form == Shape.PRODUCT],
            [np.broadcast_to(n, self._a.shape), np.broadcast_to(n**2, self._a.shape)],
            n**2 - self._b**2,
        )
        slope = form[:, None]
        self.factor_gradients = np.select(
            [slope == Shape.PLAIN, slope == Shape.PRODUCT],
            [gn, 2 * n[..., None] * gn],
            2 * (n[..., None] * gn - self._b[..., None] * self._gb),
        )
        self.hessians = self._second_derivatives()

    def _second_derivatives(self) -> Array:
        """Return the matrices of the Study condition and the six equations, (n, 7, 8, 8)."""
        equations = self.platform.equations
        turning = np.diag([2.0] * 4 + [0.0] * 4)
        c = self.platform.coefficients(self.values)[..., None, None]
        n, a, b = (x[..., None, None] for x in (self._n, self._a, self._b))
        ga, gb, gn = self._ga, self._gb, np.broadcast_to(self._gn, self._ga.shape)
        ha, hb = equations.hessians[:, 0], equations.hessians[:, 1]
        plain = ha - c * turning
        moved = ga - c[..., 0] * gn
        squared_b = 2 * (b * hb + _outer(gb, gb))
        product = (a - c * n) * turning + n * plain + 2 * _outer(gn, moved) - squared_b
        square_n = 2 * (n * turning + _outer(gn, gn))
        lines = 2 * (a * ha + _outer(ga, ga)) - c * (square_n - squared_b)
        form = equations.shapes[:, None, None]
        every = np.select([form == Shape.PLAIN, form == Shape.PRODUCT], [plain, product], lines)
        study = np.broadcast_to(np.roll(np.eye(8), 4, axis=0), (len(every), 1, 8, 8))
        return np.concatenate((study, every), axis=1)

    def _changes(self, widths: Array) -> tuple[Array, Array]:
        """Return first-order and whole changes of c by a width, shape (n, 6) each."""
        equations, v = self.platform.equations, self.values
        laws = equations.laws
        angle = np.isin(laws, (ValueFunction.COSINE, ValueFunction.SINE))
        first = self.platform.slopes(v) * widths
        second = np.select([laws == ValueFunction.SQUARE, angle], [widths**2, widths**2 / 2], 0.0)
        return first, np.abs(first) + second

    def box(self, widths: Array) -> Box:
        """Return the bounds when each value changes by at most a width.

        Parameters
        ----------
        widths
            Internal units, shape (6,) or (n, 6).
        """
        widths = np.broadcast_to(widths, self.values.shape)
        first, whole = self._changes(widths)
        largest = np.abs(self.platform.coefficients(self.values)) + whole
        errors, gradient_errors = self._errors(largest)
        residual = np.abs(self.residuals()) + errors
        spreads = [(reach, self._spread(whole, largest, reach, widths)) for reach in REACHES]
        count = len(self.points)
        best = {name: np.full(count, np.inf) for name in ("measure", "radius", "rest", "root", "q")}
        left, scales, right = np.linalg.svd(self.inverse, full_matrices=False)
        left, right = definite_pairs(left, scales, right)
        for exponent in EXPONENTS:
            # Without an inverse there is no proof in any norm.
            weights = (scales[:, :1] / np.where(scales > 0, scales, scales[:, :1])) ** exponent
            norm = Norm(left, weights, self.inverse)
            slopes = self._gradients(norm, whole, widths)
            found = self._in_norm(
                norm, first, whole, residual, gradient_errors, slopes, right, spreads
            )
            better = found["root"] + found["q"] < best["root"] + best["q"]
            better |= found["measure"] < best["measure"]
            better &= found["measure"] <= best["measure"]
            best = {name: np.where(better, found[name], best[name]) for name in best}
        shifts = np.einsum("nik,nk->nki", self.inverse[:, :, 1:], first * self.factors)
        return Box(shifts=shifts, **best)

    @property
    def plain(self) -> NDArray[np.bool_]:
        """Which equations change by c N only, so that all their gradients change alike, (6,)."""
        return np.asarray(self.platform.equations.shapes == Shape.PLAIN)

    def _gradients(self, norm: Norm, whole: Array, widths: Array) -> Array:
        """Bound the changes of the gradients in a norm, in parts of ``whole``, shape (n, 6)."""
        return norm.slopes(self.factor_gradients)

    def _in_norm(
        self,
        norm: Norm,
        first: Array,
        whole: Array,
        residual: Array,
        gradient_errors: Array,
        slopes: Array,
        right: Array,
        spreads: list[tuple[float, Array]],
    ) -> dict[str, Array]:
        """Return the numbers of `Box` in one norm, for the best reach."""
        plain, sizes = self.plain, norm.sizes
        amounts = whole * np.abs(self.factors)
        # The largest of a convex function over a box is at a corner.
        beta = norm.corners(amounts) + (sizes * residual).sum(axis=1) + norm.weight * _ROUNDING
        q = norm.corners(np.where(plain, whole, 0.0)) * norm.slopes(self._gn)[:, 0]
        q += (sizes[:, 1:] * whole * np.where(plain, 0.0, slopes)).sum(axis=1)
        q += norm.weight * self.defect + (sizes * gradient_errors).sum(axis=1)
        beta, q = beta * _OUTWARD, q * _OUTWARD + 2.0**-40
        flat = norm.flattened(self.hessians)
        combined = np.einsum("nrk,nkij->nrij", right, flat)
        # Poses beyond the range of doubles have no clearance.
        known = np.isfinite(combined).all(axis=(1, 2, 3))
        combined[~known], beta = 0.0, np.where(known, beta, np.inf)
        norms = (
            np.abs(np.linalg.eigvalsh(combined)).max(axis=2)
            + _BASIS * np.abs(flat).sum(axis=(1, 2, 3))[:, None]
        )
        along = np.linalg.norm(norm.stretched * norms, axis=1)
        found = {name: np.full(len(q), np.inf) for name in ("measure", "radius", "rest", "root")}
        beyond = (sizes[:, 1:] * (whole - np.abs(first)) * np.abs(self.factors)).sum(axis=1)
        beyond += (sizes * residual).sum(axis=1)
        for reach, spread in spreads:
            kappa = (along + (sizes * spread).sum(axis=1)) * _OUTWARD
            measure, radius = self._contraction(beta, q, kappa, reach)
            with np.errstate(invalid="ignore", over="ignore"):
                rest = (beyond + q * radius + kappa * radius**2 / 2) * _OUTWARD
                root = np.sqrt(2 * kappa * beta)
            better = measure < found["measure"]
            for name, new in (("measure", measure), ("radius", radius), ("rest", rest)):
                found[name] = np.where(better, new, found[name])
            found["root"] = np.minimum(found["root"], root)
        return found | {"q": q}

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

    def residuals(self) -> Array:
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
        """Bound the rounding of the equations and of their gradients, (n, 7) each."""
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

    def _spread(self, whole: Array, largest: Array, reach: float, widths: Array) -> Array:
        """Bound the difference of second derivatives from those at the points, shape (n, 7).

        The bound holds for all values within reach and uses the third derivatives.
        """
        equations = self.platform.equations
        form = equations.shapes
        sa, sb = equations.spectral[:, 0], equations.spectral[:, 1]
        first_n = 2 * (np.sqrt(self._n) + reach)
        first_a = np.linalg.norm(self._ga, axis=2) + sa * reach
        first_b = np.linalg.norm(self._gb, axis=2) + sb * reach
        value_b = np.abs(self._b) + first_b * reach
        square_n = 3 * first_n**2
        square_b = 2 * (value_b * sb + first_b**2)
        # Third derivatives of N (A - c N) - B^2 and of A^2 - c (N^2 - B^2).
        product = 3 * (2 * (first_a + largest * first_n) + (sa + 2 * largest) * first_n)
        product = (product + 6 * sb * first_b) * reach + whole * square_n
        lines = 6 * sa * first_a + largest * (12 * first_n + 6 * sb * first_b)
        lines = lines * reach + whole * (square_n + square_b)
        plain = np.broadcast_to(2 * whole, product.shape)
        every = np.select([form == Shape.PLAIN, form == Shape.PRODUCT], [plain, product], lines)
        rounding = 2.0**-40 * (1 + equations.moduli.sum(axis=1) ** 2 + 8 * largest)
        return np.concatenate((np.zeros_like(every[:, :1]), every + rounding), axis=1)


class Norm:
    """The norm of w U^T x, for x orthogonal to the point, and matrices in it.

    Parameters
    ----------
    left
        U, singular vectors, shape (n, 8, 7).
    weights
        w, at least one, shape (n, 7).
    inverse
        Y, shape (n, 8, 7).
    """

    def __init__(self, left: Array, weights: Array, inverse: Array) -> None:
        self.basis = left / weights[:, None]
        self.weight = weights.max(axis=1)
        self.inverse = np.einsum("nir,nik->nrk", left, inverse) * weights[..., None]
        error = _BASIS * self.weight[:, None] * np.linalg.norm(inverse, axis=1)
        #: Not below the norms of the columns of Y, shape (n, 7).
        self.sizes = np.linalg.norm(self.inverse, axis=1) + error
        self._error = error
        #: Not below the singular values times their weights, shape (n, 7).
        self.stretched = np.linalg.norm(self.inverse, axis=2) + error.sum(axis=1, keepdims=True)

    def corners(self, amounts: Array) -> Array:
        """Bound the norms of Y times all vectors within amounts, shape (n,)."""
        moved = np.einsum("nrk,nk,sk->nsr", self.inverse[:, :, 1:], amounts, SIGNS)
        error = (self._error[:, 1:] * amounts).sum(axis=1)
        bound: Array = np.linalg.norm(moved, axis=2).max(axis=1) + error
        return bound

    def slopes(self, gradients: Array) -> Array:
        """Bound the norms of linear functions, ``(n, k, 8) -> (n, k)``."""
        bound = np.linalg.norm(np.einsum("nki,nir->nkr", gradients, self.basis), axis=2)
        return np.asarray(bound + _BASIS * np.linalg.norm(gradients, axis=2))

    def flattened(self, hessians: Array) -> Array:
        """Return quadratic functions in the coordinates of the norm, (n, 7, 7, 7)."""
        return np.asarray(
            np.einsum("nir,nkij,njs->nkrs", self.basis, hessians, self.basis, optimize=True)
        )


def _outer(a: Array, b: Array) -> Array:
    """Return the symmetric part of ``a b^T``."""
    product_ = a[..., :, None] * b[..., None, :]
    symmetric: Array = (product_ + np.swapaxes(product_, -1, -2)) / 2
    return symmetric
