"""The distance of a platform, to first order, from platforms with double solutions.

Where two solutions meet, two real ones become a conjugate pair or conversely. Near such a fold the
square of their distance is a smooth function of the numbers of the platform that changes its sign.
So it can be extrapolated: its value divided by the length of its gradient is approximately the
distance to the fold in the space of platforms. This is the linear model of P. Dietmaier, *The
Stewart-Gough platform of general geometry can have 40 real postures* (1998), for all kinds of
constraints.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLP, DPL, DPP
from gspcli.geometry.constraint_polynomials import Gradient, polynomial
from gspcli.geometry.measurement import by_twist
from gspcli.geometry.quaternions import dot
from gspcli.reality.patterns import NUMBERS, Pattern
from gspcli.reality.platforms import Platforms
from gspcli.records import dataclass

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: The number of nearest real solutions from which each real solution is kept apart.
_NEIGHBOURS = 3

_ROTATIONS = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _ROTATIONS[_i, _j, _k], _ROTATIONS[_i, _k, _j] = 1.0, -1.0


@dataclass(frozen=True, eq=False)
class Folds:
    """Linear distances to platforms with a double solution, for p pairs of solutions.

    Attributes
    ----------
    distances
        Shape (p,).
    normals
        Unit vectors of the changes of the numbers away from the fold, shape (p, 6 * 13).
    """

    distances: Array
    normals: Array


def moved(platform: Platforms, step: Array) -> Platforms:
    """Return a platform with its numbers changed by a step, shape (78,), directions of norm 1."""
    change = step.reshape(-1, NUMBERS)
    return Platforms(
        platform.kinds,
        platform.y + change[:, :3],
        platform.x + change[:, 3:6],
        _directions(platform.u + change[:, 6:9]),
        _directions(platform.v + change[:, 9:12]),
        platform.values + change[:, 12],
    )


def _directions(vectors: Array) -> Array:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0, lengths, 1.0))


def folds(
    platform: Platforms, R: Complex, T: Complex, real: NDArray[np.bool_], pattern: Pattern
) -> tuple[Folds, Folds]:
    """Return the folds of conjugate pairs, and those of real solutions and their neighbours.

    Parameters
    ----------
    platform
        A platform of the pattern.
    R, T
        All its solutions, shapes (n, 3, 3) and (n, 3).
    real
        Which are real, shape (n,).
    pattern
        The pattern: distances of folds are measured within it.
    """
    by_twist, by_number = _gradients(platform, R, T)
    X = np.concatenate((R.reshape(-1, 9), T), axis=-1)
    # Derivatives of the entries of (R, T) by the values of the six equations: (n, 6, 12).
    entries = np.zeros((len(R), 6, 12), complex)
    entries[:, :3, :9] = np.einsum("ikl,slj->skij", _ROTATIONS, R).reshape(-1, 3, 9)
    entries[:, 3:, 9:] = np.eye(3)
    by_value = -np.linalg.solve(np.swapaxes(by_twist, -1, -2), entries)

    def gradient(index: NDArray[np.int64], direction: Array) -> Complex:
        """Return the derivatives of ``direction . X`` by the numbers, shape (k, 6, 13)."""
        multipliers = np.einsum("sic,sc->si", by_value[index], direction)
        return np.asarray(multipliers[..., None] * by_number[index])

    # One solution of each pair: in general position the one with a positive imaginary part.
    height = X.imag @ np.sqrt(np.arange(1, 13))
    pairs = np.flatnonzero(~real & (height > 0))
    imaginary = X[pairs].imag
    upper = _folds(platform, pattern, (imaginary**2).sum(-1), 2 * gradient(pairs, imaginary).imag)
    first, second = neighbours(X[real].real)
    index = np.flatnonzero(real)
    first, second = index[first], index[second]
    difference = X[first].real - X[second].real
    change = gradient(first, difference).real - gradient(second, difference).real
    return upper, _folds(platform, pattern, (difference**2).sum(-1) / 4, change / 2)


def _folds(platform: Platforms, pattern: Pattern, squares: Array, gradients: Array) -> Folds:
    """Return folds from squared half distances (p,) and their gradients (p, 6, 13)."""
    allowed = pattern.projected(gradients)
    for part, directions in ((slice(6, 9), platform.u), (slice(9, 12), platform.v)):
        # The change of a unit direction is perpendicular to it.
        allowed[..., part] -= dot(allowed[..., part], directions)[..., None] * directions
    flat = allowed.reshape(len(squares), len(platform.kinds) * NUMBERS)
    lengths = np.linalg.norm(flat, axis=-1)
    return Folds(squares / lengths, flat / lengths[:, None])


def neighbours(X: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the pairs of points (n, 12) that are neighbours, each pair once."""
    if len(X) < 2:
        return np.zeros(0, int), np.zeros(0, int)
    squares = (X**2).sum(-1)
    distances = squares[:, None] + squares - 2 * X @ X.T
    np.fill_diagonal(distances, np.inf)
    count = min(_NEIGHBOURS, len(X) - 1)
    nearest = np.argpartition(distances, count - 1, axis=-1)[:, :count]
    pairs = np.stack((np.repeat(np.arange(len(X)), count), nearest.ravel()), axis=-1)
    first, second = np.unique(np.sort(pairs, axis=-1), axis=0).T
    return first, second


def _gradients(platform: Platforms, R: Complex, T: Complex) -> tuple[Complex, Complex]:
    """Return derivatives of the equations by a twist (n, 6, 6) and by their numbers (n, 6, 13).

    The equations are the polynomials of `gspcli.geometry.constraint_polynomials` less their stated
    values.
    """
    r, w, arm = platform.placed(R, T)
    v = np.broadcast_to(platform.v, w.shape)
    by_r, by_w, by_v = (np.zeros(w.shape, complex) for _ in range(3))
    by_value = np.zeros(w.shape[:2], complex)
    for i, kind in enumerate(platform.kinds):
        gradient = polynomial(kind).gradient(r[:, i], w[:, i], v[:, i])
        by_r[:, i], by_w[:, i], by_v[:, i] = gradient
        if not kind.is_distance:
            by_value[:, i] = -1.0
        elif kind in (DPP, DPL, DLP):
            by_value[:, i] = -2 * platform.values[i]
    rates = by_twist(Gradient(by_r, by_w, by_v), arm, w)
    by_number = np.concatenate((by_r @ R, -by_r, by_w @ R, by_v, by_value[..., None]), axis=-1)
    return rates, by_number
