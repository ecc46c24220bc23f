from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.catalogue.types import all_types
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import value_slopes
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import FollowerStatus, MovingPlatform, measure
from gspcli.motion.following.branch_follower import Stop
from gspcli.motion.following.follower import platform_numbers
from gspcli.resources import instance_files
from tests.support.driven_machines import crank_angles
from tests.support.independent_machines import upside_down

TYPES = list(all_types())


def machine(name):
    return gspcli.load(instance_files()[name])


def first_pose(instance):
    pose = gspcli.solve(instance).real_solutions[0]
    return pose.R.real, pose.T.real


@pytest.mark.parametrize("number", range(0, 3850, 175))
def test_values_and_derivatives_are_those_of_the_package(number):
    rng = np.random.default_rng(number)
    instance, (R, T) = random_instance(TYPES[number], rng)
    arrangement = Arrangement.of(instance)
    units = np.ones((6, 1))
    units[arrangement.angles] = arrangement.in_radians
    for _ in range(5):
        R, T = rotation_from_vector(0.4 * rng.normal(size=3)) @ R, T + 0.3 * rng.normal(size=3)
        follower = gspcli.Follower(instance, R, T)
        assert np.allclose(follower.values, measure(instance, R, T), rtol=1e-12, atol=1e-12)
        slopes = value_slopes(arrangement, R, T) / units
        scale = np.linalg.norm(slopes, axis=1, keepdims=True)
        assert (np.abs(follower.jacobian - slopes) <= 1e-12 * scale).all()


@pytest.mark.parametrize("number", range(90, 3850, 370))
def test_what_is_proved_is_where_tracks_lead(number):
    rng = np.random.default_rng(number)
    instance, (R, T) = random_instance(TYPES[number], rng)
    follower, platform = gspcli.Follower(instance, R, T), MovingPlatform(instance)
    values = follower.values + 5e-4 * np.arange(60)[:, None] * rng.normal(size=6)
    branch = platform.follow(
        platform.internal(values[None]), np.zeros(1, np.int64), platform.points(R[None], T[None])
    )
    rotations, places = platform.poses(branch.points[0])
    proved = 0
    for row in values[1:]:
        before = follower.T, follower.quaternion, follower.values
        if follower.forward(row) is not FollowerStatus.PROVED:
            after = follower.T, follower.quaternion, follower.values
            assert all((a == b).all() for a, b in zip(before, after, strict=True))
            break
        proved += 1
        assert branch.reached[0] >= proved
        assert np.allclose(follower.R, rotations[proved], atol=1e-9)
        assert np.allclose(follower.T, places[proved], atol=1e-9)
        assert np.allclose(measure(instance, follower.R, follower.T), row, atol=1e-9)
    assert proved >= 1


def test_refuses_to_pass_a_fold_and_says_why():
    instance = machine("nano-hexapod")
    R, T = first_pose(instance)
    follower = gspcli.Follower(instance, R, T)
    value = follower.values
    statuses = []
    for _ in range(1000):
        value = value + 2e-4 * np.array([1, -1, 1, -1, 1, -1])
        statuses.append(follower.forward(value))
        if statuses[-1]:
            break
    assert statuses[-1] in (FollowerStatus.SINGULAR, FollowerStatus.TRIES_SPENT)
    assert follower.report.fraction < 1
    at = gspcli.set_values(instance, [f"{k + 1}={float(v)!r}" for k, v in enumerate(value)])
    poses = gspcli.solve(at).real_solutions
    # The branch has ended: no pose of the new values is near.
    assert all(np.linalg.norm(pose.T.real - follower.T) > 1e-3 for pose in poses)


def test_statuses_of_what_is_no_step():
    instance = machine("rubin-m2")
    follower = gspcli.Follower(instance, *first_pose(instance))
    values = follower.values
    assert follower.forward([np.nan, *values[1:]]) is FollowerStatus.NOT_FINITE
    assert follower.forward([np.inf, *values[1:]]) is FollowerStatus.NOT_FINITE
    low, high = (limit.value for limit in instance.constraints[0].limits)
    for beyond in (low - 1e-6, high + 1e-6):
        assert follower.forward([beyond, *values[1:]]) is FollowerStatus.RANGE
    assert follower.forward([high * 1e12, *values[1:]]) is FollowerStatus.RANGE
    assert follower.forward(values) is FollowerStatus.PROVED
    assert (follower.values == values).all()
    with pytest.raises(gspcli.ArgumentError, match=r"expected \(6,\)"):
        follower.forward([1.0])
    with pytest.raises(gspcli.ArgumentError, match="found 'six', expected six numbers"):
        follower.forward("six")
    with pytest.raises(gspcli.ArgumentError, match="no rotation"):
        gspcli.Follower(follower.instance, 2 * np.eye(3), np.zeros(3))


@pytest.mark.parametrize("turned", [False, True])
def test_cranks_of_the_base_and_of_the_platform(turned):
    # Without a home the working modes are those of the first pose, as a start of the follower has
    # them.
    instance = replace(machine("reachy-mini-head"), home=None)
    R, T = first_pose(instance)
    goal = rotation_from_vector(np.array([0.01, -0.006, 0.02])) @ R, T + 0.0005
    if turned:  # base and platform change places
        instance, R, T = replace(instance, constraints=upside_down(instance)), R.T, -R.T @ T
        goal = goal[0].T, -goal[0].T @ goal[1]
    follower = gspcli.Follower(instance, R, T)
    poses = np.stack([R, goal[0]]), np.stack([T, goal[1]])
    _, angles = crank_angles(instance, *poses)
    assert np.allclose(follower.values, angles[0], atol=1e-9)
    assert follower.forward(angles[1]) is FollowerStatus.PROVED
    assert np.allclose(follower.R, goal[0], atol=1e-12)
    assert np.allclose(follower.T, goal[1], atol=1e-12)
    # Derivatives, by differences.
    slopes, size = follower.jacobian, 1e-6
    for k in range(6):
        step = size * np.eye(6)[k]
        ends = [
            crank_angles(
                instance,
                np.stack([goal[0], rotation_from_vector(s * step[:3]) @ goal[0]]),
                np.stack([goal[1], goal[1] + s * step[3:]]),
            )[1][1]
            for s in (1, -1)
        ]
        assert np.allclose(slopes[:, k], (ends[0] - ends[1]) / (2 * size), rtol=1e-5, atol=1e-3)


def test_offsets_sides_and_shared_cranks():
    instance = machine("three-vee-250mm")
    R, T = first_pose(instance)
    plain = gspcli.Follower(instance, R, T).values
    assert np.allclose(plain, measure(instance, R, T), atol=1e-9)
    shifted = tuple(
        replace(row, offset=gspcli.Number.of(0.5)) for row in machine("nano-hexapod").constraints
    )
    offset = replace(machine("nano-hexapod"), constraints=shifted)
    R, T = first_pose(machine("nano-hexapod"))
    follower = gspcli.Follower(offset, R, T)
    assert np.allclose(follower.values, measure(offset, R, T), atol=1e-12)
    assert follower.forward(follower.values + 1e-5) is FollowerStatus.PROVED
    head = machine("reachy-mini-head")
    rows = list(head.constraints)
    rows[1] = replace(rows[1], base=rows[0].base, base_name=rows[0].base_name)
    with pytest.raises(gspcli.ArgumentError, match=r"crank.B1.*expected one DPP"):
        platform_numbers(replace(head, constraints=tuple(rows)))


def test_lines_that_meet_stay_so_and_move_apart_only_where_the_side_is_known():
    rng = np.random.default_rng(5)
    instance, (R, T) = random_instance(gspcli.parse_type("3DPP 3DLL"), rng)
    k = next(i for i, row in enumerate(instance.constraints) if row.kind.name == "DLL")
    R = rotation_from_vector(0.3 * rng.normal(size=(300, 3))) @ R
    T = T + 0.3 * rng.normal(size=(300, 3))
    near = measure(instance, R, T)[:, k].argmin()
    follower = gspcli.Follower(instance, R[near], T[near])
    # Towards zero, where the lines meet: from there both sides are as good, so it stops before.
    goal = follower.values
    start = goal[k]
    while abs(goal[k]) > 1e-30:
        goal[k] /= 4
        status = follower.forward(goal)
        if status is not FollowerStatus.PROVED:
            break
    assert status is FollowerStatus.SINGULAR
    assert 0 < follower.values[k] < 1e-8
    goal[k] = 0
    before = follower.T, follower.values
    assert follower.forward(goal) is FollowerStatus.SINGULAR
    assert all((a == b).all() for a, b in zip(before, (follower.T, follower.values), strict=True))
    # Where it stopped it is not stuck.
    assert follower.forward(follower.values) is FollowerStatus.PROVED
    goal[k] = start / 2
    assert follower.forward(goal) is FollowerStatus.PROVED
    # Lines that meet at the start may stay so, and the others move.
    ends = _meeting(instance, follower.R, follower.T, k)
    follower = gspcli.Follower(instance, *ends)
    assert follower.values[k] == 0
    goal = follower.values + 1e-4 * (np.arange(6) != k)
    assert follower.forward(goal) is FollowerStatus.PROVED
    goal[k] = 1e-3
    assert follower.forward(goal) is FollowerStatus.SINGULAR


def _meeting(instance, R, T, k):
    """A pose near a pose with the distance k zero, by Newton's method."""
    arrangement = Arrangement.of(instance)
    for _ in range(60):
        value, slope = measure(instance, R, T)[k], value_slopes(arrangement, R, T)[k]
        step = -0.5 * value * slope / (slope @ slope)
        R, T = rotation_from_vector(step[:3]) @ R, T + step[3:]
    return R, T


@pytest.mark.parametrize(("kinds", "seed", "row"), [("6DLL", 3, 55), ("6DLL", 1, 22)])
def test_the_native_follower_follows_lines_that_nearly_meet(kinds, seed, row):
    """Rounding of the square of a small moment is no larger than the moment allows."""
    rng = np.random.default_rng(seed)
    instance, (R0, T0) = random_instance(gspcli.parse_type(kinds), rng)
    n, step = 200, 0.05
    R = rotation_from_vector(0.3 * rng.normal(size=(n, 3))) @ R0
    T = T0 + 0.3 * rng.normal(size=(n, 3))
    R2 = rotation_from_vector(step * rng.normal(size=(n, 3))) @ R
    T2 = T + step * rng.normal(size=(n, 3))
    ends = (R[row], T[row]), (R2[row], T2[row])
    values = np.stack([measure(instance, *pose) for pose in ends])
    platform = MovingPlatform(instance)
    branch = platform.follow(
        platform.internal(values[None]), np.zeros(1, np.int64), platform.points(R[[row]], T[[row]])
    )
    assert branch.stop[0] == Stop.END
    # And where a program of other equations proves that it goes.
    follower = gspcli.Follower(instance, *ends[0])
    assert follower.forward(values[1]) is FollowerStatus.PROVED
    assert np.allclose(platform.poses(branch.points[0, 1])[1], follower.T, atol=1e-7)
