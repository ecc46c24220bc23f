"""Three angles: the rotations, then for each the translations (Algorithm 6.6)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gspcli.certification.equations.frames import StudyFrames
from gspcli.geometry.three_angles import study_points
from gspcli.solver.ends import Ends
from gspcli.solver.problem import Problem


def closed_form(problem: Problem) -> Iterator[Ends]:
    """Yield all poses of a platform with three angles whose surfaces are in general position.

    By Bezout's theorem there are no other poses then.
    """
    arrangement, values = problem.arrangement, problem.values
    length = arrangement.length_with(values)
    given = arrangement.in_units_of(length)
    found = study_points(given, values[:, given.distances] / length, values)
    if not found.general.any():
        return
    # The two signs of a distance of lines are both of one side.
    signs = np.where(given.sided, found.signs, 1.0)
    each = [found.points[:, (signs == choice).all(axis=1)] for choice in problem.choices]
    if not all(points.shape[1] for points in each):
        return
    points = np.stack(each, axis=1).reshape(len(values), len(each), -1, 8)
    points[~found.general] = np.nan
    centres = arrangement.platform_centre, arrangement.base_centre
    yield Ends(points, StudyFrames(length=length, platform=centres[0], base=centres[1]))
