from __future__ import annotations

import numpy as np
import pytest

from gspcli.geometry.quaternions import (
    apply,
    conjugate,
    dot,
    pose_from_study,
    quaternion_from_rotation,
    quaternion_product,
    rotation_from_quaternion,
    rotation_from_vector,
    study_from_pose,
)


def quaternions(field: str, count: int = 20) -> np.ndarray:
    rng = np.random.default_rng(3)
    e = rng.normal(size=(count, 4))
    return e + 1j * rng.normal(size=e.shape) if field == "complex" else e


@pytest.mark.parametrize("field", ["real", "complex"])
class TestPoses:
    def test_rotations_are_orthogonal(self, field):
        R = rotation_from_quaternion(quaternions(field))
        np.testing.assert_allclose(
            np.swapaxes(R, -1, -2) @ R, np.tile(np.eye(3), (20, 1, 1)), atol=1e-12
        )
        np.testing.assert_allclose(np.linalg.det(R), 1, atol=1e-12)

    def test_a_rotation_turns_as_its_quaternion(self, field):
        e = quaternions(field)
        x = np.random.default_rng(4).normal(size=(20, 3))
        pure = np.concatenate((np.zeros((20, 1)), x), axis=1)
        turned = quaternion_product(quaternion_product(e, pure), conjugate(e))
        R = rotation_from_quaternion(e)
        np.testing.assert_allclose(turned[:, 1:] / dot(e, e)[:, None], apply(R, x), rtol=1e-9)

    def test_quaternion_round_trip(self, field):
        R = rotation_from_quaternion(quaternions(field))
        e = quaternion_from_rotation(R)
        np.testing.assert_allclose(dot(e, e), 1, atol=1e-12)
        np.testing.assert_allclose(rotation_from_quaternion(e), R, atol=1e-12)

    def test_study_round_trip(self, field):
        R = rotation_from_quaternion(quaternions(field))
        T = quaternions(field)[:, 1:]
        e, f = study_from_pose(R, T)
        np.testing.assert_allclose(dot(e, f), 0, atol=1e-12)
        back_R, back_T = pose_from_study((2 - 1j) * e, (2 - 1j) * f)
        np.testing.assert_allclose(back_R, R, atol=1e-12)
        np.testing.assert_allclose(back_T, T, atol=1e-12)

    def test_batches_equal_loops(self, field):
        e = quaternions(field, 6).reshape(2, 3, 4)
        R = rotation_from_quaternion(e)
        assert R.shape == (2, 3, 3, 3)
        np.testing.assert_allclose(R[1, 2], rotation_from_quaternion(e[1, 2]), rtol=1e-12)
        np.testing.assert_allclose(
            quaternion_from_rotation(R)[1, 2], quaternion_from_rotation(R[1, 2]), rtol=1e-12
        )


def test_quaternions_of_half_turns_have_a_canonical_sign():
    for axis in np.eye(3):
        R = 2 * np.outer(axis, axis) - np.eye(3)
        np.testing.assert_allclose(quaternion_from_rotation(R), [0, *axis], atol=1e-15)


def test_rotation_vector_about_an_axis():
    turn = rotation_from_vector(np.array([0, 0, np.pi / 2]))
    np.testing.assert_allclose(turn, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)
    np.testing.assert_array_equal(rotation_from_vector(np.zeros(3)), np.eye(3))
