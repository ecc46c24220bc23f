"""Numerical evidence for or against a positive-dimensional solution set through a point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.systems import System

_RANK_TOLERANCE = 1e-6
_ROW_TOLERANCE = 1e-8
_DISTANCE = 0.03
_ZERO = 1e-13
_NEWTON_STEPS = 60
_DAMPING = 0.01


def _scaled_jacobians(target: System, points: ComplexArray) -> ComplexArray:
    """Return the Jacobian matrices (n, 8, 8) with rows of length 1, the last the point's patch.

    Rows that vanish up to rounding stay small: the gradient of one equation may be zero.
    """
    jacobian = target.jacobians(points)
    return np.concatenate([jacobian / _row_lengths(jacobian), points.conj()[:, None, :]], axis=1)


def _row_lengths(jacobian: ComplexArray) -> FloatArray:
    size = np.linalg.norm(jacobian, axis=-1, keepdims=True)
    return np.asarray(np.maximum(size, _ROW_TOLERANCE * size.max(axis=-2, keepdims=True)))


def kernel(target: System, point: ComplexArray) -> ComplexArray:
    """Return an orthonormal basis (8, k) of the kernel of the Jacobian matrix at a solution.

    The point itself, which is always in it, is left out.
    """
    rows = _scaled_jacobians(target, point[None])[0]
    # A real basis if there is one.
    _, values, basis = np.linalg.svd(rows if rows.imag.any() else rows.real)
    return np.asarray(basis[values < _RANK_TOLERANCE].conj().T, dtype=np.complex128)


def correct(target: System, points: ComplexArray) -> tuple[ComplexArray, NDArray[np.bool_]]:
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
    for _ in range(_NEWTON_STEPS):
        size = np.linalg.norm(values, axis=1)
        active = np.flatnonzero((size >= _ZERO) & np.isfinite(size))
        if not len(active):
            break
        jacobian = target.jacobians(points[active])
        adjoint = jacobian.conj().swapaxes(1, 2)
        damping = _DAMPING * np.maximum(size[active], _ZERO)
        damped = jacobian @ adjoint + damping[:, None, None] * np.eye(7)
        steps = adjoint @ np.linalg.solve(damped, values[active, :, None])
        moved = points[active] - steps[..., 0]
        points[active] = moved / np.linalg.norm(moved, axis=1, keepdims=True)
        values[active] = target.values(points[active])
    return points, np.linalg.norm(values, axis=1) < _ZERO


def split(target: System, point: ComplexArray) -> ComplexArray | None:
    """Return first guesses (2, 8) of the two solutions that a double one may really be.

    Along the kernel v of the Jacobian matrix the equations are ``u.F(z) + s^2 u.F''(v, v) / 2``,
    u from the left kernel: two solutions at ``z + s v`` and ``z - s v`` if z is only between
    them. None if the kernel has not dimension one.
    """
    basis = kernel(target, point)
    if basis.shape[1] != 1:
        return None
    v = basis[:, 0]
    jacobian = target.jacobians(point[None])[0]
    size = _row_lengths(jacobian)
    u = np.linalg.svd(jacobian / size)[0][:, -1].conj() / size[:, 0]
    step = 1e-4
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
) -> ComplexArray:
    """Estimate the tangent directions of the solution set at a solution.

    Points at a small distance in random directions of the kernel are moved to nearby solutions.
    At an isolated solution they return to it or do not converge; on a solution set of dimension
    d they arrive at points around it whose differences span d directions. Evidence, no proof.

    Returns
    -------
    ndarray
        An orthonormal basis, shape (8, d), with d = 0 for an isolated solution. Real if the
        point and the system are.
    """
    basis = kernel(target, point)
    count = 4 * basis.shape[1] + 4
    weights = rng.standard_normal((count, basis.shape[1])).astype(np.complex128)
    if basis.imag.any():
        weights += 1j * rng.standard_normal(weights.shape)
    directions = weights @ basis.T
    directions /= np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-300)
    moved, converged = correct(target, point + _DISTANCE * directions)
    shifts = moved / (moved @ point.conj())[:, None] - point
    distance = np.linalg.norm(shifts, axis=1)
    near = converged & (distance > _DISTANCE / 10) & (distance < 5 * _DISTANCE)
    # The whole solution set around is singular; another isolated solution in general is not.
    for i in np.flatnonzero(near):
        near[i] = kernel(target, moved[i]).shape[1] > 0
    if not basis.shape[1] or near.sum() < count // 4:
        return np.zeros((8, 0), dtype=np.complex128)
    shifts = shifts[near] / distance[near, None]
    _, values, spanned = np.linalg.svd(shifts if shifts.imag.any() else shifts.real)
    dimension = int((values > 0.15 * values[0]).sum())
    return np.asarray(spanned[:dimension].conj().T, dtype=np.complex128)


def _in_kernel(target: System, points: ComplexArray, vectors: ComplexArray) -> ComplexArray:
    """Project vectors (n, 8) to the kernels of `kernel` at points (n, 8)."""
    _, values, basis = np.linalg.svd(_scaled_jacobians(target, points))
    inside = np.where(values < _RANK_TOLERANCE, (basis @ vectors[..., None])[..., 0], 0.0)
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
        For each one of its `tangents`, shape (n, 8).

    Returns
    -------
    list of ndarray
        For each a motion that begins with the point, shape (at most steps + 1, 8), norm 1; real
        if the point and the direction are.
    """
    real = np.asarray(~(points.imag.any(axis=1) | directions.imag.any(axis=1)))
    motions = [[point] for point in points]
    moving = np.arange(len(points))
    while len(moving) and len(motions[moving[0]]) <= steps:
        now = np.array([motions[i][-1] for i in moving])
        tangent = _in_kernel(target, now, directions)
        length = np.linalg.norm(tangent, axis=1, keepdims=True)
        trial = now + 2 * _DISTANCE * tangent / np.maximum(length, 1e-300)
        trial[real] = trial[real].real
        trial /= np.linalg.norm(trial, axis=1, keepdims=True)
        moved, converged = correct(target, trial)
        inner = (now.conj() * moved).sum(axis=1, keepdims=True)
        moved *= np.where(real[:, None], 1.0, np.exp(-1j * np.angle(inner)))
        directions = moved - now
        size = np.linalg.norm(directions, axis=1)
        going = converged & (size > _DISTANCE / 10) & (size < 10 * _DISTANCE)
        moving, real, directions = moving[going], real[going], directions[going]
        for i, point in zip(moving, moved[going], strict=True):
            motions[i].append(point)
    return [np.array(motion) for motion in motions]


def real_point(target: System, point: ComplexArray) -> ComplexArray | None:
    """Look for a real finite solution near a complex one.

    Returns
    -------
    ndarray or None
        Shape (8,), norm 1, zero imaginary parts; None if the system is not real or none was
        found.
    """
    if not target.is_real:
        return None
    # The phase that leaves the least imaginary part.
    phase = np.exp(-0.5j * np.angle((point**2).sum()))
    candidate = (phase * point).real.astype(np.complex128)
    moved, converged = correct(target, candidate[None] / np.linalg.norm(candidate))
    finite = (moved[0, :4] ** 2).sum().real > 1e-6
    return moved[0] if converged[0] and finite else None
