"""A start of a platform's own geometry, from a platform of it that is solved.

Planar bodies, symmetric ones and shared joints are what most platforms have, and leave fewer poses
than the type. Paths from the stored start system would end at infinity; those from a start of the
geometry do not.
"""

from __future__ import annotations

import numpy as np

from gspcli.solver.geometry_start import StartMethod
from gspcli.solver.one_geometry import Geometry, geometry_about, solved_system
from gspcli.solver.problem import Problem

#: Squares of distances, in typical lengths, are about this; what has a sign is about zero.
_SQUARE = 0.5
#: How far the start's values are from real ones.
_SPREAD = 0.5


def kept_geometry(problem: Problem) -> Geometry | None:
    """Return the geometry of a platform with a start; None where none is kept, or none is safe."""
    arrangement, length = problem.arrangement, problem.unit
    known = problem.starts.platform(arrangement)
    if known is None:
        return None
    square = [kind.is_distance and not kind.has_sides for kind in arrangement.kinds]
    geometry = geometry_about(
        arrangement,
        length,
        np.where(square, _SQUARE, 0.0),
        np.full(len(square), _SPREAD),
        count=lambda: problem.geometry_count,
        seed=problem.seed,
        starts=problem.starts,
        ways=(StartMethod.SOLVED, StartMethod.QUICK),
        solved=solved_system(known[0], length, known[1]),
    )
    return None if geometry is None or geometry.proof is None else geometry
