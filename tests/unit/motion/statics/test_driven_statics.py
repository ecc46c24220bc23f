"""Torques, stiffness and errors through cranks and slides, against differences and energies."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.dynamics.analyses import analyze
from gspcli.errors import ArgumentError
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.spec import loads
from gspcli.spec.motor_files import motor_file

ROTARY = "base=80,12 platform=55,10 horn=24 rod=130 axis-angle=10"
DELTA = "base=200,0 platform=50,30 rod=250 rails=3 tilt=5"
POSE = rotation_from_vector(np.array([0.1, -0.05, 0.08]))


def rotary(more=""):
    text = motor_file("rotary", ROTARY.split())
    if more:
        text = text.replace("range: [-60, 60]", f"range: [-60, 60], {more}")
    return loads(text)


def newton(drives, q, lengths, R, T):
    """Return the pose near another one for numbers of drives and lengths of rods."""
    for _ in range(20):
        arrangement = drives.arrangement(q)
        off = lengths - measured(arrangement, R, T)
        t = np.linalg.solve(jacobian(arrangement, R, T), off)
        R, T = rotation_from_vector(t[:3]) @ R, T + t[3:]
    return R, T


def turned_and_shifted(before, after, point):
    """Return the small twist from one pose to another, of a point fixed in the platform."""
    turn = after[0] @ before[0].T
    omega = (
        np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    )
    arm = before[0].T @ (point - before[1])
    return np.concatenate((omega, after[0] @ arm + after[1] - point))


def test_torques_do_the_work_that_the_load_takes():
    instance = rotary()
    drives = Machine.of(instance)
    R, T = POSE, instance.home.T + np.array([4.0, -3, 2])
    load = np.array([1.0, -2, -10, 30, -20, 50])
    found = analyze(instance, R, T, load=load)
    q = drives.inverse(R, T)
    point = found.given.point[0]
    h = 1e-4
    for k in range(6):
        step = np.eye(6)[k] * h
        ends = [newton(drives, q + s * step, drives.rods, R, T) for s in (-1, 1)]
        twist = (
            turned_and_shifted((R, T), ends[1], point) - turned_and_shifted((R, T), ends[0], point)
        ) / (2 * h)
        work = load[:3] @ twist[3:] + load[3:] @ twist[:3]
        assert found.torques[0, k] + work == pytest.approx(0, abs=1e-5 * np.abs(load).max() * 24)


def test_of_a_delta_three_forces_hold_a_force():
    instance = loads(motor_file("linear", DELTA.split()))
    T = instance.home.T + np.array([10.0, 5, 3])
    found = analyze(instance, np.eye(3), T, load=[1, 2, -10], at=T)
    assert found.torques.shape == (1, 3)
    drives = Machine.of(instance)
    q = drives.inverse(np.eye(3), T)
    h = 1e-5
    slopes = [
        (drives.inverse(np.eye(3), T + h * e) - drives.inverse(np.eye(3), T - h * e)) / (2 * h)
        for e in np.eye(3)
    ]
    # F.dx + tau.dq = 0 for every shift.
    np.testing.assert_allclose(np.array(slopes) @ found.torques[0], [-1, -2, 10], atol=1e-6)
    assert q.shape == (3,)


def test_errors_of_drives_and_rods_are_those_of_the_corners():
    instance = rotary("tolerance: 0.02")
    drives = Machine.of(instance)
    R, T = POSE, instance.home.T
    found = analyze(instance, R, T, tolerance=0.005)
    q, off = drives.inverse(R, T), np.radians(0.02)
    point = found.given.point[0]
    rng = np.random.default_rng(1)
    worst = np.zeros(6)
    moves = np.zeros(3)
    J = found.given.inverse[0]
    gains = drives.gains(R, T, q)
    # The corner that moves each entry most, and random ones.
    corners = [np.sign(row) for row in J] + list(rng.choice([-1.0, 1.0], size=(30, 6)))
    for signs in corners:
        end = newton(drives, q + off * signs * np.sign(gains), drives.rods + 0.005 * signs, R, T)
        twist = turned_and_shifted((R, T), end, point)
        worst = np.maximum(worst, np.abs(twist))
        moves = max(np.linalg.norm(twist[3:]), np.max(moves))
        assert (np.abs(twist) <= found.errors.bound[0]).all()
        assert np.linalg.norm(twist[3:]) <= found.errors.bound_shift[0]
    np.testing.assert_allclose(worst, found.errors.worst[0], rtol=2e-3)
    assert moves <= found.errors.worst_shift[0] * 1.002
    # Bounds take the arm for the gain, and are not much larger.
    assert (found.errors.bound[0] < 1.3 * found.errors.worst[0]).all()
    squares = np.array([(J * x) ** 2 for x in (0.005, off * gains)]).sum(axis=(0, 2))
    np.testing.assert_allclose(found.errors.rms[0], np.sqrt(squares), rtol=1e-12)


def test_stated_tolerances_of_drives_alone_give_errors():
    found = analyze(rotary("tolerance: 0.02"), POSE, rotary().home.T)
    assert found.errors.worst.min() > 0
    assert analyze(rotary(), POSE, rotary().home.T).errors is None


def test_errors_of_a_shared_carriage_are_common():
    text = motor_file("linear", DELTA.split()).replace("slide: {", "slide: {tolerance: 0.05, ")
    instance = loads(text)
    drives = Machine.of(instance)
    T = instance.home.T + np.array([8.0, -3, 4])
    found = analyze(instance, np.eye(3), T, point=T)
    q = drives.inverse(np.eye(3), T)
    # Errors of carriages shift the platform and do not turn it.
    assert found.errors.worst[0, :3].max() < 1e-12
    D = np.linalg.solve(
        drives.jacobian(np.eye(3), T, q), drives.matrix(drives.gains(np.eye(3), T, q))
    )
    np.testing.assert_allclose(
        found.errors.worst[0, 3:], 0.05 * np.abs(D[3:]).sum(axis=1), rtol=1e-9
    )


def test_springs_of_drives_and_rods_are_in_series():
    masses = """\
dynamics:
  platform: {mass: 1, centre: [0, 0, 0], inertia: [1e3, 1e3, 1e3, 0, 0, 0]}
  gravity: [0, 0, 0]
  drives: {stiffness: 20}
"""
    instance = loads(motor_file("rotary", ROTARY.split()) + masses)
    drives = Machine.of(instance)
    R, T = POSE, instance.home.T
    # 20 N m/rad are 2e4 N mm/rad.
    held, rods = 2e4, 3e3
    found = analyze(instance, R, T, stiffness=rods)
    g = drives.gains(R, T, drives.inverse(R, T))
    each = 1 / (g**2 / held + 1 / rods)
    J = found.given.jacobian[0]
    np.testing.assert_allclose(found.stiffness[0], J.T @ np.diag(each) @ J, rtol=1e-9)
    compliance = np.linalg.inv(found.stiffness[0])[3:, 3:]
    assert found.least_stiffness[0] == pytest.approx(1 / np.linalg.eigvalsh(compliance)[-1])
    stiffer = analyze(instance, R, T).least_stiffness
    assert stiffer[0] > found.least_stiffness[0]


def test_at_a_dead_point_a_platform_is_as_stiff_as_its_rods():
    # Each arm in line with its rod: home is at a dead point of all cranks.
    instance = rotary()
    T = instance.home.T
    drives = Machine.of(instance)
    up = np.array(
        [drives.roots(np.eye(3), T + np.array([0, 0, z]))[:, 0] for z in np.linspace(0, 40, 4001)]
    )
    z = np.linspace(0, 40, 4001)[np.isfinite(up).all(axis=1)][-1]
    found = analyze(instance, np.eye(3), T + np.array([0, 0, z]), stiffness=1e3)
    assert found.transmissions[0] < 0.03
    assert np.isfinite(found.stiffness).all()
    assert np.isfinite(found.given.conditions[0])


def test_poses_out_of_reach_are_named():
    instance = rotary()
    with pytest.raises(ArgumentError, match=r"^pose 2 of 2: the leg of crank.B1 does not reach"):
        analyze(instance, [np.eye(3)] * 2, [instance.home.T, [0, 0, 500]])


def test_motors_hold_the_weights_of_platform_rods_and_arms():
    masses = """\
dynamics:
  platform: {mass: 0.5, centre: [0, 0, 0], inertia: [1e3, 1e3, 1e3, 0, 0, 0]}
  legs: {rod: {mass: 0.03, centre: 65}}
  arms: {mass: 0.02, centre: 12}
"""
    instance = loads(motor_file("rotary", ROTARY.split()) + masses)
    R, T = np.eye(3), instance.home.T
    found = analyze(instance, R, T)
    # All motors are alike, and each arm is level: energies of a common turn.
    rise = found.torques[0, 0] / 9.81
    half_of_rods = 6 * 0.03 * 0.5
    expected = (0.5 + half_of_rods) * 24 / 6 + half_of_rods / 6 * 24 + 0.02 * 12
    np.testing.assert_allclose(found.torques, found.torques[0, 0], rtol=1e-9)
    assert rise == pytest.approx(expected, rel=1e-6)
