"""Three angles: the rotations, then for each the translations (Algorithm 6.6)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gspcli.geometry.three_angles import study_points
from gspcli.solver.ledger import Ends
from gspcli.solver.problem import Problem


def closed_form(problem: Problem) -> Iterator[Ends]:
    """Yield all poses of a platform with three angles whose surfaces are in general position."""
    given = problem.arrangement.normalized
    found = study_points(given, given.values[given.distances][None], given.values[None])
    if not found.general[0]:
        return
    # The two signs of a distance of lines are both of one side.
    signs = np.where(given.sided, found.signs, 1.0)
    each = [found.points[0, (signs == choice).all(axis=1)] for choice in problem.choices]
    if all(len(points) for points in each):
        yield Ends(np.stack(each).reshape(len(each), -1, 8), problem.frames)
