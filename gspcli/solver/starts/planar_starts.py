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
from gspcli.continuation.systems import EQUATIONS, System
from gspcli.geometry.arrangement import Arrangement
from gspcli.solver.starts.solved_starts import SolvedStarts, Sort
from gspcli.solver.study_systems import complex_system

#: Heights of points of a planar body over its plane, in lengths of order one.
_FLAT = 1e-12
#: Of the random geometries, of which the first is from where fewest paths go wrong.
_SEEDS = (1, 3)
#: The squared lengths: a mean plus i times numbers between these with random signs.
_MEAN, _SPREAD = 0.6, (0.2, 0.4)


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
    made = (starts.kept(Sort.PLANAR, (flat, seed), partial(_solved, flat, seed)) for seed in _SEEDS)
    return [start for start in made if start is not None]


def _is_flat(points: NDArray[np.float64]) -> bool:
    return bool(np.ptp(points[:, 2]) <= _FLAT)


def _shares_joints(points: NDArray[np.float64]) -> bool:
    return len(set(map(tuple, points.tolist()))) < len(points)


def _solved(flat: tuple[bool, bool], seed: int) -> StartSystem | None:
    """Return a solved platform of which these bodies are planar; None if some paths are lost."""
    from gspcli.continuation.tracked_paths import track_all

    given = complex_platform(flat, seed)
    points = next(track_all([given], seed=seed)).distinct_simple()
    if len(points) != path_count(given.structure):
        return None
    return StartSystem(given, points / np.linalg.norm(points, axis=1, keepdims=True))


def complex_platform(flat: tuple[bool, bool], seed: int) -> System:
    """Return a platform of six legs with complex values, lengths of order one.

    Parameters
    ----------
    flat
        Whether the points of the platform, and of the base, are of one plane.
    seed
        Of its random numbers.
    """
    rng = np.random.default_rng([seed, EQUATIONS])
    y, x = rng.uniform(-1, 1, (2, EQUATIONS, 3))
    y[:, 2] *= not flat[0]
    x[:, 2] *= not flat[1]
    y, x = (z - z.mean(axis=0) for z in (y, x))
    length = np.sqrt(max((z**2).sum(axis=1).max() for z in (y, x)))
    # Drawn for directions, which points do not have, so that the values stay those of the seed.
    rng.normal(size=(2, EQUATIONS, 3))
    turns = rng.choice([-1.0, 1.0], EQUATIONS) * rng.uniform(*_SPREAD, EQUATIONS)
    squares = np.asarray(_MEAN + 1j * turns, np.complex128)
    none = np.zeros((EQUATIONS, 3))
    return complex_system((DPP,) * EQUATIONS, y / length, x / length, none, none, squares)
