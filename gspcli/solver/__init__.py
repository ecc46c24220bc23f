"""An instance in, its assembly modes out: `solve`, `solve_values`, and what they return."""

from gspcli.solver.api import solve, solve_values
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.result import Counts, Solution, SolveResult
from gspcli.solver.self_motion import Motion

__all__ = [
    "Counts",
    "Motion",
    "PoseSet",
    "Solution",
    "SolveResult",
    "solve",
    "solve_values",
]
