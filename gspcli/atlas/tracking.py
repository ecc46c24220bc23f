"""Counting solutions by tracking paths to a random platform, and proving them distinct."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gspcli.catalogue.kinds import ALL, Kind
from gspcli.catalogue.types import CONSTRAINTS, GspType
from gspcli.certification import certify
from gspcli.geometry.residuals import Arrangement
from gspcli.solve.generate import random_instance
from gspcli.solve.tracking import solve_by_tracking

#: How many random platforms are tried for the largest count. Some have poses so far away that
#: floating point does not find them accurately enough to certify them.
ATTEMPTS = 5


def certified_count(distances: Sequence[Kind], sides: int, seed: int) -> int:
    """Return how many different poses of a random real platform are proved to exist.

    The poses, complex ones included, are found by tracking paths and proved to be simple in ball
    arithmetic. Simple poses persist when the platform changes, so that every such number is a
    lower bound of the generic count: the largest over a few platforms is returned.

    Parameters
    ----------
    distances
        The kinds of the distances; the angles are ALL.
    sides
        1 to choose a side for each DPH and DHP, 2 to leave it open.
    seed
        Source of the random numbers.
    """
    gsp_type = GspType.of([*distances, *[ALL] * (CONSTRAINTS - len(distances))])
    best = 0
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, attempt])
        instance, _ = random_instance(gsp_type, rng, one_sided=sides == 1)
        poses = solve_by_tracking(Arrangement.of(instance), seed=seed)
        best = max(best, certify(instance, poses.R, poses.T).distinct)
        if best == poses.paths:
            break
    return best
