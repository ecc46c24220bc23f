"""Solve an instance for its assembly modes, once or for many sets of values."""

from gspcli.geometry.local_motions import Motion
from gspcli.solver.api import certify, solve, solve_batch, solve_values
from gspcli.solver.result import SolveResult
from gspcli.solver.results.pose_batch import PoseBatch
from gspcli.solver.results.pose_set import PoseSet
from gspcli.solver.results.solution import Counts, Solution

__all__ = [
    "Counts",
    "Motion",
    "PoseBatch",
    "PoseSet",
    "Solution",
    "SolveResult",
    "certify",
    "solve",
    "solve_batch",
    "solve_values",
]
