"""Solve an instance for its assembly modes, once or for many sets of values."""

from gspcli.geometry.local_motions import Motion
from gspcli.solver.api import certify, solve, solve_batch, solve_values
from gspcli.solver.poses import PoseBatch, PoseSet
from gspcli.solver.result import Counts, Solution, SolveResult

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
