"""Counting solutions by tracking paths to a random platform, and proving them distinct."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gspcli.atlas.trace import TraceTest, trace_test
from gspcli.catalogue.kinds import ALL, Kind
from gspcli.catalogue.types import CONSTRAINTS, GspType
from gspcli.certification import certify
from gspcli.continuation.tracked_paths import solve_systems
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import study_from_pose
from gspcli.geometry.random_instances import random_instance
from gspcli.records import dataclass
from gspcli.solver.study_systems import target_systems


@dataclass(frozen=True)
class Tracked:
    """The result of tracking paths to a random platform.

    Attributes
    ----------
    certified
        The number of different poses that are proved to exist.
    trace
        The trace test of the poses that were found; None for both sides.
    """

    certified: int
    trace: TraceTest | None


def tracked(distances: Sequence[Kind], sides: int, seed: int) -> Tracked:
    """Count the poses of one random real platform.

    The poses, complex ones included, are found by tracking paths and proved to be simple in ball
    arithmetic. Simple poses persist when the platform changes, so that their number is a lower
    bound of the generic count.

    Parameters
    ----------
    distances
        The kinds of the distances; the angles are ALL.
    sides
        1 for one side of each DPH and DHP, 2 for both.
    seed
        Source of the random numbers.
    """
    gsp_type = GspType.of([*distances, *[ALL] * (CONSTRAINTS - len(distances))])
    rng = np.random.default_rng([seed, sides, *(kind.order for kind in distances)])
    instance, _ = random_instance(gsp_type, rng, one_sided=sides == 1)
    arrangement = Arrangement.of(instance)
    systems = solve_systems(target_systems(arrangement.normalized), seed=seed)
    R, T = arrangement.poses_of(np.concatenate([found.points for found in systems]))
    certified = certify(instance, R, T).distinct
    if sides == 2:
        return Tracked(certified, None)
    points = np.concatenate(study_from_pose(R, T), axis=-1)
    return Tracked(certified, trace_test(target_systems(arrangement)[0], points, seed))
