"""The solutions of one system: the ends of all paths to it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.endpoints import Endpoints
from gspcli.continuation.paths import PathAccount
from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.records import dataclass


@dataclass(frozen=True, eq=False)
class SolutionCurve:
    """A positive-dimensional part of the solution set that paths ended on.

    The evidence is numerical: the Jacobian matrix has a kernel, and a move along it with a
    correction on a slice arrives at other solutions.
    """

    dimension: int
    """Local dimension of the solution set at `points`."""
    points: ComplexArray
    """The ends of paths on it, shape (k, 8), scaled to N = 1."""
    motion: ComplexArray
    """Consecutive points along it, shape (m, 8), scaled to N = 1; real (zero imaginary parts)
    if `real`."""
    real: bool
    """Whether real points were found, so that the motion is a self-motion of the mechanism."""


@dataclass(frozen=True, eq=False)
class SystemSolutions:
    """The solutions of one system, with an account of every path."""

    points: ComplexArray
    """Distinct finite isolated solutions, shape (n, 8), scaled to N = e.e = 1. The sign is such
    that the largest entry of e has a positive real part. Real solutions have small but in
    general not zero imaginary parts."""
    multiplicity: NDArray[np.int64]
    """How many paths end at each, shape (n,)."""
    singular: NDArray[np.bool_]
    """Whether the Jacobian matrix at each is numerically singular, shape (n,)."""
    condition: FloatArray
    """Condition number of each, shape (n,): Frobenius norm of the inverse of the Jacobian matrix,
    in coordinates scaled to norm 1, the equations divided by the size of the terms that cancel
    in them. A relative change of the coefficients moves the solution by about as much times
    this. Infinite where singular."""
    residual: FloatArray
    """Largest value of an equation, divided by the size of the terms that cancel in it, for
    coordinates and factors of norm 1; shape (n,)."""
    account: PathAccount
    """Where all paths end; as many are expected as the generic count of the structure says,
    2^products times I."""
    curves: tuple[SolutionCurve, ...]
    """The positive-dimensional solution sets found."""
    seed: int
    """What the random choices were made from."""


def solutions_of(ends: Endpoints, scale: float, seed: int) -> SystemSolutions:
    """Return the ends of all paths in the coordinates of the system, whose unit of f is `scale`."""
    return SystemSolutions(
        points=_scaled_to_one(ends.points, scale),
        multiplicity=ends.multiplicity,
        singular=~np.isfinite(ends.condition),
        condition=ends.condition,
        residual=ends.residual,
        account=ends.account,
        curves=tuple(
            SolutionCurve(
                curve.dimension,
                _scaled_to_one(curve.points, scale),
                _scaled_to_one(curve.motion, scale),
                curve.real,
            )
            for curve in ends.curves
        ),
        seed=seed,
    )


def _scaled_to_one(points: ComplexArray, scale: float) -> ComplexArray:
    """Undo the balance of e and f, and scale to N = 1 with a definite sign."""
    points = points / np.sqrt((points[:, :4] ** 2).sum(axis=1, keepdims=True))
    points[:, 4:] *= scale
    largest = points[np.arange(len(points)), np.abs(points[:, :4]).argmax(axis=1)]
    return points * np.where(largest.real < 0, -1.0, 1.0)[:, None]
