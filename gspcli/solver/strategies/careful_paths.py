"""Paths from the stored start, followed with all the care that doubles allow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gspcli.continuation.pursuit import Pursuit
from gspcli.solver.ledger import Ends
from gspcli.solver.problem import Problem


def careful_paths(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of all paths."""
    yield ends_of(problem, problem.pursuits)


def ends_of(problem: Problem, pursuits: Sequence[Pursuit]) -> Ends:
    """Return the ends of paths for each choice of sides."""
    return Ends(np.stack([each.first().points for each in pursuits]), problem.frames)
