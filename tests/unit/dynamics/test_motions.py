"""Motions under forces, and natural frequencies, where the answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.dynamics import (
    drives,
    forward,
    forward_dynamics,
    inverse_dynamics,
    natural_modes,
    simulate,
)
from gspcli.errors import ArgumentError, IncompleteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.building import distance
from gspcli.geometry.building import instance as build
from gspcli.geometry.primitives import Plane, Point
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion import measure
from tests.support.masses import random_platform
from tests.unit.dynamics.test_drive_forces import hexapod

pytest.importorskip("scipy")
START = np.eye(3), np.array([0, 0, 150.0])


def test_without_forces_it_falls_and_keeps_its_spin():
    instance = hexapod()
    body = replace(instance.dynamics.platform)
    instance = replace(instance, dynamics=gspcli.Dynamics(body, gravity=[1, 0, -9]))
    twist, times = np.array([0.3, 0.2, 0.5, 10, 20, 30]), np.linspace(0, 0.1, 5)
    found = simulate(instance, *START, times, np.zeros(6), twist=twist)
    centre = np.array([1.0, 2, 20])
    places = found.T + found.R @ centre
    # The centre of mass, in mm, moves as a stone would.
    speed = twist[3:] + np.cross(twist[:3], centre)
    expected = places[0] + np.outer(times, speed) + np.outer(times**2 / 2, [1000, 0, -9000])
    assert np.allclose(places, expected, rtol=1e-10)
    inertia = np.diag([4e4, 4e4, 7e4])
    spins = np.einsum("nij,jk,nlk,nl->ni", found.R, inertia, found.R, found.twists[:, :3])
    assert np.allclose(spins, spins[0], rtol=1e-9)


def _energy(seconds, rows):
    instance = hexapod(drives=gspcli.Drives(0.3))
    held = inverse_dynamics(instance, *START).forces[0]
    times = np.linspace(0, seconds, rows)
    forces = held * (1 + 0.01 * np.sin(40 * times)[:, None])
    return simulate(instance, *START, times, forces, twist=[0.02, 0.01, 0.03, 1, 2, 1])


def test_the_work_of_the_drives_is_the_change_of_the_energy():
    found = _energy(0.3, 7)
    assert found.energy_error < 1e-10
    assert np.ptp(found.work) > 1e-4
    again = inverse_dynamics(
        found.instance, found.R, found.T, twists=found.twists, accelerations=found.accelerations
    )
    assert np.allclose(again.forces, found.forces, rtol=1e-9)
    assert not np.allclose(found.kinetic, found.kinetic[0])


@pytest.mark.slow
def test_energy_over_ten_seconds():
    assert _energy(10.0, 3).energy_error < 1e-9


def test_what_a_motion_offers():
    found = _energy(0.02, 3)
    frame = found.to_frame()
    assert list(frame.columns[:4]) == ["t", "x", "y", "z"]
    # Degrees outside, radians inside.
    assert np.allclose(frame["wz"], np.degrees(found.twists[:, 2]))
    assert "3 rows" in repr(found)
    assert found.to_json()["rows"][2]["z"] == found.T[2, 2]
    with pytest.raises(ValueError, match="read-only"):
        found.T[0] = 0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"t": [0.0]}, "expected \\(n,\\): two times at least"),
        ({"t": [0, 2, 1.0]}, "expected times that increase"),
        ({"forces": np.zeros(5)}, "forces: found shape"),
        ({"twist": [0, 0, np.nan, 0, 0, 0]}, "twist\\[2\\]: found nan"),
    ],
)
def test_mistakes(given, message):
    arguments = {"t": [0, 1.0], "forces": np.zeros(6), "twist": np.zeros(6)} | given
    with pytest.raises(ArgumentError, match=message):
        simulate(hexapod(), *START, **arguments)


def test_a_motion_that_cannot_be_followed_is_no_motion(monkeypatch):
    monkeypatch.setattr(forward, "_MOST_CALLS", 60)
    with pytest.raises(IncompleteError, match="cannot be followed beyond t = 0"):
        simulate(hexapod(), *START, [0, 10.0], np.zeros(6))


def test_forces_that_do_not_hold_the_platform_end_it_early(monkeypatch):
    """By the rate at which it goes on, not after all evaluations that there may be."""
    monkeypatch.setattr(forward, "_FIRST_CALLS", 300)
    calls, found = [], forward._accelerations
    monkeypatch.setattr(forward, "_accelerations", lambda *a: calls.append(0) or found(*a))
    with pytest.raises(IncompleteError, match="too wild there\ngive forces that hold"):
        simulate(hexapod(), *START, [0, 10.0], [1e9, -1e9] * 3)
    assert len(calls) < 1000


def test_a_motion_that_meets_a_value_without_derivative_ends_there(monkeypatch):
    """A leg's length, above zero at the start, is taken for zero from a little less on."""
    monkeypatch.setattr(drives, "_ZERO", 0.65)
    with pytest.raises(IncompleteError, match="ends between t = 0 and 1: constraint"):
        simulate(hexapod(), *START, [0, 1.0], np.zeros(6))


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
        a = []
        for s in (-1e-5, 1e-5):
            pose = rotation_from_vector(s * shape[:3]) @ R, T + s * shape[3:]
            off = (measure(instance, *pose) - measure(instance, R, T)) * radian
            a.append(forward_dynamics(instance, *pose, np.zeros(6), found.preload[0] - 1e7 * off))
        bent = (a[1] - a[0])[0] / 2e-5
        assert np.allclose(
            bent, -square * shape, rtol=1e-5, atol=1e-5 * abs(square) * np.abs(shape).max()
        )


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
