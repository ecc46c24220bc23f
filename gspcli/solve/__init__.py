"""An instance in, its assembly modes out: `solve` and what it returns."""

from gspcli.solve.api import DEFAULT_SEED, solve
from gspcli.solve.motion import Motion
from gspcli.solve.result import Counts, Solution, SolveResult

__all__ = ["DEFAULT_SEED", "Counts", "Motion", "Solution", "SolveResult", "solve"]
