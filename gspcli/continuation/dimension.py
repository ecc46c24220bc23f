"""Numerical evidence for or against a positive-dimensional solution set through a point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.systems import System
from gspcli.records import dataclass
from gspcli.ties import definite_basis, definite_sign

#: Below this e.e of a point of norm one is zero up to rounding.
_INFINITE = 1e-14


@dataclass(frozen=True)
class DimensionOptions:
    """Settings of the tests for solution sets of positive dimension."""

    rank: float = 1e-6
    """A singular value of the Jacobian matrix with rows of length 1 below this may be zero. Ends of
    the endgame are known to 1e-8 or so, a small part of which the distance test sorts out."""
    row: float = 1e-8
    """A row shorter than this part of the longest one is rounding, and stays short."""
    distance: float = 0.03
    """How far from a solution, of norm 1, others are sought along the kernel: far enough that an
    isolated solution of moderate multiplicity is left, near enough that a curve is still there."""
    least: float = 0.1
    """Corrected points nearer than this part of the distance have returned to the solution, ..."""
    most: float = 5.0
    """... and those further away than this many distances have gone elsewhere."""
    tries: int = 4
    """Trial directions for each dimension of the kernel, and as many more; a quarter of them must
    arrive."""
    spread: float = 0.15
    """Directions that the arrivals span to less than this part of the main one are its bend."""
    zero: float = 1e-13
    """Length of the values at which a point has been corrected."""
    newton_steps: int = 60
    """Limit of corrections: half the distance each where solutions are multiple."""
    damping: float = 0.01
    """Part of the length of the values that is the damping of Levenberg and Marquardt."""
    difference: float = 1e-4
    """Step of the difference quotient of the Jacobian matrix, linear or quadratic in the point:
    any will do."""
    stride: float = 2.0
    """Length of the steps of a sample motion, in units of the distance; corrected ones may have
    from the least part up to five times that length."""
    finite: float = 1e-6
    """Least N of a real point of norm 1 that is shown to people as a pose."""


DIMENSION = DimensionOptions()


def _scaled_jacobians(
    target: System, points: ComplexArray, options: DimensionOptions
) -> ComplexArray:
    """Return the Jacobian matrices (n, 8, 8) with rows of length 1; the last row is the patch.

    Rows that vanish up to rounding stay small: the gradient of one equation may be zero.
    """
    jacobian = target.jacobians(points)
    rows = jacobian / _row_lengths(jacobian, options)
    return np.concatenate([rows, points.conj()[:, None, :]], axis=1)


def _row_lengths(jacobian: ComplexArray, options: DimensionOptions) -> FloatArray:
    size = np.linalg.norm(jacobian, axis=-1, keepdims=True)
    return np.asarray(np.maximum(size, options.row * size.max(axis=-2, keepdims=True)))


def kernel(
    target: System, point: ComplexArray, options: DimensionOptions = DIMENSION
) -> ComplexArray:
    """Return an orthonormal basis (8, k) of the kernel of the Jacobian matrix at a solution.

    The point itself, which is always in the kernel, is not included.
    """
    rows = _scaled_jacobians(target, point[None], options)[0]
    # A real basis if there is one.
    _, values, basis = np.linalg.svd(rows if rows.imag.any() else rows.real)
    inside = definite_basis(basis[values < options.rank].conj().T)
    return np.asarray(inside, dtype=np.complex128)


def correct(
    target: System, points: ComplexArray, options: DimensionOptions = DIMENSION
) -> tuple[ComplexArray, NDArray[np.bool_]]:
    """Move points (n, 8) of norm 1 to near solutions, singular ones included.

    The Levenberg-Marquardt method with damping proportional to the residual, which converges
    quadratically to solution sets of any dimension if they are smooth and reduced, and linearly
    if they are multiple. Real points stay real if the system is.

    Returns
    -------
    points, converged
        Shapes (n, 8) and (n,).
    """
    points = points.copy()
    values = target.values(points)
    for _ in range(options.newton_steps):
        size = np.linalg.norm(values, axis=1)
        active = np.flatnonzero((size >= options.zero) & np.isfinite(size))
        if not len(active):
            break
        jacobian = target.jacobians(points[active])
        adjoint = jacobian.conj().swapaxes(1, 2)
        damping = options.damping * np.maximum(size[active], options.zero)
        damped = jacobian @ adjoint + damping[:, None, None] * np.eye(7)
        steps = adjoint @ np.linalg.solve(damped, values[active, :, None])
        moved = points[active] - steps[..., 0]
        points[active] = moved / np.linalg.norm(moved, axis=1, keepdims=True)
        values[active] = target.values(points[active])
    return points, np.linalg.norm(values, axis=1) < options.zero


def split(
    target: System, point: ComplexArray, options: DimensionOptions = DIMENSION
) -> ComplexArray | None:
    """Return first guesses (2, 8) of two solutions that rounding has merged to a double one.

    Along the kernel v of the Jacobian matrix the equations are ``u.F(z) + s^2 u.F''(v, v) / 2``,
    u from the left kernel. If z lies between two solutions, they are ``z + s v`` and ``z - s v``.
    The result is None if the dimension of the kernel is not one.
    """
    basis = kernel(target, point, options)
    if basis.shape[1] != 1:
        return None
    v = basis[:, 0]
    jacobian = target.jacobians(point[None])[0]
    size = _row_lengths(jacobian, options)
    u = np.linalg.svd(jacobian / size)[0][:, -1].conj() / size[:, 0]
    step = options.difference
    ahead, behind = target.jacobians(np.array([point + step * v, point - step * v]))
    bend = u @ (ahead - behind) @ v / (2 * step)
    if not abs(bend) > 0:
        return None
    s = np.sqrt(-2 * (u @ target.values(point[None])[0]) / bend)
    return np.array([point + s * v, point - s * v])


def tangents(
    target: System,
    point: ComplexArray,
    rng: np.random.Generator,
    options: DimensionOptions = DIMENSION,
) -> ComplexArray:
    """Estimate the tangent directions of the solution set at a solution.

    Points at a small distance in random directions of the kernel are moved to nearby solutions.
    At an isolated solution they return to it or do not converge. On a solution set of dimension d
    they arrive at points whose differences span d directions. This is evidence and no proof.

    Returns
    -------
    ndarray
        An orthonormal basis, shape (8, d), with d = 0 for an isolated solution. Real if the
        point and the system are.
    """
    basis = kernel(target, point, options)
    count = options.tries * (basis.shape[1] + 1)
    weights = rng.standard_normal((count, basis.shape[1])).astype(np.complex128)
    if basis.imag.any():
        weights += 1j * rng.standard_normal(weights.shape)
    directions = weights @ basis.T
    directions /= np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-300)
    moved, converged = correct(target, point + options.distance * directions, options)
    shifts = moved / (moved @ point.conj())[:, None] - point
    distance = np.linalg.norm(shifts, axis=1)
    relative = distance / options.distance
    near = converged & (relative > options.least) & (relative < options.most)
    # All of a solution set is singular; another isolated solution in general is not.
    for i in np.flatnonzero(near):
        near[i] = kernel(target, moved[i], options).shape[1] > 0
    if not basis.shape[1] or near.sum() < count // options.tries:
        return np.zeros((8, 0), dtype=np.complex128)
    shifts = shifts[near] / distance[near, None]
    _, values, spanned = np.linalg.svd(shifts if shifts.imag.any() else shifts.real)
    dimension = int((values > options.spread * values[0]).sum())
    along = definite_sign(spanned[:dimension].conj())
    return np.asarray(along.T, dtype=np.complex128)


def _in_kernel(
    target: System, points: ComplexArray, vectors: ComplexArray, options: DimensionOptions
) -> ComplexArray:
    """Project vectors (n, 8) to the kernels of `kernel` at points (n, 8)."""
    _, values, basis = np.linalg.svd(_scaled_jacobians(target, points, options))
    inside = np.where(values < options.rank, (basis @ vectors[..., None])[..., 0], 0.0)
    return np.asarray((basis.conj().swapaxes(1, 2) @ inside[..., None])[..., 0])


def sample_motions(
    target: System,
    points: ComplexArray,
    directions: ComplexArray,
    steps: int = 24,
) -> list[ComplexArray]:
    """Return consecutive solutions along positive-dimensional solution sets.

    Parameters
    ----------
    points
        Solutions on them, shape (n, 8).
    directions
        A tangent (`tangents`) at each point, shape (n, 8).

    Returns
    -------
    list of ndarray
        A motion from each point, shape (at most steps + 1, 8), norm 1; real if the point and the
        direction are. It ends before infinity.
    """
    real = np.asarray(~(points.imag.any(axis=1) | directions.imag.any(axis=1)))
    motions = [[point] for point in points]
    moving = np.arange(len(points))
    while len(moving) and len(motions[moving[0]]) <= steps:
        now = np.array([motions[i][-1] for i in moving])
        tangent = _in_kernel(target, now, directions, DIMENSION)
        length = np.linalg.norm(tangent, axis=1, keepdims=True)
        trial = now + DIMENSION.stride * DIMENSION.distance * tangent / np.maximum(length, 1e-300)
        trial[real] = trial[real].real
        trial /= np.linalg.norm(trial, axis=1, keepdims=True)
        moved, converged = correct(target, trial, DIMENSION)
        inner = (now.conj() * moved).sum(axis=1, keepdims=True)
        moved *= np.where(real[:, None], 1.0, np.exp(-1j * np.angle(inner)))
        directions = moved - now
        size = np.linalg.norm(directions, axis=1)
        relative = size / DIMENSION.distance
        most = DIMENSION.most * DIMENSION.stride
        going = converged & (relative > DIMENSION.least) & (relative < most)
        # A motion ends at infinity, where e.e is zero and the points are no poses.
        going &= np.abs((moved[:, :4] ** 2).sum(axis=1)) > _INFINITE
        moving, real, directions = moving[going], real[going], directions[going]
        for i, point in zip(moving, moved[going], strict=True):
            motions[i].append(point)
    return [np.array(motion) for motion in motions]


def real_point(target: System, point: ComplexArray) -> ComplexArray | None:
    """Search for a real finite solution near a complex one.

    Returns
    -------
    ndarray or None
        Shape (8,), norm 1, zero imaginary parts; None if the system is not real or none was
        found.
    """
    if not target.is_real:
        return None
    # The phase with the smallest imaginary part.
    phase = np.exp(-0.5j * np.angle((point**2).sum()))
    candidate = (phase * point).real.astype(np.complex128)
    moved, converged = correct(target, candidate[None] / np.linalg.norm(candidate), DIMENSION)
    finite = (moved[0, :4] ** 2).sum().real > DIMENSION.finite
    return moved[0] if converged[0] and finite else None
