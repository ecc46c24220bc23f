from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.errors import GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import measure
from gspcli.motion.poses.inverse_kinematics import _CHUNK
from gspcli.resources import data_path


def test_batches_of_any_shape_are_measured_as_single_poses():
    rng = np.random.default_rng(3)
    instance, _ = random_instance(gspcli.parse_type("DPP DPL DPH DLL ALL ALH"), rng)
    R = rotation_from_quaternion(rng.normal(size=(3, _CHUNK, 4)))
    T = rng.normal(size=(3, _CHUNK, 3))
    values = measure(instance, R, T)
    assert values.shape == (3, _CHUNK, 6)
    arrangement = Arrangement.of(instance)
    single = measured(arrangement, R[2, -1], T[2, -1])
    single[4:] *= 180 / np.pi
    single[3] = abs(single[3])
    assert np.allclose(values[2, -1], single, atol=1e-13)
    assert (values[..., 2] < 0).any()
    assert (values[..., [0, 1, 3]] >= 0).all()
    assert measure(instance, R[:0], T[:0]).shape == (0, _CHUNK, 6)


def test_example_has_its_values():
    instance = gspcli.load(data_path("examples", "example-6.8.yaml"))
    poses = gspcli.solve(instance)
    values = gspcli.measure(instance, poses.R.real, poses.T.real)
    assert np.allclose(values, [c.value.value for c in instance.constraints], atol=1e-12)


@pytest.mark.parametrize(
    ("R", "T", "message"),
    [
        (np.eye(4), np.zeros(3), "expected"),
        (np.eye(3), [0, np.nan, 0], r"T\[1\]: found nan, expected a finite number"),
        (np.full((1, 3, 3), np.inf), np.zeros((1, 3)), r"R\[0, 0, 0\]: found inf"),
        (2 * np.eye(3), np.zeros(3), "R: found a matrix that is no rotation"),
        ([np.eye(3), np.diag([1, 1, -1])], np.zeros((2, 3)), r"R\[1\]: found a matrix that is no"),
    ],
)
def test_mistakes_are_named(R, T, message):
    instance = gspcli.load(data_path("examples", "platform-6-6.yaml"))
    with pytest.raises(GspError, match=message):
        measure(instance, R, T)
