"""None"""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import moved
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import rotation_from_quaternion, rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import measure, track
from gspcli.motion.paths.nearest_poses import NearestPoses
from gspcli.motion.poses.inverse_kinematics import _CHUNK, drive_values, refusals, values_at
from gspcli.resources import data_path
from tests.support.driven_machines import crank_angles
from tests.support.surface_machines import tripod


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


@pytest.fixture(scope="module")
def head():
    return gspcli.load(data_path("platforms", "t-top-head.yaml"))


def poses(rows):
    """A smooth trajectory about a pose that the head reaches."""
    t = np.linspace(0, 1, rows)
    R = rotation_from_vector(np.stack([0.2 * t, -0.1 * np.sin(t), 0.15 * t**2], axis=1))
    return R, np.stack([0.005 * t, 0 * t, 0.17 + 0.01 * t], axis=1)


def test_the_legs_have_their_lengths_at_the_angles(head):
    R, T = poses(7)
    cranks, angles = crank_angles(head, R, T)
    assert [one.name for one in cranks] == [f"crank.B{k}" for k in range(1, 7)]
    lengths = [row.value.value for row in head.constraints]
    for row, pose in zip(angles, zip(R, T, strict=True), strict=True):
        assert measure(moved(head, cranks, row), *pose) == pytest.approx(lengths, abs=1e-14)
    # The arms move on; none changes to its other elbow.
    assert (np.abs(np.diff(angles, axis=0)) < 30).all()


def test_following_the_angles_leads_through_the_poses(head):
    R, T = poses(3)
    cranks, angles = crank_angles(head, R, T)
    values = np.tile([row.value.value for row in head.constraints], (3, 1))
    columns = {one.name: column for one, column in zip(cranks, angles.T, strict=True)}
    found = track(head, values, coordinates=columns, near=(R[0], T[0]))
    assert found.certified
    assert found.events == ()
    assert np.allclose(found.T[0], T, atol=1e-12)
    assert np.allclose(found.R[0], R, atol=1e-10)


def test_what_is_out_of_reach_has_no_angle_and_others_are_as_before(head):
    R, T = poses(3)
    T[1, 2] = 1.0
    angles = crank_angles(head, R, T)[1]
    assert np.isnan(angles[1]).all()
    assert np.allclose(angles[[0, 2]], crank_angles(head, R[[0, 2]], T[[0, 2]])[1])


def test_poses_for_themselves_have_the_angles_nearest_to_those_stated(head):
    R, T = poses(5)
    R, T = np.concatenate((R, R[::-1])), np.concatenate((T, T[::-1]))
    T[3, 2] = 1.0
    angles = crank_angles(head, R, T, along=False)[1]
    alone = [crank_angles(head, *pose)[1][0] for pose in zip(R, T, strict=True)]
    assert np.isnan(angles[3]).all()
    assert np.allclose(angles, alone, atol=1e-9, equal_nan=True)


def test_values_that_no_motor_changes_must_hold():
    """Tilted as it stands the machine cannot be; a little to the side it can."""
    instance = tripod()
    q = np.array([0.9939567578492872, 0.0981833530726402, 0.0490916765363201, 0.0])
    R = rotation_from_quaternion(q)
    drives, found = drive_values(instance, R[None], np.array([[0, 0, 4.25]]))
    assert np.isnan(found[0]).tolist() == [False, True] * 3
    assert refusals(drives, R[None], np.array([[0, 0, 4.25]]), found) == {
        0: "value 2 is -0.0301249 and stays at 0; value 4 is -0.00450425 and stays at 0; "
        "value 6 is 0.0346292 and stays at 0"
    }
    # The distances are linear in the place.
    off = values_at(instance, R[None], np.array([[0, 0, 4.25]]))[0, 1::2]
    normals = np.array([row.base.unit for row in instance.constraints[1::2]])
    shift = np.linalg.lstsq(normals, -off, rcond=None)[0]
    T = np.array([0, 0, 4.25]) + shift
    assert pytest.approx([0.030125, 0.022594, 4.25], abs=1e-6) == T
    _, found = drive_values(instance, R[None], T[None])
    assert np.degrees(found[0, ::2]) == pytest.approx([-19.3377, 1.1980, 20.8214], abs=1e-4)
    nearest = NearestPoses(instance, np.eye(3), np.array([0, 0, 4.25])).of(R, [0, 0, 4.25])
    assert nearest.shift > 0.01
    assert np.abs(values_at(instance, nearest.R[None], nearest.T[None])[0, 1::2]).max() < 1e-9
    with pytest.raises(ArgumentError, match=r"pose 1 of 1: value 2 is -0.0301249 and stays at 0"):
        gspcli.analyze(instance, R, np.array([0, 0, 4.25]))
