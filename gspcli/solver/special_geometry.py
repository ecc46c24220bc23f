"""A start of a platform's own geometry, from a platform of it that is solved.

Planar bodies, symmetric ones and shared joints are what most platforms have, and leave fewer poses
than the type. Paths from the stored start system would end at infinity; those from a start of the
geometry do not.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gspcli.geometry.arrangement import Arrangement
from gspcli.solver.geometry_start import SolvedSystem, Way
from gspcli.solver.one_geometry import Geometry, geometry_about, solved_system
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.problem import Problem
from gspcli.solver.solved_starts import STARTS

#: Squares of distances, in typical lengths, are about this; what has a sign is about zero.
_SQUARE = 0.5
#: How far the start's values are from real ones.
_SPREAD = 0.5


def kept_geometry(problem: Problem) -> Geometry | None:
    """Return the geometry of a platform with a start; None where none is kept, or none is safe."""
    arrangement, length = problem.arrangement, problem.unit
    known = STARTS.platform(arrangement)
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
        ways=(Way.SOLVED, Way.QUICK),
        solved=_system(*known, length),
    )
    return None if geometry is None or geometry.proof is None else geometry


@lru_cache(maxsize=64)
def _system(arrangement: Arrangement, poses: PoseSet, length: float) -> SolvedSystem:
    """Return a solved platform in a unit of length, always the same object."""
    return solved_system(arrangement, length, poses)
