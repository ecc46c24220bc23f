from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.catalogue.types import type_by_number
from gspcli.certification.branches.curves import prove_fold
from gspcli.defaults import SEED
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import MovingPlatform, measure, track
from gspcli.motion.following.branch_follower import at_values
from gspcli.resources import data_path

#: The two modes of the example meet and vanish on the way.
VALUES = np.array([[2.53, 2.08, 0.93, 1.97, 1.46, 1.73], [2.6, 2.0, 1.0, 1.9, 1.46, 1.73]])


@pytest.fixture(scope="module")
def platform():
    return MovingPlatform(gspcli.load(data_path("examples", "platform-6-6.yaml")))


@pytest.fixture(scope="module")
def fold(platform):
    event = track(platform.instance, VALUES, t=[0, 1]).events[0]
    at = VALUES[0] + event.low * (VALUES[1] - VALUES[0])
    point = platform.points(event.R, event.T)
    jacobian = platform.jacobian(point, platform.internal(at))
    direction = np.linalg.svd(np.vstack((jacobian, point)))[2][-1]
    return prove_fold(platform.system, (VALUES[0], VALUES[1]), event.low, point, direction)


def points_at(platform, part):
    """Both modes at a part of the way, with the sign of the fold's point."""
    modes = gspcli.solve(at_values(platform.instance, VALUES[0] + part * (VALUES[1] - VALUES[0])))
    return platform.points(modes.R[modes.real].real, modes.T[modes.real].real)


def test_the_two_modes_before_a_fold_are_on_its_two_sides(platform, fold):
    assert fold.bends == -1
    part = fold.low - 1e-9
    points = points_at(platform, part)
    points *= np.sign(points @ fold.point)[:, None]
    assert sorted(fold.sides(points, part, 1e-9)) == [-1, 1]
    # Too vague for one side.
    assert fold.sides(points + 1e-4, part, 1e-3) == [0, 0]


def test_two_modes_far_from_the_fold_are_on_its_two_sides(platform, fold):
    assert sorted(fold.sides(points_at(platform, 0.0), 0.0, 1e-9)) == [-1, 1]


def test_the_sides_of_a_fold_where_lines_are_nearly_parallel():
    """Here the derivatives change much, but hardly when they are multiplied by the inverse."""
    gsp_type = type_by_number(411)
    rng = np.random.default_rng((SEED, 411, 35))
    instance, (R, T) = random_instance(gsp_type, rng)
    turned = rotation_from_vector(0.3 * rng.normal(size=3)) @ R
    rows = np.stack(
        [measure(instance, R, T), measure(instance, turned, T + 0.3 * rng.normal(size=3))]
    )
    platform, part = MovingPlatform(instance), 0.3886748
    modes = gspcli.solve(at_values(instance, rows[0] + part * (rows[1] - rows[0])))
    points = platform.points(modes.R[modes.real].real, modes.T[modes.real].real)
    apart = np.linalg.norm(points[:, None] - points, axis=2) + np.eye(len(points))
    pair = points[list(np.unravel_index(apart.argmin(), apart.shape))]
    middle, direction = pair.mean(axis=0), pair[1] - pair[0]
    fold = prove_fold(platform.system, (rows[0], rows[1]), part, middle, direction)
    assert fold.bends == -1
    assert part < fold.low
    assert fold.sides(pair, part, 1e-9) in ([-1, 1], [1, -1])


def test_another_motion_is_on_no_side(platform, fold):
    part = fold.low - 1e-9
    for point in points_at(platform, part):
        other = platform.points(np.eye(3), np.ones(3))
        assert fold.sides(np.stack([other, np.roll(point, 1)]), part, 1e-9) == [0, 0]
