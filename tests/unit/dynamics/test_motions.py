"""Natural frequencies where the answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.dynamics import inverse_dynamics, natural_modes
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.building import distance
from gspcli.geometry.building import instance as build
from gspcli.geometry.primitives import Plane, Point
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion import measure
from tests.support.masses import random_platform
from tests.unit.dynamics.test_forces import hexapod

START = np.eye(3), np.array([0, 0, 150.0])


def test_frequencies_that_are_known_by_hand():
    """A block in a 3-2-1 fixture of springs: no motion is coupled to another."""
    arm, k, mass, low, high = 2.0, 1e5, 12.0, 3.0, 5.0
    x, y, z = np.eye(3)
    corners = [arm * np.array([np.cos(s), np.sin(s), 0]) for s in np.radians([0, 120, 240])]
    touched = [(p, z) for p in corners] + [(arm * x, y), (-arm * x, y), (0 * x, x)]
    rows = [distance(Point(p), Plane((p - n).tolist(), n.tolist()), 1) for p, n in touched]
    body = gspcli.RigidBody(mass, [0, 0, 0], [low, low, high, 0, 0, 0])
    instance = replace(build(rows, length="m"), dynamics=gspcli.Dynamics(body, gravity=[0, 0, 0]))
    found = natural_modes(instance, np.eye(3), np.zeros(3), stiffness=k)
    turns = [1.5 * arm**2 / low, 1.5 * arm**2 / low, 2 * arm**2 / high]
    expected = k * np.sort([1 / mass, 2 / mass, 3 / mass, *turns])
    assert np.allclose(found.squares[0], expected, rtol=1e-12)
    assert np.allclose(np.abs(found.shapes[0, 0]), [0, 0, 0, Arrangement.of(instance).length, 0, 0])


@pytest.mark.parametrize("name", ["6DPP", "DPP DPL DLP ALH AHL AHH"])
def test_shapes_are_what_a_small_motion_does(name):
    """K x = w^2 M x, with the accelerations that springs give for a small shape."""
    rng = np.random.default_rng(5)
    instance, R, T = random_platform(name, rng, worst=20)
    found = natural_modes(instance, R, T, stiffness=1e7)
    radian = np.where(
        [row.kind.is_distance for row in instance.constraints], 1.0, instance.units.angle.in_radians
    )
    for square, shape in zip(found.squares[0], found.shapes[0], strict=True):
        left = []
        for s in (-1e-5, 1e-5):
            pose = rotation_from_vector(s * shape[:3]) @ R, T + s * shape[3:]
            off = (measure(instance, *pose) - measure(instance, R, T)) * radian
            springs = found.preload[0] - 1e7 * off
            needed = inverse_dynamics(instance, *pose, twists=0, accelerations=-s * square * shape)
            left.append(needed.forces[0] - springs)
        assert np.abs(left[1] - left[0]).max() < 1e-5 * np.abs(1e7 * off).max()


def test_soft_drives_do_not_hold_the_platform_up():
    found = natural_modes(hexapod(), *START, stiffness=10)
    assert found.squares[0, 0] < 0
    assert found.frequencies[0, 0] < 0
    stiff = natural_modes(hexapod(), *START, stiffness=1e6)
    assert (stiff.squares > 0).all()


def test_singular_poses_have_no_modes():
    poses = np.tile(np.eye(3), (2, 1, 1)), [[0, 0, 150.0], [0, 0, 0]]
    found = natural_modes(hexapod(), *poses, stiffness=[1e6] * 6)
    assert found.singular.tolist() == [False, True]
    assert np.isnan(found.frequencies[1]).all()
    assert found.to_json()["rows"][1]["frequencies"] == [None] * 6
    assert list(found.to_frame().columns) == ["row", "f1", "f2", "f3", "f4", "f5", "f6"]
    assert "2 poses" in repr(found)


@pytest.mark.parametrize(
    ("stiffness", "message"),
    [(None, "found no stiffness: state drives"), (-1.0, "expected stiffnesses above 0")],
)
def test_a_stiffness_is_needed(stiffness, message):
    with pytest.raises(ArgumentError, match=message):
        natural_modes(hexapod(), *START, stiffness=stiffness)
