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
    same = (problem.choices[:, None] == found.signs).all(axis=2)
    if same.any(axis=1).all():
        yield Ends(found.points[0][np.argmax(same, axis=1)], problem.frames)
