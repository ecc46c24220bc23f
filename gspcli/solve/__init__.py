"""An instance in, its assembly modes out: `solve`, `solve_values`, and what they return."""

from gspcli.solve.api import DEFAULT_SEED, solve, solve_values
from gspcli.solve.motion import Motion
from gspcli.solve.poses import PoseSet
from gspcli.solve.result import Counts, Solution, SolveResult

__all__ = [
    "DEFAULT_SEED",
    "Counts",
    "Motion",
    "PoseSet",
    "Solution",
    "SolveResult",
    "solve",
    "solve_values",
]
