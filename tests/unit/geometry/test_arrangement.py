"""The numbers of a platform in floating point: frames at the points that are near each other."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.catalogue.kinds import DPP
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import rotation_from_quaternion


def _legs(y: np.ndarray) -> Arrangement:
    zero, one = np.zeros((6, 3)), np.ones(6)
    return Arrangement((DPP,) * 6, y, zero, zero, zero, one, np.zeros(6, int), 1.0)


@pytest.fixture
def points() -> np.ndarray:
    return np.random.default_rng(5).uniform(-1, 1, size=(6, 3))


def test_the_centre_of_points_is_their_mean(points: np.ndarray) -> None:
    assert np.array_equal(_legs(points).platform_centre, points.sum(axis=0) / 6)


def test_far_points_do_not_move_the_centre(points: np.ndarray) -> None:
    points[[1, 4]] *= [[1e5], [-3e6]]
    near = points[[0, 2, 3, 5]].mean(axis=0)
    assert np.array_equal(_legs(points).platform_centre, near)


@pytest.mark.parametrize("together", [2, 3, 5, 6])
def test_nothing_is_far_from_points_that_coincide(points: np.ndarray, together: int) -> None:
    points[:together] = points[0]
    assert np.allclose(_legs(points).platform_centre, points.mean(axis=0), rtol=0, atol=1e-15)


def test_the_centre_moves_with_the_body(points: np.ndarray) -> None:
    points[2] *= 1e4
    R, T = rotation_from_quaternion(np.array([0.3, -0.5, 0.7, 0.1])), np.array([3.0, -2.0, 9.0])
    moved = _legs(points @ R.T + T).platform_centre
    assert np.allclose(moved, R @ _legs(points).platform_centre + T, rtol=0, atol=1e-12)
