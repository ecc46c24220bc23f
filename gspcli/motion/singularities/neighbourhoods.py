"""Proved enclosures of a pose when its values or its drives change within a box.

Let z be a Study point of a pose at values v. Let Y be an approximate inverse of the Jacobian matrix
at z, with the row z for the patch z . x = z . z. Let every value change by at most a width. As in
native/segment_proof.hpp, with

    |Y F(z, w)| <= beta,  |1 - Y F'(z, w)| <= q  for all values w in the box,
    |Y (F'(x, w) - F'(y, w))| <= kappa |x - y|  within some reach of z,

there is for all w exactly one solution within r, the smaller root of
``kappa r^2 / 2 - (1 - q) r + beta``, if ``q + sqrt(2 kappa beta) < 1``, by the theorem of
Newton and Kantorovich, and it is not singular. So the box holds no singularity of the mode.

The theorem holds in any norm. Near a singularity z moves mainly along the first singular vector of
Y, and the second derivative along it decides. So several norms are tried, which weigh the
components of z along the singular vectors by ``(s_1 / s_k)^a``. A ball in such a norm is within the
ball of the Euclidean norm.

The equations, with their derivatives, are plain formulas over enclosures of quadrics. At z their
radii are errors of rounding; over the ball of a reach those of second derivatives are what they
change by.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.parametric_quadrics import (
    Shape,
    ValueFunction,
    moved_height,
    moved_quadric,
)
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.enclosures import (
    Enclosure,
    Jet,
    Matrix,
    above,
    below,
    roundings,
    size,
    spectral_norm,
)
from gspcli.geometry.machine import Machine
from gspcli.motion.following.branch_follower import MovingPlatform, apart
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.records import dataclass
from gspcli.ties import definite_pairs

Array = NDArray[np.float64]

#: Distances from z within which second derivatives are bounded; z has norm one. The best is taken.
REACHES = (0.125, 0.03, 0.008, 0.002, 0.0005)
#: The exponents a of the norms. The best is taken, too.
EXPONENTS = (0.0, 0.3, 0.5, 0.7, 0.85, 1.0)
#: The quadrics of N = e . e and of the Study condition e . f.
_TURNING = Matrix.exact(np.diag([2.0] * 4 + [0.0] * 4))
STUDY = Matrix.exact(np.roll(np.eye(8), 4, axis=0))
#: Relative error of computed singular vectors and of products with them.
_BASIS: float = roundings(4, 1)
#: The Kantorovich number is at most one less this; so the radius errs by less than a tenth of it.
_MARGIN = 1e-7


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
    """Bounds of n poses when their values change within a box."""

    #: ``q + sqrt(2 kappa beta)``, shape (n,); infinite if it is not below one. If it is finite, all
    #: numbers here are proved.
    measure: Array
    #: Its two terms with the least kappa, also without a proof, shape (n,).
    q: Array
    root: Array
    #: A bound of the distance of the solutions from z, shape (n,).
    radius: Array
    #: To first order, the change of z when a value changes by its width, shape (n, 6, 8).
    shifts: Array
    #: A bound of the distance of the solutions from that first-order change, shape (n,).
    rest: Array

    @property
    def change(self) -> Enclosure:
        """The change of z: its parameters are the changes of the values, in widths, (n, 1, 8)."""
        shifts = np.swapaxes(self.shifts, 1, 2)[:, None]
        return Enclosure(np.zeros((len(shifts), 1, 8)), self.rest[:, None], shifts)


def equations(
    platform: MovingPlatform, x: Any, c: Enclosure, jet: Any = Jet
) -> Iterator[tuple[NDArray[np.intp], Any, Any]]:
    """Yield rows of the six equations, their equations, and the factors of their coefficients.

    Parameters
    ----------
    platform
        The equations.
    x
        Points, shape (n, 1, 8).
    c
        Their coefficients, shape (n, 6, 1).
    jet
        The class of functions with their derivatives, and points that it takes.
    """
    given = platform.equations
    # Entries of the quadrics are rounded.
    rough = roundings(1, given.moduli)
    n = jet.quadric(_TURNING, x)
    for shape in np.unique(given.shapes):
        rows = np.flatnonzero(given.shapes == shape)
        parts = (
            Matrix(given.hessians[rows, i], rough[rows, i], given.spectral[rows, i])
            for i in range(2)
        )
        moving = c.take(slice(None), rows)
        a = jet.quadric(next(parts), x)
        if shape == Shape.PLAIN:
            yield rows, a - n.times(moving), n
            continue
        b = jet.quadric(next(parts), x)
        if shape == Shape.PRODUCT:
            yield rows, n * (a - n.times(moving)) - b * b, n * n
        else:
            factor = n * n - b * b
            yield rows, a * a - factor.times(moving), factor


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
        self.platform, self.points, self.values = platform, points, values
        laws = platform.equations.laws
        self._angles = np.isin(laws, (ValueFunction.COSINE, ValueFunction.SINE))
        count, x = len(points), Enclosure(points[:, None])
        #: The seven equations, the Study condition first: values (n, 7), derivatives (n, 7, 8) and
        #: second ones (n, 7, 8, 8); and bounds of the rounding of the first two, shape (n, 7).
        self.residuals, self.errors = np.zeros((2, count, 7))
        self.jacobian, self.gradient_errors = np.zeros((count, 7, 8)), np.zeros((count, 7))
        self.hessians = np.zeros((count, 7, 8, 8))
        #: The factors of c, shape (n, 6), and their gradients, shape (n, 6, 8); and their rounding.
        self.factors, self.factor_errors = np.zeros((2, count, 6))
        self.factor_gradients, self.slope_errors = np.zeros((count, 6, 8)), np.zeros((count, 6))
        self._put(np.zeros(1, int), Jet.quadric(STUDY, x))
        for rows, found, factor in equations(platform, x, self._coefficients()):
            self._put(rows + 1, found)
            self.factors[:, rows] = factor.value.mid[..., 0]
            self.factor_errors[:, rows] = factor.value.rad
            self.factor_gradients[:, rows] = factor.gradient.mid
            self.slope_errors[:, rows] = factor.gradient.rad
        square = np.concatenate((self.jacobian, points[:, None]), axis=1)
        # Nothing is proved about a singular matrix.
        with np.errstate(all="ignore"):
            regular = np.abs(np.linalg.det(square)) > 0
        safe = np.where(regular[:, None, None], square, np.eye(8))
        whole = np.linalg.inv(safe)
        #: Approximate inverses without the column of the patch, shape (n, 8, 7).
        self.inverse = whole[:, :, :7]
        defect = np.linalg.norm(whole @ safe - np.eye(8), axis=(1, 2))
        # The rounding of the products with the rows of F' is added in `box`.
        self.defect = np.where(regular, above(defect) + roundings(1, size(whole[:, :, 7])), np.inf)
        self._turning = 2 * np.concatenate((points[:, :4], 0 * points[:, 4:]), axis=1)

    def _put(self, rows: NDArray[np.intp], found: Jet) -> None:
        self.residuals[:, rows] = found.value.mid[..., 0]
        self.errors[:, rows] = found.value.rad
        self.jacobian[:, rows], self.gradient_errors[:, rows] = (
            found.gradient.mid,
            found.gradient.rad,
        )
        self.hessians[:, rows] = found.bend.mid

    def _coefficients(self, whole: Array | float = 0.0) -> Enclosure:
        """Enclose c of the equations for all values in a box, numbers, shape (n, 6, 1)."""
        c = self.platform.coefficients(self.values)
        # Of a cosine near zero the angle is rounded.
        return Enclosure.rounded(c[..., None], self._angles.astype(float)).widened(whole)

    def _changes(self, widths: Array) -> tuple[Array, Array]:
        """Return first-order and whole changes of c by a width, shape (n, 6) each."""
        laws, angle = self.platform.equations.laws, self._angles
        first = self.platform.slopes(self.values) * widths
        second = np.select([laws == ValueFunction.SQUARE, angle], [widths**2, widths**2 / 2], 0.0)
        # The slope of a cosine errs as the angle does.
        return first, above(np.abs(first) + second + np.where(angle, roundings(1, widths), 0.0))

    def _spreads(self, whole: Array, widths: Array) -> Array:
        """Bound changes of second derivatives within `REACHES`, for all values, (reaches, n, 7)."""
        del widths
        reaches = np.array(REACHES)[:, None, None]
        x = Enclosure(self.points[:, None], reaches)
        found = np.zeros((len(reaches), len(self.points), 7))
        for rows, moved, _ in equations(self.platform, x, self._coefficients(whole)):
            found[..., rows + 1] = moved.bend.rad
        return found

    def widths(self, widths: Array) -> Array:
        """Return widths of the equations for lengths and radians by constraint, shape (6,)."""
        return np.asarray(widths * np.where(self._angles, 1.0, 1 / self.platform.scale))

    def keeps_working_modes(self, widths: Array, box: Box) -> NDArray[np.bool_]:
        """Return whether all drives are proved to keep their working modes in boxes, shape (n,).

        Parameters
        ----------
        widths
            Of the equations, shape (n, 6).
        box
            What `box` returns for them.
        """
        del widths
        return np.asarray(box.measure < 1)

    def box(self, widths: Array) -> Box:
        """Return the bounds when each value changes by at most a width.

        Parameters
        ----------
        widths
            Internal units, shape (6,) or (n, 6).
        """
        widths = np.broadcast_to(widths, self.values.shape)
        first, whole = self._changes(widths)
        errors = self.gradient_errors + roundings(1, size(self.jacobian))
        errors[:, 1:] += whole * self.slope_errors
        residual = above(np.abs(self.residuals) + self.errors)
        given = _Given(first, whole, widths, residual, errors, self._spreads(whole, widths))
        names = ("measure", "radius", "rest", "root", "q")
        best = {name: np.full(len(self.points), np.inf) for name in names}
        for norm, along in self._norms:
            found = self._in_norm(norm, along, given)
            better = found["root"] + found["q"] < best["root"] + best["q"]
            better |= found["measure"] < best["measure"]
            better &= found["measure"] <= best["measure"]
            best = {name: np.where(better, found[name], best[name]) for name in best}
        shifts = np.einsum("nik,nk->nki", self.inverse[:, :, 1:], first * self.factors)
        return Box(shifts=shifts, **best)

    @cached_property
    def _norms(self) -> list[tuple[Norm, Array]]:
        """The norms, and bounds of second derivatives at the points in each, shape (n,)."""
        left, scales, right = np.linalg.svd(self.inverse, full_matrices=False)
        left, right = definite_pairs(left, scales, right)
        norms = []
        for exponent in EXPONENTS:
            # Without an inverse there is no proof in any norm.
            weights = (scales[:, :1] / np.where(scales > 0, scales, scales[:, :1])) ** exponent
            norm = Norm(left, weights, self.inverse)
            flat = norm.flattened(self.hessians)
            combined = np.einsum("nrk,nkij->nrij", right, flat)
            # Poses beyond the range of doubles have no clearance.
            known = np.isfinite(combined).all(axis=(1, 2, 3))
            combined[~known] = 0.0
            bounds = spectral_norm(combined) + _BASIS * np.abs(flat).sum(axis=(1, 2, 3))[:, None]
            along = np.linalg.norm(norm.stretched * bounds, axis=1)
            norms.append((norm, np.where(known, along, np.inf)))
        return norms

    @property
    def plain(self) -> NDArray[np.bool_]:
        """Which equations change by c N only, so that all their gradients change alike, (6,)."""
        return np.asarray(self.platform.equations.shapes == Shape.PLAIN)

    def _gradients(self, norm: Norm, whole: Array, widths: Array) -> Array:
        """Bound the changes of the gradients in a norm, in parts of ``whole``, shape (n, 6)."""
        del whole, widths
        return norm.slopes(self.factor_gradients)

    def _in_norm(self, norm: Norm, along: Array, given: _Given) -> dict[str, Array]:
        """Return the numbers of `Box` in one norm, for the best reach."""
        plain, sizes, whole = self.plain, norm.sizes, given.whole
        factors = np.abs(self.factors) + self.factor_errors
        # The largest of a convex function over a box is at a corner.
        beta = norm.corners(whole * factors) + (sizes * given.residual).sum(axis=1)
        slopes = self._gradients(norm, whole, given.widths)
        q = norm.corners(np.where(plain, whole, 0.0)) * norm.slopes(self._turning[:, None])[:, 0]
        q += (sizes[:, 1:] * whole * np.where(plain, 0.0, slopes)).sum(axis=1)
        q += norm.weight * self.defect + (sizes * given.gradient_errors).sum(axis=1)
        beta, q = np.where(np.isfinite(along), above(beta), np.inf), above(q)
        found = {name: np.full(len(q), np.inf) for name in ("measure", "radius", "rest", "root")}
        beyond = (sizes[:, 1:] * (whole - np.abs(given.first)) * factors).sum(axis=1)
        beyond += (sizes * given.residual).sum(axis=1)
        for reach, spread in zip(REACHES, given.spreads, strict=True):
            kappa = above(along + (sizes * spread).sum(axis=1))
            measure, radius = self._contraction(beta, q, kappa, reach)
            with np.errstate(invalid="ignore", over="ignore"):
                rest = above(beyond + q * radius + kappa * radius**2 / 2)
                root = np.sqrt(2 * kappa * beta)
            better = measure < found["measure"]
            for name, new in (("measure", measure), ("radius", radius), ("rest", rest)):
                found[name] = np.where(better, new, found[name])
            found["root"] = np.minimum(found["root"], root)
        return found | {"q": q}

    def _contraction(
        self, beta: Array, q: Array, kappa: Array, reach: float
    ) -> tuple[Array, Array]:
        """Return the Kantorovich number, infinite without a proof, and the radius, (n,) each."""
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            measure = above(q + np.sqrt(2 * kappa * beta))
            left = 1 - q
            radius = 2 * beta / (left + np.sqrt(np.maximum(left**2 - 2 * kappa * beta, 0.0)))
            radius = radius * (1 + _MARGIN)
            still = np.linalg.norm(self.points[:, :4], axis=1)
            proved = (measure < 1 - _MARGIN) & (radius < reach) & (radius < below(still))
        return np.where(proved, measure, np.inf), radius


class _Given(NamedTuple):
    """What all norms use, for some widths of the values."""

    first: Array
    whole: Array
    widths: Array
    residual: Array
    gradient_errors: Array
    spreads: Array


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
        self.sizes = above(np.linalg.norm(self.inverse, axis=1) + error)
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


class MachineNeighbourhood(Neighbourhood):
    """The equations near one pose, with the drives that its poses have: cranks and slides.

    Of a constraint with a crank or a slide the quadric moves, and its value does not: when its
    drive has moved by t,

        H(t) = H + H' sin t + H'' (1 - cos t)   of a crank,   H + H' t + H'' t^2 / 2   of a slide

    with constant matrices, so that |t| <= d changes a value of the quadric by at most
    ``|F'| d + |F''| d^2 / 2``, and its derivatives in the same way. The equation depends on its own
    drive only. The gain of the drive is proportional to ``z . H'(t) z``. The drive keeps its
    working mode if that keeps its sign for all numbers in the box and all z near the pose, within
    the bound of where the solutions are.

    Parameters
    ----------
    drives
        The drives.
    R, T
        The pose, shapes (3, 3) and (3,).
    q
        The numbers of the drives there, shape (m,).
    """

    def __init__(self, drives: Machine, R: Array, T: Array, q: Array) -> None:
        placed = apart(drives.instance_at(q))
        platform = MovingPlatform(placed)
        self.driven = drives.driven
        cranks = np.array([drives.sorts[k] == "crank" for k in drives.index])
        self._cranks = cranks & self.driven
        #: H' and H'' of the driven constraints, shapes (6, 8, 8); zero for the others.
        self.first, self.second = _derivatives(drives, platform, q)
        values = platform.internal(values_at(placed, R[None], T[None]))
        super().__init__(platform, platform.points(R[None], T[None]), values)
        # Points of cranks and slides are rounded, and what follows from them.
        rough = roundings(8, np.where(self.driven, platform.equations.moduli[:, 0], 0.0))
        self._matrices = [Matrix.exact(part, rough) for part in (self.first, self.second)]
        x = Enclosure(self.points[:, None])
        self._moves = [Jet.quadric(part, x) for part in self._matrices]
        self._rates = self._moves[0].value.mid[..., 0]

    @property
    def plain(self) -> NDArray[np.bool_]:
        """Which constraints change by c N only, shape (6,)."""
        return super().plain & ~self.driven

    def _changes(self, widths: Array) -> tuple[Array, Array]:
        first, whole = super()._changes(widths)
        # As changes of c, which the factors N turn into those of the equations.
        least = below(self.factors - self.factor_errors)
        moved = np.abs(self._rates) * widths / self.factors
        rate, bend = (one.value.most for one in self._moves)
        every = (rate * widths + bend * widths**2 / 2) / np.where(self.driven, least, 1.0)
        return np.where(self.driven, moved, first), np.where(self.driven, above(every), whole)

    def _gradients(self, norm: Norm, whole: Array, widths: Array) -> Array:
        others = super()._gradients(norm, whole, widths)
        pull, bend = (norm.slopes(one.gradient.mid) + one.gradient.rad for one in self._moves)
        # At a dead point, where the residual does not change, there is no proof: NaN.
        with np.errstate(invalid="ignore", divide="ignore"):
            moved = (pull * widths + bend * widths**2 / 2) / whole
            return np.where(self.driven, moved, others)

    def _spreads(self, whole: Array, widths: Array) -> Array:
        found = super()._spreads(np.where(self.driven, 0.0, whole), widths)
        first, second = (part.most for part in self._matrices)
        moved = above(first * widths + second * widths**2 / 2)
        found[..., 1:] += np.where(self.driven, moved, 0.0)
        return found

    def widths(self, widths: Array) -> Array:
        """Return widths of the equations for lengths and radians by constraint, shape (6,)."""
        return np.where(self._cranks, widths, super().widths(widths))

    def keeps_working_modes(self, widths: Array, box: Box) -> NDArray[np.bool_]:
        """Return whether it is proved, of the one pose, shape (1,)."""
        proved = box.measure < 1
        if not proved.any():
            return np.asarray(proved)
        kept = (self.gains(widths, box).least > 0) | ~self.driven
        return np.asarray(kept.all(axis=1) & proved)

    def gains(self, widths: Array, box: Box) -> Enclosure:
        """Enclose what is proportional to the gains in a proved box: numbers, shape (1, 6, 1).

        The parameters are those of the first-order changes of the solution, ``box.shifts``.
        """
        change = box.change
        square = box.radius[:, None] ** 2
        first, second = (
            (jet.value + jet.gradient.dot(change)).widened(matrix.most * square / 2)
            for jet, matrix in zip(self._moves, self._matrices, strict=True)
        )
        one, d = np.ones_like(widths), np.asarray(widths, float)
        cosine = Enclosure.between(np.where(self._cranks, 1 - d**2 / 2, one), one)
        return first * cosine + second * Enclosure(np.zeros((*d.shape, 1)), d)


def neighbourhoods(
    machine: Machine, R: Array, T: Array, q: Array
) -> Iterator[tuple[slice, Neighbourhood]]:
    """Yield which of n poses, and the equations near them; q has shape (n, m).

    All are together if only values change; cranks and slides have another geometry at each pose.
    """
    if machine.moves:
        for k in range(len(T)):
            yield slice(k, k + 1), MachineNeighbourhood(machine, R[k], T[k], q[k])
    elif len(T):
        platform = MovingPlatform(apart(machine.instance))
        values = platform.internal(values_at(machine.instance, R, T))
        yield slice(None), Neighbourhood(platform, platform.points(R, T), values)


def _derivatives(drives: Machine, platform: MovingPlatform, q: Array) -> tuple[Array, Array]:
    """Return the first and second derivatives of the quadrics by the numbers of their drives."""
    first, second = np.zeros((2, 6, 8, 8))
    scale = platform.scale
    near = Arrangement.of(platform.local_frames.applied(platform.instance))
    velocity, bend = drives.velocities(q), drives.bends(q)
    for k in np.flatnonzero(drives.driven).tolist():
        y, x = near.y[k] / scale, near.x[k] / scale
        crank = drives.sorts[drives.index[k]] == "crank"
        unit = 1 / scale if crank else 1.0
        v, w = velocity[k] * unit, bend[k] * unit
        on = bool(drives.on_platform[k])
        if drives.planes[k]:
            first[k], second[k] = (
                moved_height(near.v[k], part) if on else moved_height(part, near.u[k])
                for part in (v, w)
            )
            continue
        moving, other = (y, x) if on else (x, y)
        first[k] = moved_quadric(v, other, float(moving @ v), on_platform=on)
        second[k] = moved_quadric(w, other, float(moving @ w + v @ v), on_platform=on)
    return first, second
