"""Least squares with unknown poses: each pose is removed by an orthogonal factorization.

Poses are measured with errors, so that they are unknowns beside the parameters of the platform. A
pose occurs in its own rows only: a QR factorization of its six columns leaves rows without it.
Their solution is the exact least-squares solution for all unknowns (variable projection of
separable problems; Golub and Pereyra 1973), at the cost of a fit with known poses.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.measurements import Measurements, Noise
from gspcli.calibration.model import Model
from gspcli.errors import GspError
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Singular values below this part of the largest are zero: derivatives are exact up to rounding.
_ROUNDING = 1e-9
#: Iterations end where no parameter changes by more than this part of a length, or the sum of
#: squares by this part of itself.
_STEP, _DECREASE = 1e-13, 1e-14
#: Weights of a robust fit are those of the iteration before: its steps shrink by a factor only, so
#: that parameters are a multiple of the last step away. The sum of losses stands still long before.
_ROBUST_STEP = 1e-12
_MOST = 400
#: This many rows have their derivatives in memory at a time.
_BLOCK = 2000
#: Residuals beyond this many standard deviations count by their modulus, not their square.
HUBER = 2.0


class LinearEquations(NamedTuple):
    """The linear equations of one iteration, poses removed."""

    residual: Array
    """All residuals divided by their deviations, NaN where nothing was measured, shape (n, q)."""
    right: Array
    """Those left after the poses, shape (m,)."""
    slopes: Array
    """Their derivatives by the free parameters, shape (m, f)."""
    back: Callable[[Array], Array] | None
    """Gives the twists of the poses, (n, 6), for a step of the parameters; None if poses are exact.
    """


@dataclass(frozen=True, eq=False)
class Fit:
    """The end of a fit.

    Attributes
    ----------
    model
        With the parameters found.
    R, T
        The poses found, shapes (n, 3, 3) and (n, 3).
    residual
        The residuals in standard deviations, NaN where nothing was measured, shape (n, q).
    cost
        The sum of squares (of a robust fit, of the losses).
    freedom
        Degrees of freedom: numbers measured less poses less parameters.
    singular, directions
        Singular values of the derivatives by the free parameters, each divided by its size, and the
        directions that belong to them (rows), shapes (f,) and (f, f).
    known
        Which directions were estimated, shape (f,); the others keep what is stated.
    converged
        Whether the iterations came to their end.
    """

    model: Model
    R: Array
    T: Array
    residual: Array
    cost: float
    freedom: int
    singular: Array
    directions: Array
    known: NDArray[np.bool_]
    converged: bool

    @cached_property
    def covariance(self) -> Array:
        """The covariance of all parameters, shape (p, p): zero for what was not estimated."""
        free = self.model.free
        scaled = self.directions[self.known] * self.model.sizes[free]
        found = np.zeros((len(free), len(free)))
        found[np.ix_(free, free)] = (scaled.T / self.singular[self.known] ** 2) @ scaled
        return found


def fit(
    model: Model,
    R: Array,
    T: Array,
    seen: Measurements,
    noise: Noise,
    *,
    huber: float | None = None,
    prior: float = np.inf,
) -> Fit:
    """Estimate the free parameters, and the poses unless they are exact.

    Levenberg and Marquardt's method with scaled steps of least norm: a direction that the data do
    not tell (`known`) is not moved along.

    Parameters
    ----------
    model, R, T
        Where to start.
    seen, noise
        What was measured, and how well.
    huber
        Where residuals begin to count less, in standard deviations (a pseudo-Huber loss); None for
        squares.
    prior
        A direction whose standard deviation would be larger than this length is not estimated: it
        is known better without the data.

    Raises
    ------
    GspError
        If a value has no derivative at a pose.
    """
    damping, free, size = 0.0, model.free, model.sizes[model.free]
    system = _equations(model, R, T, seen, noise, huber)
    cost, converged = _cost(system.residual, huber), False
    for _ in range(_MOST):
        U, s, V = _factors(system.slopes * size, system.right)
        keep = _known(s, prior)
        filtered = np.where(keep, s / (s**2 + (damping * s[0]) ** 2 + ~keep), 0.0)
        scaled = -V.T @ (filtered * U)
        step = np.zeros(len(free))
        step[free] = scaled * size
        moved = model.moved(step)
        places = (R, T) if system.back is None else _moved(R, T, system.back(step[free]))
        with np.errstate(all="ignore"):
            tried = _equations(moved, *places, seen, noise, huber, check=False)
        after = _cost(tried.residual, huber)
        if after <= cost * (1 + 1e-12):
            least = _STEP if huber is None else _ROBUST_STEP
            small = float(np.abs(scaled).max(initial=0)) <= least * model.length
            still = huber is None and damping == 0 and cost - after <= _DECREASE * cost
            converged = small or still
            model, (R, T), system, cost = moved, places, tried, after
            damping = damping / 10 if damping > 1e-9 else 0.0
        elif float(np.abs(scaled).max(initial=0)) <= 1e3 * _STEP * model.length:
            # Rounding alone keeps the sum from falling.
            converged = True
        else:
            damping = max(damping * 10, 1e-6)
        if converged or damping > 1e3:
            break
    _, s, V = _factors(system.slopes * size, system.right)
    known = _known(s, prior)
    rows = np.isfinite(system.residual).sum(axis=1)
    spare = rows if noise.exact else np.maximum(rows - 6, 0)
    freedom = int(spare.sum()) - int(known.sum())
    left = system.residual
    return Fit(model, R, T, left, cost, freedom, s, V, known, converged)


def _equations(
    model: Model,
    R: Array,
    T: Array,
    seen: Measurements,
    noise: Noise,
    huber: float | None,
    *,
    check: bool = True,
) -> LinearEquations:
    """Return the equations at poses as `reduced`, for many rows in blocks.

    The equations of a block are replaced by their triangular factor, and the twists are computed
    from the block again: memory does not grow with the derivatives of all rows.
    """
    if len(R) <= _BLOCK:
        return reduced(model, R, T, seen, noise, huber, check=check)
    seen = replace(seen, sorts=seen.measured_sorts)

    def block(rows: slice) -> LinearEquations:
        return reduced(model, R[rows], T[rows], seen.taken(rows), noise, huber, check=check)

    blocks = [slice(k, k + _BLOCK) for k in range(0, len(R), _BLOCK)]
    left, factors = [], []
    for one in map(block, blocks):
        left.append(one.residual)
        factors.append(np.linalg.qr(np.column_stack((one.slopes, one.right)), mode="r"))
    triangles = np.concatenate(factors)

    def back(step: Array) -> Array:
        systems = map(block, blocks)
        return np.concatenate([one.back(step) for one in systems if one.back is not None])

    return LinearEquations(
        np.concatenate(left),
        triangles[:, -1],
        triangles[:, :-1],
        None if noise.exact else back,
    )


def reduced(
    model: Model,
    R: Array,
    T: Array,
    seen: Measurements,
    noise: Noise,
    huber: float | None = None,
    *,
    check: bool = True,
) -> LinearEquations:
    """Return the equations at poses, the poses removed."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        r, J, P = seen.rows(model, R, T, noise)
    J = J[..., model.free]
    there = np.isfinite(r)
    if check:
        _check(there & ~(np.isfinite(J).all(axis=-1) & np.isfinite(P).all(axis=-1)), seen)
    left = r
    weight = np.where(there, 1.0, 0.0)
    if huber is not None:
        weight = weight * (1 + (np.where(there, r, 0.0) / huber) ** 2) ** -0.25
    r, J, P = (
        np.where(there.reshape(*there.shape, *[1] * (part.ndim - 2)), part, 0.0)
        for part in (r, J, P)
    )
    r, J, P = r * weight, J * weight[..., None], P * weight[..., None]
    if noise.exact:
        return LinearEquations(left, r.reshape(-1), J.reshape(-1, J.shape[-1]), None)
    Q, U = np.linalg.qr(P * _twist_sizes(model), mode="complete")
    Q = np.swapaxes(Q, 1, 2)
    right, slopes = (Q @ r[..., None])[..., 0], Q @ J
    ends = U[:, :6], right[:, :6], slopes[:, :6]

    def back(step: Array) -> Array:
        return _twists(*ends, step) * _twist_sizes(model)

    return LinearEquations(
        left, right[:, 6:].reshape(-1), slopes[:, 6:].reshape(-1, J.shape[-1]), back
    )


def redundancies(found: Fit, seen: Measurements, noise: Noise) -> Array:
    """Return which part of an error of each number its own residual shows, shape (n, q).

    The diagonal of ``1 - A (A^T A)^-1 A^T`` with the derivatives A by poses and parameters (Baarda
    1968); zero for what was not measured.
    """
    r, J, P = seen.rows(found.model, found.R, found.T, noise)
    there = np.isfinite(r)[..., None]
    J = np.where(there, J, 0.0)[..., found.model.free]
    V = np.eye(r.shape[1])
    if not noise.exact:
        Q = np.linalg.qr(np.where(there, P, 0.0) * _twist_sizes(found.model), mode="complete")[0]
        V = Q[..., 6:] @ np.swapaxes(Q[..., 6:], 1, 2)
    free = found.model.free
    S = V @ J
    shown = np.einsum("...kk->...k", np.broadcast_to(V, (len(r), *V.shape[-2:])))
    shown = shown - np.einsum("nkf,fg,nkg->nk", S, found.covariance[np.ix_(free, free)], S)
    return np.asarray(np.where(there[..., 0], shown, 0.0))


def _check(wrong: NDArray[np.bool_], seen: Measurements) -> None:
    if wrong.any():
        row, column = np.argwhere(wrong)[0].tolist()
        message = (
            f"row {seen.lines[row]}: the value of constraint {column + 1} is zero or at its end "
            "there and has no derivative: leave that number blank"
        )
        raise GspError(message)


def _twist_sizes(model: Model) -> Array:
    return np.array([1 / model.length] * 3 + [1.0] * 3)


def _factors(slopes: Array, right: Array) -> tuple[Array, Array, Array]:
    """Return ``U^T right``, singular values and directions; of few rows filled up with zeros."""
    full = np.column_stack((slopes, right))
    count = slopes.shape[1]
    if len(full) < count + 1:
        full = np.pad(full, ((0, count + 1 - len(full)), (0, 0)))
    triangle: Array = np.asarray(np.linalg.qr(full, mode="r"))
    U, s, V = np.linalg.svd(triangle[:count, :count])
    right = triangle[:count, count]
    return U.T @ right, s, V


def _known(singular: Array, prior: float) -> NDArray[np.bool_]:
    """Return which directions the data determine better than rounding, and than is known before."""
    floor = _ROUNDING * float(singular.max(initial=0.0))
    return np.asarray((singular > floor) & (singular * prior > 1))


def _twists(U: Array, right: Array, slopes: Array, step: Array) -> Array:
    """Return the twists of poses, scaled, that belong to a step of the free parameters."""
    wanted = -(right + slopes @ step)
    # A pose that its row does not determine moves as little as it can.
    scale = np.abs(U).max(axis=(1, 2), initial=0.0)
    least = np.abs(np.diagonal(U, axis1=1, axis2=2)).min(axis=1)
    whole = least > _ROUNDING * scale
    twist = np.zeros((len(U), 6))
    twist[whole] = np.linalg.solve(U[whole], wanted[whole, :, None])[..., 0]
    if not whole.all():
        inverse = np.linalg.pinv(U[~whole], rcond=_ROUNDING)
        twist[~whole] = (inverse @ wanted[~whole, :, None])[..., 0]
    return twist


def _moved(R: Array, T: Array, twist: Array) -> tuple[Array, Array]:
    """Return poses after twists."""
    return rotation_from_vector(twist[:, :3]) @ R, T + twist[:, 3:]


def _cost(residual: Array, huber: float | None) -> float:
    square = np.nan_to_num(residual, nan=0.0, posinf=np.inf) ** 2
    if huber is None:
        return float(square.sum())
    return float((2 * huber**2 * (np.sqrt(1 + square / huber**2) - 1)).sum())
