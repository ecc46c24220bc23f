"""The nearest pose in a controller: compiled, against the same in Python and by its definition."""

from __future__ import annotations

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

import gspcli
from gspcli.export.controller.writing import controller
from gspcli.geometry.quaternions import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
)
from gspcli.motion import FollowerStatus
from tests.support.independent_machines import Machine, PlaneGeometry, machines
from tests.support.nearest import kept

pytestmark = pytest.mark.skipif(not shutil.which("gcc"), reason="no gcc")
FLAGS = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"]
LEGS = ["workspace-study", "workspace-study-cones", "rubin-m2", "three-rps"]


class State(ctypes.Structure):
    _fields_ = (
        ("position", ctypes.c_double * 3),
        ("rotation", ctypes.c_double * 4),
        ("values", ctypes.c_double * 6),
        ("error", ctypes.c_double),
    )


class Pose(ctypes.Structure):
    _fields_ = (("position", ctypes.c_double * 3), ("rotation", ctypes.c_double * 4))


def machine_of(name: str) -> Machine:
    if name in LEGS:
        instance = gspcli.example(name)
        home = gspcli.solve(instance).home
        return Machine(name, instance, home.R.real, home.T.real, (0, 0))
    return machines()[name]()


def pose_of(R, T) -> Pose:
    return Pose(tuple(T.tolist()), tuple(quaternion_from_rotation(R).tolist()))


def compiled(instance, folder):
    for suffix, text in zip("hc", controller(instance, "p"), strict=True):
        (folder / f"p.{suffix}").write_text(text)
    command = ["gcc", *FLAGS, "-fPIC", "-shared", "p.c", "-o", "libp.so", "-lm"]
    subprocess.run(command, check=True, cwd=folder)
    return ctypes.CDLL(str(folder / "libp.so"))


def keeps(machine: Machine, R, T) -> bool:
    if machine.name in LEGS:
        return kept(machine.instance, R, T)
    return bool(PlaneGeometry(machine).reached(R[None], T[None])[0])


@pytest.mark.parametrize("name", [*LEGS, "reachy 60", "paradex", "mixed"])
def test_the_program_and_python_go_to_the_same_poses_within_the_limits(name, tmp_path):
    machine = machine_of(name)
    library = compiled(machine.instance, tmp_path)
    follower = gspcli.Follower(machine.instance, machine.R, machine.T)
    state = State()
    assert (
        library.p_start(ctypes.byref(pose_of(machine.R, machine.T)), ctypes.byref(state), None) == 0
    )
    draw = np.random.default_rng(11)
    size = np.abs(machine.T).max() or 1.0
    statuses = []
    for _ in range(30):
        R = rotation_from_vector(0.3 * draw.normal(size=3)) @ machine.R
        T = machine.T + 0.15 * size * draw.normal(size=3)
        ours = follower.nearest(R, T)
        theirs = library.p_nearest(ctypes.byref(pose_of(R, T)), ctypes.byref(state), None)
        assert theirs == ours
        assert np.allclose(state.position, follower.T, rtol=0, atol=1e-12 * size)
        assert np.allclose(state.rotation, follower.quaternion, rtol=0, atol=1e-12)
        assert np.allclose(state.values, follower.values, rtol=1e-12, atol=1e-12)
        # Wherever it is, it is within the limits.
        assert keeps(machine, follower.R, follower.T)
        statuses.append(ours)
    assert statuses.count(FollowerStatus.PROVED) > 10


def test_the_nearest_pose_is_that_of_the_search_from_many_poses():
    machine = machine_of("workspace-study")
    draw = np.random.default_rng(12)
    nearest = gspcli.NearestPoses(machine.instance, machine.R, machine.T)
    for _ in range(10):
        R = rotation_from_vector(0.2 * draw.normal(size=3)) @ machine.R
        T = machine.T + 0.2 * nearest.length * draw.normal(size=3)
        follower = gspcli.Follower(machine.instance, machine.R, machine.T)
        assert follower.nearest(R, T) is FollowerStatus.PROVED
        assert np.abs(follower.T - nearest.of(R, T).T).max() < 1e-6 * nearest.length


def test_a_pose_within_the_limits_is_taken_as_it_is():
    machine = machine_of("workspace-study-cones")
    follower = gspcli.Follower(machine.instance, machine.R, machine.T)
    T = machine.T + np.array([1.0, 2.0, 3.0])
    assert follower.nearest(machine.R, T) is FollowerStatus.PROVED
    assert np.abs(follower.T - T).max() < 1e-9


def test_a_controller_that_is_sent_far_away_comes_back():
    """It does not stay where it was led: each request counts alone."""
    machine = machine_of("workspace-study")
    follower = gspcli.Follower(machine.instance, machine.R, machine.T)
    for away in ([500.0, 0, 0], [0, 0, 900.0], [0, -700.0, -100.0]):
        assert follower.nearest(machine.R, machine.T + np.array(away)) is FollowerStatus.PROVED
        assert np.abs(follower.T - machine.T).max() > 10
    assert follower.nearest(machine.R, machine.T) is FollowerStatus.PROVED
    assert np.abs(follower.T - machine.T).max() < 1e-6


def test_a_pose_beyond_singular_ones_is_not_reached():
    machine = machine_of("workspace-study")
    follower = gspcli.Follower(machine.instance, machine.R, machine.T)
    over = np.diag([1.0, -1.0, -1.0]) @ machine.R
    assert follower.nearest(over, machine.T) is not FollowerStatus.PROVED
    assert kept(machine.instance, follower.R, follower.T)
    det = np.linalg.det(follower.jacobian)
    assert det * np.linalg.det(gspcli.Follower(machine.instance, machine.R, machine.T).jacobian) > 0


def test_what_is_no_pose_moves_nothing():
    machine = machine_of("rubin-m2")
    follower = gspcli.Follower(machine.instance, machine.R, machine.T)
    before = follower.T.tolist()
    status = follower._controller.nearest(np.array([np.nan, 0, 0, 1, 0, 0, 0]))
    assert status == FollowerStatus.NOT_FINITE
    status = follower._controller.nearest(np.zeros(7))
    assert status == FollowerStatus.NOT_FINITE
    assert follower.T.tolist() == before
    with pytest.raises(gspcli.ArgumentError, match="expected one pose"):
        follower.nearest(np.stack([machine.R] * 2), np.zeros((2, 3)))


def test_rotations_of_quaternions_agree():
    """The header's quaternion is scalar first, as in the package."""
    machine = machine_of("rubin-m2")
    follower = gspcli.Follower(machine.instance, machine.R, machine.T)
    follower.nearest(machine.R, machine.T)
    assert np.abs(rotation_from_quaternion(follower.quaternion) - machine.R).max() < 1e-9
