"""Numerical evidence for or against a positive-dimensional solution set through a point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.systems import Coefficients

_RANK_TOLERANCE = 1e-6
_DISTANCE = 0.03
_ZERO = 1e-13
_NEWTON_STEPS = 60


def kernel(products: NDArray[np.bool_], target: Coefficients, point: ComplexArray) -> ComplexArray:
    """Return an orthonormal basis (8, k) of the directions in which all equations vanish to
    first order at a solution, without the direction of the point itself.
    """
    jacobian = target.jacobians(products, point[None])[0]
    size = np.linalg.norm(jacobian, axis=1, keepdims=True)
    rows = np.vstack([jacobian / np.where(size > 0, size, 1.0), point.conj()[None]])
    _, values, basis = np.linalg.svd(rows)
    return np.asarray(basis[values < _RANK_TOLERANCE].conj().T)


def correct(
    products: NDArray[np.bool_], target: Coefficients, points: ComplexArray
) -> tuple[ComplexArray, NDArray[np.bool_]]:
    """Move points (n, 8) of norm 1 to the nearest solutions, singular ones included.

    The Levenberg-Marquardt method with the norm of the residual as damping, which converges
    quadratically to solution sets of any dimension if they are smooth and reduced. Real points
    stay real if the system is.

    Returns
    -------
    points, converged
        Shapes (n, 8) and (n,).
    """
    for _ in range(_NEWTON_STEPS):
        values = target.values(products, points)
        size = np.linalg.norm(values, axis=1)
        if (size < _ZERO).all():
            break
        jacobian = target.jacobians(products, points)
        adjoint = jacobian.conj().swapaxes(1, 2)
        damped = jacobian @ adjoint + np.maximum(size, 1e-12)[:, None, None] * np.eye(7)
        step = (adjoint @ np.linalg.solve(damped, values[..., None]))[..., 0]
        points = points - np.where(size < _ZERO, 0.0, 1.0)[:, None] * step
        points = points / np.linalg.norm(points, axis=1, keepdims=True)
    return points, np.linalg.norm(target.values(products, points), axis=1) < _ZERO


def local_dimension(
    products: NDArray[np.bool_],
    target: Coefficients,
    point: ComplexArray,
    rng: np.random.Generator,
) -> int:
    """Estimate the dimension of the solution set at a solution (0 for an isolated one).

    Points at a small distance in random directions of the kernel are moved to nearby solutions.
    At an isolated solution they return to it or do not converge; on a solution set of dimension
    d they arrive at points around it whose differences span d directions. Evidence, no proof.
    """
    basis = kernel(products, target, point)
    if not basis.shape[1]:
        return 0
    real = not any(np.abs(x.imag).max(initial=0.0) > 0 for x in (point, *target))
    count = 4 * basis.shape[1] + 4
    weights = rng.standard_normal((count, basis.shape[1])).astype(np.complex128)
    if not real:
        weights += 1j * rng.standard_normal(weights.shape)
    weights /= np.linalg.norm(weights, axis=1, keepdims=True)
    moved, converged = correct(products, target, point + _DISTANCE * weights @ basis.T)
    shifts = (moved * (np.vdot(point, point) / (moved @ point.conj()))[:, None]) - point
    distance = np.linalg.norm(shifts, axis=1)
    near = converged & (distance > _DISTANCE / 10) & (distance < 5 * _DISTANCE)
    if near.sum() < count // 4:
        return 0
    directions = shifts[near] / distance[near, None]
    values = np.linalg.svd(directions, compute_uv=False)
    return int((values > 0.15 * values[0]).sum())


def sample_motion(
    products: NDArray[np.bool_], target: Coefficients, point: ComplexArray, steps: int = 24
) -> ComplexArray:
    """Return consecutive solutions along a positive-dimensional solution set, from a point on it.

    Returns
    -------
    ndarray
        Shape (at most steps + 1, 8), norm 1; the point alone if no step succeeds. Real if the
        point and the system are.
    """
    motion = [point]
    direction = None
    for _ in range(steps):
        basis = kernel(products, target, motion[-1])
        if not basis.shape[1]:
            break
        tangent = basis[:, 0] if direction is None else basis @ (basis.conj().T @ direction)
        tangent = tangent / np.linalg.norm(tangent)
        moved, converged = correct(products, target, (motion[-1] + 2 * _DISTANCE * tangent)[None])
        following = moved[0] * np.exp(-1j * np.angle(np.vdot(motion[-1], moved[0])))
        if not point.imag.any():
            following = moved[0]
        if not converged[0] or np.linalg.norm(following - motion[-1]) < _DISTANCE / 10:
            break
        direction = following - motion[-1]
        motion.append(following)
    return np.array(motion)


def real_point(
    products: NDArray[np.bool_],
    target: Coefficients,
    point: ComplexArray,
    rng: np.random.Generator,
) -> ComplexArray | None:
    """Look for a real point of the same positive-dimensional solution set, from a complex one.

    Returns
    -------
    ndarray or None
        Shape (8,), norm 1, zero imaginary parts; None if the system is not real, none was found,
        or it is isolated or at infinity.
    """
    if any(np.abs(x.imag).max(initial=0.0) > 0 for x in target):
        return None
    phases = np.exp(1j * np.pi * np.arange(8) / 8)
    candidates = (phases[:, None] * point).real.astype(np.complex128)
    moved, converged = correct(
        products, target, candidates / np.linalg.norm(candidates, axis=1, keepdims=True)
    )
    for candidate in moved[converged]:
        finite = (candidate[:4] ** 2).sum().real > 1e-6
        if finite and local_dimension(products, target, candidate, rng):
            return np.asarray(candidate)
    return None
