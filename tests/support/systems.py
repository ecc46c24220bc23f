"""Systems that are solved one by one, and quadrics."""

from __future__ import annotations

import numpy as np

from gspcli.continuation.endpoints import SystemSolutions
from gspcli.continuation.systems import System
from gspcli.continuation.tracked_paths import solve_systems
from gspcli.defaults import SEED


def solve_system(target: System, *, seed: int = SEED) -> SystemSolutions:
    """Return all isolated solutions of a system, and evidence of any others."""
    return next(solve_systems([target], seed=seed))


def quadric(**entries: float) -> np.ndarray:
    """Return the Hessian matrix of a quadric: ``quadric(e01=1)`` is that of e0 e1."""
    matrix = np.zeros((8, 8))
    for name, factor in entries.items():
        i, j = map(int, name[1:])
        matrix[i, j] += factor
        matrix[j, i] += factor
    return matrix
