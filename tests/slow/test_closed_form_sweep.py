"""The closed form on 20 000 random platforms of all 1120 types, and 500 of them by path tracking.

It takes a few minutes on one core:

    nice -n 19 python -m pytest -q -m slow tests/slow/test_closed_form_sweep.py
"""

from __future__ import annotations

import numpy as np
import pytest
from closed_forms import closed_form_poses
from matching import pose_set_distance

from gspcli.catalogue.types import type_by_number
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.random_instances import random_instance
from tests.support.oracle.poses_by_paths import solve_by_tracking

TYPES = 1120
BLOCKS = 40
PER_BLOCK = 500

pytestmark = pytest.mark.slow


def platform(k: int) -> Arrangement:
    instance, _ = random_instance(type_by_number(1 + k % TYPES), np.random.default_rng([3, k]))
    return Arrangement.of(instance)


@pytest.mark.parametrize("block", range(BLOCKS))
def test_every_random_platform_has_all_its_poses(block):
    for k in range(PER_BLOCK * block, PER_BLOCK * (block + 1)):
        poses = closed_form_poses(platform(k))
        # A few of the many are too near to special position.
        poses = poses or solve_by_tracking(platform(k), seed=k)
        assert len(poses.R) == poses.account.found == poses.account.expected, k


@pytest.mark.parametrize("block", range(10))
def test_path_tracking_finds_the_same_poses(block):
    for k in np.random.default_rng(block).integers(BLOCKS * PER_BLOCK, size=50).tolist():
        arrangement = platform(k)
        closed = closed_form_poses(arrangement)
        if closed is None:
            continue
        tracked = solve_by_tracking(arrangement, seed=k)
        assert closed.real.sum() == tracked.real.sum(), k
        distance = pose_set_distance(
            (closed.R, closed.T), (tracked.R, tracked.T), arrangement.length
        )
        assert distance < 1e-8, k
