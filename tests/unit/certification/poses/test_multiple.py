"""Multiple poses: found to many digits, and never where a simple one is."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from gspcli.certification.equations.local_frames import OWN
from gspcli.certification.poses.locator import Locator
from gspcli.certification.poses.multiple import multiple_poses
from gspcli.geometry.quaternions import study_from_pose

SIDES = (0,) * 6
#: Starts are known in doubles.
NO_MORE = np.zeros((1, 0, 8))


def start(T: list[float], error: float) -> np.ndarray:
    exact = np.concatenate(study_from_pose(np.eye(3), np.array(T)))
    shake = np.random.default_rng(5).standard_normal((2, 8))
    return exact + error * (shake[0] + 1j * shake[1])


def found(instance, error, T=(1, 0, 0)):
    locator = Locator(instance, OWN)
    return list(multiple_poses(locator, start(list(T), error)[None], NO_MORE, [2], SIDES))


def test_a_double_pose_is_found_to_all_digits_of_a_double(tangent):
    for error in (1e-5, 1e-9):
        [pose] = found(tangent(Fraction(1)), error)
        assert pose.real
        assert pose.multiplicity == 2
        np.testing.assert_allclose(pose.R, np.eye(3), atol=1e-15)
        np.testing.assert_allclose(pose.T, [1, 0, 0], atol=1e-15)


def test_two_simple_poses_side_by_side_are_none(tangent):
    assert found(tangent(1 + Fraction(1, 10**14)), 1e-9) == []
    assert found(tangent(1 - Fraction(1, 10**14)), 1e-9) == []


def test_a_limit_far_away_is_another_pose(tangent):
    assert found(tangent(Fraction(1)), 1e-9, T=(1, 0, 0.5)) == []


def test_one_pose_approached_twice_is_one(tangent):
    locator = Locator(tangent(Fraction(1)), OWN)
    starts = np.array([start([1, 0, 0], 1e-6), start([1, 0, 0], 1e-7)])
    [pose] = multiple_poses(locator, starts, NO_MORE.repeat(2, 0), [2, 2], SIDES)
    assert pose.multiplicity == 4


def test_a_double_pose_that_is_known_from_the_beginning_is_found(tangent):
    locator, exact = Locator(tangent(Fraction(1)), OWN), start([1, 0, 0], 0.0)
    more = 1e-40 * np.random.default_rng(6).standard_normal((1, 1, 8))
    [pose] = multiple_poses(locator, exact[None], more, [2], SIDES)
    assert pose.real
