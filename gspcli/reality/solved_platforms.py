"""Reduced platforms with all their solutions; which of these are real."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.parameter_homotopy import follow
from gspcli.continuation.systems import System
from gspcli.continuation.tracked_paths import solve_systems
from gspcli.defaults import SEED
from gspcli.geometry.quaternions import pose_from_study
from gspcli.reality.fold_distances import Folds, folds
from gspcli.reality.patterns import Pattern
from gspcli.reality.platforms import Platforms
from gspcli.reality.recognition import reality
from gspcli.records import dataclass

Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Solved:
    """A reduced platform with all its solutions.

    Attributes
    ----------
    platform
        One platform, no leading axes.
    system
        Its equations.
    points
        Solutions in Study coordinates, N = 1, shape (n, 8).
    real
        Which are real, shape (n,).
    """

    platform: Platforms
    system: System
    points: Complex
    real: NDArray[np.bool_]

    @property
    def count(self) -> int:
        """The number of real solutions."""
        return int(self.real.sum())

    def folds(self, pattern: Pattern) -> tuple[Folds, Folds]:
        """Return the folds of conjugate pairs and those of real solutions, within a pattern."""
        R, T = pose_from_study(self.points[:, :4], self.points[:, 4:])
        return folds(self.platform, R, T, self.real, pattern)

    def margin(self, pattern: Pattern) -> float:
        """Return the linear distance to the nearest fold of real solutions, within a pattern."""
        return float(self.folds(pattern)[1].distances.min(initial=np.inf))


def solved(platform: Platforms, seed: int = SEED, solutions: int | None = None) -> Solved | None:
    """Return a platform with all solutions, or None if some cannot be found or decided.

    Special platforms may have fewer solutions than their type: `solutions`.
    """
    system = next(platform[None].systems())
    result = next(solve_systems([system], seed=seed))
    if len(result.points) != (solutions or result.account.expected):
        return None
    found = reality(result.points, result.condition)
    if not found.decided:
        return None
    return Solved(platform, system, result.points, found.real)


def followed_from(known: Solved, platform: Platforms, rng: np.random.Generator) -> Solved | None:
    """Return a platform near another with all solutions, followed from those of the other."""
    system = next(platform[None].systems())
    ends = follow(known.system, known.points, system, rng=rng)
    if ends is None:
        return None
    found = reality(ends.points, ends.condition)
    return Solved(platform, system, ends.points, found.real) if found.decided else None
