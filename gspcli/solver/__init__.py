"""An instance in, its assembly modes out: one, many sets of values, and what is returned."""

from gspcli.solver.api import solve, solve_batch, solve_values
from gspcli.solver.batch import PoseBatch
from gspcli.solver.pose_set import Motion, PoseSet
from gspcli.solver.result import SolveResult
from gspcli.solver.solution import Counts, Solution

__all__ = [
    "Counts",
    "Motion",
    "PoseBatch",
    "PoseSet",
    "Solution",
    "SolveResult",
    "solve",
    "solve_batch",
    "solve_values",
]
