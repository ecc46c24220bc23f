"""Systems that are solved one by one."""

from __future__ import annotations

from gspcli.continuation.solutions import SystemSolutions
from gspcli.continuation.systems import System
from gspcli.continuation.tracked_paths import solve_systems
from gspcli.defaults import SEED


def solve_system(target: System, *, seed: int = SEED) -> SystemSolutions:
    """Return all isolated solutions of a system, and evidence of any others."""
    return next(solve_systems([target], seed=seed))
