"""Laws of the forces of drives; what has none; what results are like."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import gspcli
from gspcli.dynamics import inverse_dynamics, natural_modes
from gspcli.dynamics.mass_model import MassModel
from gspcli.dynamics.moving_bodies import equation_of_motion
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.building import angle, distance
from gspcli.geometry.building import instance as build
from gspcli.geometry.primitives import Line, Plane, Point
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion import measure
from gspcli.motion.statics.wrenches import wrenches
from tests.support.masses import random_motion, random_platform

KINDS = ["6DPP", "DLL DPP DPP DPH DHP DLP", "DPP DPL DLP ALH AHL AHH", "3DLL 3ALL"]
BODY = gspcli.RigidBody(12, [0, 0, 20], [4e4, 4e4, 7e4, 0, 0, 0])
ANGLES = np.radians([0, 20, 120, 140, 240, 260])
RING = np.stack((np.cos(ANGLES), np.sin(ANGLES), 0 * ANGLES), axis=1)
BASE, PLATFORM = 300 * RING, 200 * RING[[5, 0, 1, 2, 3, 4]]


def hexapod(scale=1.0, length="mm", **dynamics):
    """Return the same hexapod with lengths of another size in another unit."""
    made = gspcli.hexapod(BASE * scale, PLATFORM * scale, [200 * scale] * 6, length=length)
    square = scale**2
    body = gspcli.RigidBody(
        12, [1 * scale, 2 * scale, 20 * scale], [4e4 * square, 4e4 * square, 7e4 * square, 0, 0, 0]
    )
    rod = gspcli.LegBody(0.3, 40 * scale, 300 * square, 20 * square)
    cylinder = gspcli.LegBody(0.5, 60 * scale, 700 * square, 50 * square)
    leg = gspcli.Leg(cylinder, rod, [1, 0.2, 0])
    return replace(made, dynamics=gspcli.Dynamics(body, leg, **dynamics))


def test_the_unit_of_length_does_not_matter():
    wide, rates = np.repeat([1.0, 1e-3], 3), np.arange(1.0, 7.0)
    given = {"twists": rates * [1, 1, 1, 100, 100, 100], "accelerations": -10 * rates}
    pose = np.eye(3), np.array([1.0, 2, 150])
    found = inverse_dynamics(hexapod(), *pose, **given)
    metres = {name: rate * wide for name, rate in given.items()}
    other = inverse_dynamics(hexapod(1e-3, "m"), pose[0], pose[1] / 1000, **metres)
    assert np.allclose(found.forces, other.forces, rtol=1e-12)
    assert np.allclose(found.powers, other.powers, rtol=1e-12)
    wrong = inverse_dynamics(hexapod(1e-3, "km"), pose[0], pose[1] / 1000, **metres)
    assert not np.allclose(found.forces, wrong.forces, rtol=0.1)


@pytest.mark.parametrize("name", KINDS)
def test_weights_of_the_platform_are_held_as_analyze_says(name):
    rng = np.random.default_rng(1)
    instance, R, T = random_platform(name, rng, legs=False)
    stated = instance.dynamics
    weight = stated.platform.mass.value * np.array([g.value for g in stated.gravity])
    centre = R @ [c.value for c in stated.platform.centre] + T
    held = wrenches(instance, R, T).reactions(weight, np.zeros(3), centre)
    assert np.allclose(inverse_dynamics(instance, R, T).forces[0], held, rtol=1e-10)


@pytest.mark.parametrize("name", KINDS)
def test_the_mass_matrix_is_positive_definite(name):
    rng = np.random.default_rng(3)
    instance, R, T = random_platform(name, rng)
    model = MassModel.of(instance)
    M, _ = equation_of_motion(model, R, T, model.machine.inverse(R, T), np.zeros(6))
    assert np.array_equal(M, M.T)
    assert np.linalg.eigvalsh(M).min() > 0


def test_no_poses_are_a_mistake():
    with pytest.raises(ArgumentError, match="found no poses, expected at least one"):
        inverse_dynamics(hexapod(), np.zeros((0, 3, 3)), np.zeros((0, 3)))


def test_a_load_is_held():
    found, load = inverse_dynamics(hexapod(), np.eye(3), [0, 0, 150]), [1, 2, 3, 40, 50, 60]
    loaded = inverse_dynamics(hexapod(), np.eye(3), [0, 0, 150], load=load)
    exerted = wrenches(hexapod(), np.eye(3), np.array([0, 0, 150.0]), point=[0, 0, 150])
    rows = exerted.jacobian * np.repeat([1e-3, 1.0], 3)
    assert np.allclose((loaded.forces - found.forces) @ rows, -np.array(load))


def test_a_batch_is_as_one_after_the_other():
    rng = np.random.default_rng(4)
    T = [0, 0, 150] + 10 * rng.normal(size=(1100, 3))
    R = np.tile(np.eye(3), (1100, 1, 1))
    rates = rng.normal(size=(2, 1100, 6))
    found = inverse_dynamics(hexapod(), R, T, twists=rates[0], accelerations=rates[1])
    for k in (0, 499, 500, 1099):
        one = inverse_dynamics(hexapod(), R[k], T[k], twists=rates[0, k], accelerations=rates[1, k])
        assert np.allclose(one.forces[0], found.forces[k], rtol=1e-12)


def test_singular_poses_have_no_force():
    T = [[0, 0, 150.0], [0, 0, 0], [0, 0, 1e-7]]
    found = inverse_dynamics(hexapod(), np.tile(np.eye(3), (3, 1, 1)), T)
    assert found.singular.tolist() == [False, True, False]
    assert np.isnan(found.forces[1]).all()
    assert np.isfinite(found.forces[[0, 2]]).all()
    assert np.isnan(found.nearly_singular[0])
    assert found.nearly_singular[2] > 1e8
    assert found.to_json()["rows"][1]["forces"] == [None] * 6
    assert "at most" in repr(found)
    alone = inverse_dynamics(hexapod(), np.eye(3), [0, 0, 0])
    assert (alone.worst, "all singular" in repr(alone)) == (None, True)


def _with(first, *, others=5):
    """Return a platform whose first constraint is given, in millimetres."""
    legs = [
        distance(Point(p), Point(b), 200)
        for b, p in list(zip(BASE, PLATFORM, strict=True))[:others]
    ]
    made = build([first, *legs], length="mm")
    return replace(made, dynamics=gspcli.Dynamics(BODY))


X, Z = [1, 0, 0], [0, 0, 1]


@pytest.mark.parametrize(
    ("first", "T", "message"),
    [
        (distance(Point([0, 0, 0]), Point([0, 0, 150]), 1), 150, "DPP) is a distance of 0"),
        (distance(Point([9, 0, 0]), Line([0, 0, 150], X), 1), 150, "DPL) is a distance of 0"),
        (distance(Line([0, 0, 0], X), Point([9, 0, 150]), 1), 150, "DLP) is a distance of 0"),
        (distance(Line([0, 0, 0], X), Line([0, 0, 50], X), 1), 150, "distance of parallel lines"),
        (distance(Line([0, 0, 0], X), Line([0, 0, 150], Z), 1), 150, "DLL) is a distance of 0"),
        (angle(Line([0, 0, 0], X), Line([0, 0, 0], X), 1), 150, "ALL) is an angle at the end"),
        (angle(Line([0, 0, 0], Z), Plane([0, 0, 0], Z), 1), 150, "ALH) is an angle at the end"),
        (angle(Plane([0, 0, 0], Z), Plane([0, 0, 0], Z), 1), 150, "AHH) is an angle at the end"),
    ],
)
def test_what_has_no_derivative_has_no_force(first, T, message):
    instance = _with(first)
    poses = np.tile(np.eye(3), (2, 1, 1)), [[0, 3, T + 7.0], [0, 0, T]]
    turned = np.array([[1, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]]) @ np.array(
        [[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]]
    )
    poses[0][0] = turned
    with pytest.raises(ArgumentError, match="row 2: constraint 1") as caught:
        inverse_dynamics(instance, *poses)
    assert message in str(caught.value)
    assert np.isfinite(inverse_dynamics(instance, poses[0][0], poses[1][0]).forces).all()


def test_a_plane_through_the_point_is_no_mistake():
    instance = _with(distance(Point([0, 0, 0]), Plane([0, 0, 150], Z), 0))
    assert np.isfinite(inverse_dynamics(instance, np.eye(3), [0, 0, 150]).forces).all()


def test_a_universal_joint_locks_along_its_axis():
    instance = hexapod()
    (leg,) = instance.dynamics.legs
    along = BASE[0] - PLATFORM[0] - [0, 0, 150]
    turned = gspcli.Leg(leg.cylinder, leg.rod, along.tolist())
    instance = replace(instance, dynamics=gspcli.Dynamics(BODY, [turned, *[leg] * 5]))
    heights = np.linspace(150, 160, 700)[::-1]
    poses = np.tile(np.eye(3), (700, 1, 1)), np.stack((0 * heights, 0 * heights, heights), axis=1)
    for computed in (inverse_dynamics, partial(natural_modes, stiffness=1e6)):
        with pytest.raises(ArgumentError, match="row 700: leg 1 lies along the first axis"):
            computed(instance, *poses)
    assert inverse_dynamics(instance, np.eye(3), [0, 0, 160]).worst is not None


@pytest.mark.parametrize(
    ("instance", "given", "message"),
    [
        (replace(hexapod(), dynamics=None), {}, "found no masses: add `dynamics:`"),
        (hexapod(), {"twists": [0] * 6}, "found one of twists and accelerations"),
        (hexapod(), {"load": [1, 2]}, "load: found shape"),
        (hexapod(), {"t": [0.0, 1.0]}, "t: found shape"),
        (hexapod(length="furlong"), {}, "units.length: found 'furlong', expected m, dm"),
        (
            replace(hexapod(), dynamics=gspcli.Dynamics(BODY, [gspcli.Leg()] * 2)),
            {},
            "dynamics.legs: found 2 legs, expected one for all, or 6",
        ),
    ],
)
def test_mistakes(instance, given, message):
    with pytest.raises(ArgumentError, match=message):
        inverse_dynamics(instance, np.eye(3), [0, 0, 150], **given)


def test_what_a_result_offers():
    t = np.linspace(0, 1, 8)
    T = np.stack((5 * np.sin(t), 0 * t, 150 + t), axis=1)
    found = inverse_dynamics(hexapod(), np.tile(np.eye(3), (8, 1, 1)), T, t=t)
    frame = found.to_frame()
    assert list(frame.columns) == ["t", "F1", "F2", "F3", "F4", "F5", "F6", "power"]
    assert np.array_equal(frame["F3"], found.forces[:, 2])
    assert np.allclose(frame["power"], found.powers.sum(axis=1))
    for name in ("forces", "powers", "R", "T", "t", "twists"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(found, name)[0] = 0
    worst = found.worst
    assert abs(worst.force) == np.abs(found.forces).max()
    assert found.forces[worst.row, worst.drive] == worst.force
    document = json.loads(json.dumps(found.to_json()))
    assert document["worst"]["row"] == worst.row + 1
    assert document["rows"][3]["forces"] == found.forces[3].tolist()
    assert "\n" not in repr(found)
    T[0] = 0
    assert found.T[0, 2] == 150


@pytest.mark.parametrize("name", KINDS)
def test_power_is_force_times_the_rate_of_the_value(name):
    rng = np.random.default_rng(6)
    instance, R, T = random_platform(name, rng)
    t, a = random_motion(instance, rng)
    found = inverse_dynamics(instance, R, T, twists=t, accelerations=a)
    step = 1e-6
    sides = [
        measure(instance, rotation_from_vector(s * t[:3]) @ R, T + s * t[3:]) for s in (-step, step)
    ]
    unit = np.ones(6)
    unit[Arrangement.of(instance).angles] = instance.units.angle.in_radians
    rates = (sides[1] - sides[0]) / (2 * step) * unit
    assert np.allclose(found.powers[0], found.forces[0] * rates, rtol=1e-6, atol=1e-6)
