"""Motions of platforms whose poses are infinitely many."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.catalogue.kinds import AHH, DPP
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.local_motions import local_motion
from gspcli.geometry.measurement import measured, residuals
from gspcli.geometry.quaternions import rotation_from_quaternion


def legs(y: np.ndarray, x: np.ndarray, R: np.ndarray, T: np.ndarray) -> Arrangement:
    given = Arrangement(
        kinds=(DPP,) * 6,
        y=y,
        x=x,
        u=np.zeros_like(y),
        v=np.zeros_like(x),
        values=np.zeros(6),
        sides=np.zeros(6, dtype=np.int64),
        in_radians=1.0,
    )
    return given.with_values(measured(given, R, T))


@pytest.fixture
def pose():
    return rotation_from_quaternion(np.array([0.9, 0.1, -0.3, 0.2])), np.array([0.3, 1.0, 2.0])


def test_a_platform_in_general_position_does_not_move(pose):
    y, x = np.random.default_rng(1).uniform(-1, 1, (2, 6, 3))
    assert local_motion(legs(y, x, *pose), *pose) is None


def test_congruent_bodies_with_parallel_legs_move_on_a_sphere():
    x = np.random.default_rng(2).uniform(-1, 1, (6, 3))
    R, T = np.eye(3), np.array([0.0, 0.6, 0.8])
    given = legs(x, x, R, T)
    motion = local_motion(given, R, T)
    assert motion is not None
    assert motion.real
    # The kernel is larger than the set: as many as independent steps were found.
    assert 1 <= motion.dimension <= 2
    assert len(motion.R) > 10
    np.testing.assert_allclose(motion.T[0], T, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(motion.T, axis=1), 1, atol=1e-9)
    assert residuals(given, motion.R, motion.T).max() < 1e-9


def test_legs_to_two_points_of_the_platform_leave_a_rotation(pose):
    """The axis through the two points: dimension one, and the points stay."""
    rng = np.random.default_rng(3)
    ends, x = rng.uniform(-1, 1, (2, 3)), rng.uniform(-1, 1, (6, 3))
    y = np.concatenate([np.tile(ends[:1], (3, 1)), np.tile(ends[1:], (3, 1))])
    given = legs(y, x, *pose)
    motion = local_motion(given, *pose)
    assert motion is not None
    assert (motion.dimension, motion.real) == (1, True)
    placed = motion.R @ ends.T + motion.T[:, :, None]
    np.testing.assert_allclose(placed, np.broadcast_to(placed[0], placed.shape), atol=1e-9)
    turned = np.linalg.norm(np.diff(motion.R, axis=0), axis=(1, 2))
    assert (turned > 0.01).all()


def test_a_leg_stretched_as_far_as_it_goes():
    """Five legs of length zero at one point, and one that reaches no farther: it can turn still."""
    near, far, middle = (np.array(p, float) for p in ((1, 2, 3), (4, 1, 0), (1, 2, 6)))
    y, x = np.tile(near, (6, 1)), np.tile(far, (6, 1))
    y[5], x[5] = middle, far + np.array([0, 0, 7])
    given = legs(y, x, np.eye(3), far - near).with_values(np.array([0.0] * 5 + [10.0]))
    rough = rotation_from_quaternion(np.array([0.9, 0.1, -0.3, 0.2]))
    motion = local_motion(given, rough, far - near)
    assert motion is not None
    assert (motion.dimension, motion.real) == (1, True)
    # The direction from the point to the end of the leg is known to half of the digits only.
    ends = motion.R @ (middle - near)
    np.testing.assert_allclose(ends, np.broadcast_to((0, 0, -3), ends.shape), atol=1e-4)
    assert residuals(given, motion.R, motion.T).max() < 1e-8


def test_angles_at_the_end_of_their_range_hold_directions():
    """Planes that stay parallel: the one polynomial is singular there, the motions are not."""
    rng = np.random.default_rng(4)
    normal = np.array([0.0, 0.0, 1.0])
    zero = np.zeros((6, 3))
    kinds = (DPP, DPP, DPP, AHH, AHH, AHH)
    directions = np.tile(normal, (6, 1))
    given = Arrangement(
        kinds=kinds,
        y=np.concatenate([rng.uniform(-1, 1, (3, 3)), zero[:3]]),
        x=np.concatenate([rng.uniform(-1, 1, (3, 3)), zero[:3]]),
        u=directions,
        v=directions,
        values=np.zeros(6),
        sides=np.zeros(6, dtype=np.int64),
        in_radians=1.0,
    )
    R, T = np.eye(3), np.array([0.2, 0.1, 1.5])
    given = given.with_values(measured(given, R, T))
    motion = local_motion(given, R, T)
    assert motion is not None
    assert motion.dimension == 1
    np.testing.assert_allclose(motion.R[:, 2, 2], 1, atol=1e-9)
    assert residuals(given, motion.R, motion.T)[:, :3].max() < 1e-8
