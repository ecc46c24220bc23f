"""Solved platforms of six legs of which one body is planar, or both are, with complex values.

The equations of a planar body are not solved for the same quantities as those of others
(`ReducedHomotopy`). From a platform that is planar, too, another is solved in a third of the time
that all paths of the equations as they are take (`make bench`, row "planar 6-6").
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.continuation.start import StartSystem, path_count
from gspcli.continuation.systems import EQUATIONS
from gspcli.geometry.arrangement import Arrangement
from gspcli.solver.reference_start import complex_platform
from gspcli.solver.solved_starts import SolvedStarts, Sort

#: Heights of points of a planar body over its plane, in lengths of order one.
_FLAT = 1e-12
#: Of the random geometries, of which the first is from where fewest paths go wrong.
_SEEDS = (1, 3)


def planar_starts(arrangement: Arrangement, starts: SolvedStarts) -> list[StartSystem]:
    """Return solved platforms that are planar where another is.

    They are solved when they were asked for `OFTEN` times. None before, and where the planes are
    not those of two coordinates or joints are shared.

    Parameters
    ----------
    arrangement
        The other one, lengths of order one.
    starts
        What is kept of solved platforms.
    """
    bodies = arrangement.y, arrangement.x
    flat = (_is_flat(arrangement.y), _is_flat(arrangement.x))
    if set(arrangement.kinds) != {DPP} or not any(flat) or any(map(_shares_joints, bodies)):
        return []
    if not starts.is_frequent(flat):
        return []
    made = (
        starts.kept(Sort.REFERENCE, (flat, seed), partial(_solved, flat, seed)) for seed in _SEEDS
    )
    return [start for start in made if start is not None]


def _is_flat(points: NDArray[np.float64]) -> bool:
    return bool(np.ptp(points[:, 2]) <= _FLAT)


def _shares_joints(points: NDArray[np.float64]) -> bool:
    return len(set(map(tuple, points.tolist()))) < len(points)


def _solved(flat: tuple[bool, bool], seed: int) -> StartSystem | None:
    """Return a solved platform of which these bodies are planar; None if some paths are lost."""
    from gspcli.continuation.tracked_paths import track_all

    given = complex_platform((DPP,) * EQUATIONS, seed, flat=flat)
    points = next(track_all([given], seed=seed)).distinct_simple()
    if len(points) != path_count(given.structure):
        return None
    return StartSystem(given, points / np.linalg.norm(points, axis=1, keepdims=True))
