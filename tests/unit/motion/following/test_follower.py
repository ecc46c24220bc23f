"""None"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

import gspcli
from gspcli import _kernel
from gspcli.catalogue.types import all_types
from gspcli.export.controller.writing import controller
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import value_slopes
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import FollowerStatus, MovingPlatform, measure
from gspcli.motion.following.branch_follower import Stop
from gspcli.motion.following.follower import (
    CONTROLLER_KINDS,
    NEVER,
    PlatformNumbers,
    platform_numbers,
)
from gspcli.resources import instance_files
from gspcli.spec import loads
from tests.support.driven_machines import crank_angles, driven, some_pose
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


# The step of a controller over rails and arms: its numbers, its proofs, what is refused.


def swapped(instance):
    """Return the machine with base and platform exchanged, and its home pose."""
    T = np.array([x.value for x in instance.home.position])
    home = gspcli.HomePose((-T).tolist(), [1, 0, 0, 0])
    return replace(instance, constraints=upside_down(instance), home=home)


@pytest.mark.parametrize("name", ["6-PUS", "mixed", "reachy-mini-head", "t-top-head"])
@pytest.mark.parametrize("turned", [False, True])
def test_a_step_reaches_the_pose_of_the_drives(name, turned) -> None:
    instance = driven(name)
    instance = swapped(instance) if turned else instance
    drives, rng = Machine.of(instance), np.random.default_rng(2)
    T0 = np.array([x.value for x in instance.home.position])
    for _ in range(5):
        R, T, q = some_pose(instance, rng, spread=0.05)
        follower = gspcli.Follower(instance, np.eye(3), T0)
        assert np.allclose(drives.from_readings(follower.values), drives.inverse(np.eye(3), T0))
        assert follower.forward(drives.readings(q)) is FollowerStatus.PROVED
        assert np.allclose(follower.R, R, atol=1e-12)
        assert np.allclose(follower.T, T, atol=1e-12)
        # q' = J t / g, in the units of the file.
        expected = drives.jacobian(R, T, q) / drives.gains(R, T, q)[:, None]
        expected /= drives.units[:, None]
        assert np.allclose(follower.jacobian, expected, atol=1e-10 * np.abs(expected).max())


def test_a_range_and_readings_of_a_slide_are_kept() -> None:
    instance = driven("6-PUS")
    point = instance.constraints[2].base
    slide = gspcli.Slide(point.slide.direction, [-0.05, 0.1], offset=0.02, scale=0.25)
    moved = replace(instance.constraints[2], base=replace(point, slide=slide))
    rows = list(instance.constraints)
    rows[2] = moved
    instance = replace(instance, constraints=tuple(rows))
    follower = gspcli.Follower(instance, np.eye(3), [0, 0, 0.6])
    # At home q = 0: the reading is -offset / (1 + scale).
    assert follower.values == pytest.approx([0, 0, -0.016, 0, 0, 0], abs=1e-12)
    inside, outside = ((q - 0.02) / 1.25 for q in (0.0999, 0.1001))
    values = follower.values
    values[2] = outside
    assert follower.forward(values) is FollowerStatus.RANGE
    values[2] = inside
    assert follower.forward(values) is FollowerStatus.PROVED
    drives = Machine.of(instance)
    q = drives.inverse(follower.R, follower.T)
    assert q == pytest.approx([0, 0, 0.0999, 0, 0, 0], abs=1e-12)
    with_margin = gspcli.Follower(instance, np.eye(3), [0, 0, 0.6], margin=0.01)
    values[2] = outside
    assert with_margin.forward(values) is FollowerStatus.PROVED


def test_the_end_of_what_a_rod_reaches_is_never_crossed() -> None:
    """Carriages that go apart until a rod is straight between joint and rail: a fold."""
    instance = driven("6-PUS")
    follower = gspcli.Follower(instance, np.eye(3), [0, 0, 0.6])
    way, last = np.array([1.0, -1, 1, -1, 1, -1]), 0.0
    for size in np.arange(0.01, 1.0, 0.01):
        if follower.forward(size * way) is not FollowerStatus.PROVED:
            break
        last = size
    else:
        pytest.fail("proved a metre apart")
    drives = Machine.of(instance)
    _, _, r = drives.ends(follower.R, follower.T, last * way)
    assert np.allclose(np.linalg.norm(r, axis=-1), drives.rods, rtol=1e-12)
    J = drives.jacobian(follower.R, follower.T, last * way)
    begun = drives.jacobian(np.eye(3), np.array([0, 0, 0.6]), np.zeros(6))
    # It is refused since it becomes singular, or since it is too long: not beyond a change of sign.
    assert np.linalg.det(J) * np.linalg.det(begun) > 0


def test_shared_carriages_are_refused_in_one_line() -> None:
    with pytest.raises(gspcli.ArgumentError, match=r"slide\.B1: several rods share it"):
        platform_numbers(driven("delta"))


def test_the_program_names_its_slides_and_nothing_else_changes() -> None:
    header, source = controller(driven("6-PUS"), "rails")
    assert "1 slide B1 P1-B1" in header
    assert "The value of a slide is its way from where the file states its joint" in header
    assert "of the two places of a slide the one nearer to zero" in header
    assert "or a slide does not reach" in header
    assert "BASE_SLIDE" in source
    assert "crank_angle" not in source
    legs = controller(gspcli.example("nano-hexapod"), "legs")
    assert "SLIDE" not in "".join(legs)


# Reports of a step: how singular the pose is, and how far from others, in any frame.


def least_singular_value(instance, follower):
    """Of twists about the middle, lengths divided by the size, angles in radians."""
    numbers = platform_numbers(instance)
    J = follower.jacobian * numbers.unit[:, None]
    s = follower.R @ numbers.middle
    # The velocity of the middle is that of the origin and omega x s.
    about = np.array([[0, -s[2], s[1]], [s[2], 0, -s[0]], [-s[1], s[0], 0]])
    J[:, :3] += J[:, 3:] @ about
    J[:, 3:] *= numbers.reach
    return np.linalg.svd(J, compute_uv=False)[-1]


@pytest.mark.parametrize("number", [*range(0, 3850, 275), 2435])
def test_sigma_is_not_above_the_least_singular_value(number):
    rng = np.random.default_rng(number)
    instance, (R, T) = random_instance(TYPES[number], rng)
    moved = 0
    for _ in range(30):
        near = rotation_from_vector(0.3 * rng.normal(size=3)) @ R, T + 0.3 * rng.normal(size=3)
        follower = gspcli.Follower(instance, *near)
        true = least_singular_value(instance, follower)
        assert follower.report.sigma <= true * (1 + 1e-9)
        assert follower.report.sigma > true / 2.5
        goal = follower.values + 0.02 * rng.normal(size=6)
        if follower.forward(goal) is FollowerStatus.PROVED and follower.report.steps == 1:
            # It is of the pose from where the last part began.
            assert follower.report.sigma <= true * (1 + 1e-9)
            assert follower.report.sigma > true / 2.5
            moved += 1
    assert moved


def test_a_start_says_how_singular_it_is():
    instance = gspcli.load(instance_files()["nano-hexapod"])
    regular = gspcli.Follower(instance, np.eye(3), [0, 0, 0.09])
    assert regular.report.fraction == 1
    assert regular.report.alone > 1e-5
    assert (regular.report.steps, regular.report.tries) == (0, 0)
    # Platform and base alike and parallel: singular at a quarter turn, where nothing can be proved.
    alike = hexapod(0.0, np.random.default_rng(0))
    turned = rotation_from_vector(np.array([0, 0, np.pi / 2]))
    flat = gspcli.Follower(alike, turned, [0, 0, 1.0])
    assert flat.report.fraction == 0
    assert flat.report.alone == 0
    assert flat.report.sigma < 1e-12
    assert flat.forward(flat.values) is FollowerStatus.SINGULAR


def hexapod(noise, rng):
    """Two regular hexagons, but for noise: with none it is singular in every pose."""
    angles = np.radians(60 * np.arange(6))
    text = "gsp: 1\ntype: 6PP\nunits: {length: m, angle: deg}\n"
    for body, name, radius in (("platform", "P", 1.0), ("base", "B", 1.7)):
        points = radius * np.stack((np.cos(angles), np.sin(angles), 0 * angles), axis=1)
        points += noise * rng.normal(size=(6, 3))
        text += f"{body}:\n"
        text += "".join(f"  {name}{k}: {{point: {p.tolist()}}}\n" for k, p in enumerate(points))
    text += "constraints:\n"
    return loads(text + "".join(f"  - {{distance: [P{k}, B{k}], value: 2}}\n" for k in range(6)))


def test_steps_of_nearly_singular_geometries_are_proved():
    rng = np.random.default_rng(1)
    instance = hexapod(1e-4, rng)
    conditions, proved, started = [], 0, 0
    for _ in range(100):
        R = rotation_from_vector(0.3 * rng.normal(size=3))
        T = np.array([0, 0, 1.5]) + 0.2 * rng.normal(size=3)
        follower = gspcli.Follower(instance, R, T)
        started += int(follower.report.fraction)
        conditions.append(np.linalg.cond(follower.jacobian))
        step = 1e-6 * rng.normal(size=6)
        goal = measure(instance, rotation_from_vector(step[:3]) @ R, T + step[3:])
        status = follower.forward(goal)
        proved += status is FollowerStatus.PROVED
        if status is FollowerStatus.PROVED:
            assert np.allclose(follower.T, T + step[3:], atol=1e-7)
    assert np.median(conditions) > 1e4
    # 36 without corrections that stall above 2^-42.
    assert proved >= 90
    # Where no step can be proved the start says so.
    assert abs(started - proved) <= 3


def moved_frames(instance, platform, base):
    """The same machine with its coordinates in other frames."""

    def shifted(geometry, by):
        position = tuple(
            gspcli.Number("+", (x, gspcli.Number.of(b)))
            for x, b in zip(geometry.position, by, strict=True)
        )
        crank = getattr(geometry, "crank", None)
        if crank is not None:
            centre = tuple(
                gspcli.Number("+", (x, gspcli.Number.of(b)))
                for x, b in zip(crank.centre, by, strict=True)
            )
            return replace(geometry, position=position, crank=replace(crank, centre=centre))
        return replace(geometry, position=position)

    rows = tuple(
        replace(row, platform=shifted(row.platform, platform), base=shifted(row.base, base))
        for row in instance.constraints
    )
    return replace(instance, constraints=rows)


@pytest.mark.parametrize("far", [1e4, 3e4, 1e7])
@pytest.mark.parametrize("name", ["nano-hexapod", "three-vee-250mm", "reachy-mini-head", "6DLL"])
def test_frames_far_away_are_as_good(name, far):
    rng = np.random.default_rng(3)
    if name in instance_files():
        instance = gspcli.load(instance_files()[name])
        home = gspcli.solve(instance).home
        R, T = home.R, home.T
    else:
        instance, (R, T) = random_instance(gspcli.parse_type(name), rng)
    size = platform_numbers(instance).reach
    near = gspcli.Follower(instance, R, T)
    # Exact shifts, so that both machines are one.
    platform, base = (np.round(far * size * rng.normal(size=3)) for _ in range(2))
    moved = moved_frames(instance, platform.tolist(), base.tolist())
    other = gspcli.Follower(moved, R, T - R @ platform + base)
    scale = far * size * 1e-15
    assert np.allclose(other.report.sigma, near.report.sigma, rtol=1e-6)
    goal, step = near.values, 1e-3 * size / platform_numbers(instance).unit / size
    for _ in range(20):
        goal = goal + 1e-2 * step * rng.normal(size=6)
        status = near.forward(goal)
        assert other.forward(goal) is status
        if status is not FollowerStatus.PROVED:
            continue
        assert np.allclose(other.R, near.R, atol=1e-12)
        assert np.allclose(other.T + other.R @ platform - base, near.T, atol=20 * scale)
        assert other.error < 1e-6 * size * max(1, far / 1e5)
    # Its distance from the exact pose includes what doubles of that size cannot tell.
    assert near.error < other.error
    assert other.error > scale / 100


def test_values_may_leave_their_ranges_by_the_margin():
    instance = gspcli.load(instance_files()["rubin-m2"])
    pose = gspcli.solve(instance).real_solutions[0]
    low, high = (limit.value for limit in instance.constraints[0].limits)
    for margin, share, status in (
        (0.0, 0.009, FollowerStatus.RANGE),
        (0.01, 0.009, FollowerStatus.PROVED),
        (0.01, 0.011, FollowerStatus.RANGE),
    ):
        for edge, sign in ((low, -1), (high, 1)):
            follower = gspcli.Follower(instance, pose.R.real, pose.T.real, margin=margin)
            goal = follower.values
            goal[0] = edge + sign * share * (high - low)
            assert follower.forward(goal) is status
    for wrong in (-0.1, 1.5, np.nan):
        with pytest.raises(gspcli.ArgumentError, match=r"margin: found .*expected a part"):
            gspcli.Follower(instance, pose.R.real, pose.T.real, margin=wrong)


# The step of a controller on made-up platforms whose poses are known: nothing false is proved.


X, Y, Z = np.eye(3)
NONE = np.zeros(3)
#: Kind, points of the platform and of the base, directions of both: of y, z and the rotation.
HELD = [
    ("DPH", NONE, NONE, NONE, Y),
    ("DPH", Z, NONE, NONE, Y),
    ("DPH", X, NONE, NONE, Y),
    ("DPH", NONE, NONE, NONE, Z),
    ("DPH", X, NONE, NONE, Z),
]
#: Of the position and of two turns: a turn about z is left.
TURNING = [
    ("DPH", NONE, NONE, NONE, X),
    ("DPH", NONE, NONE, NONE, Y),
    ("DPH", NONE, NONE, NONE, Z),
    ("ALH", NONE, NONE, Z, X),
    ("ALH", NONE, NONE, Z, Y),
]


class Crossing(NamedTuple):
    """A platform with a crossing."""

    sixth: tuple[str, np.ndarray, np.ndarray, np.ndarray, np.ndarray]
    others: list[tuple[str, np.ndarray, np.ndarray, np.ndarray, np.ndarray]]
    at: float
    """The value there."""
    crank: tuple[np.ndarray, np.ndarray, float] | None = None


CROSSINGS = {
    "leg": Crossing(("DPP", NONE, NONE, NONE, NONE), HELD, 0.0),
    "point-line": Crossing(("DPL", NONE, NONE, NONE, Z), HELD, 0.0),
    "line-point": Crossing(("DLP", NONE, NONE, Z, NONE), HELD, 0.0),
    "cosine": Crossing(("ALL", NONE, NONE, X, X), TURNING, 0.0),
    "minus cosine": Crossing(("AHH", NONE, NONE, X, X), TURNING, np.pi),
    "sine": Crossing(("ALH", NONE, NONE, X, X), TURNING, np.pi / 2),
    "base crank": Crossing(("BASE_CRANK", NONE, NONE, NONE, NONE), HELD, np.pi / 2, (X, Y, 1.0)),
    "platform crank": Crossing(
        ("PLATFORM_CRANK", NONE, NONE, NONE, NONE), HELD, np.pi / 2, (X, Y, 1.0)
    ),
}


def controller_of_made_up_controllers(
    crossing: Crossing, *, moduli: float = 4.0, most: float = 1e9
):
    """Return a controller of a platform in units of its own."""
    rows = [crossing.sixth, *crossing.others]
    points, bases, u, v = (np.array([row[k] for row in rows]) for k in (1, 2, 3, 4))
    A, B, rod = np.zeros((6, 3)), np.zeros((6, 3)), np.zeros(6)
    if crossing.crank:
        A[0], B[0], rod[0] = crossing.crank
    crank = np.linalg.norm(A, axis=1)
    numbers = PlatformNumbers(
        kind=np.array([CONTROLLER_KINDS.index(row[0]) for row in rows], np.uint8),
        Y=points,
        X=bases,
        U=u,
        V=v,
        A=A,
        B=B,
        crank=crank,
        rod=rod,
        lowest=np.full(6, -NEVER),
        highest=np.full(6, NEVER),
        norm_y=np.linalg.norm(points, axis=1) + crank,
        moduli=np.full(6, moduli),
        middle=np.zeros(3),
        origin=np.zeros(3),
        reach=1.0,
        shift=0.0,
        unit=np.ones(6),
        offset=np.zeros(6),
        least=np.full(6, -1e9),
        most=np.full(6, most),
        either=np.zeros(6, np.uint8),
    )
    return _kernel.Controller(numbers.kind, numbers.either, numbers.doubles)


def pose(name: str, value: float, branch: int) -> np.ndarray:
    """Return a pose for a value: position and quaternion."""
    if name in ("leg", "point-line", "line-point"):
        return np.array([branch * value, 0, 0, 1, 0, 0, 0])
    if "crank" in name:
        # |x - cos c| = |cos c| for a rod as long as the crank: one branch is zero.
        x = 2 * np.cos(value) if branch > 0 else 0.0
        return np.array([-x if "platform" in name else x, 0, 0, 1, 0, 0, 0])
    angle = (
        branch * {"cosine": value, "minus cosine": np.pi - value, "sine": np.pi / 2 - value}[name]
    )
    return np.array([0, 0, 0, np.cos(angle / 2), 0, 0, np.sin(angle / 2)])


def started(name: str, value: float, branch: int, **options: float):
    found = controller_of_made_up_controllers(CROSSINGS[name], **options)
    assert found.start(pose(name, value, branch)) == FollowerStatus.PROVED
    assert abs(found.values()[0] - value) < 1e-7
    return found


def step(found, value: float) -> FollowerStatus:
    values = np.zeros(6)
    values[0] = value
    return FollowerStatus(found.forward(values))


NAMES = [name for name in CROSSINGS if "crank" not in name]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("branch", [1, -1])
@pytest.mark.parametrize("size", [1e-4, 3e-4, 1e-3, 0.03, 0.2])
def test_no_step_leads_across_the_crossing(name: str, branch: int, size: float) -> None:
    at = CROSSINGS[name].at
    way = -1 if name == "minus cosine" or name == "sine" else 1
    for share in (0.3, 0.5, 0.7, 0.9, 1.0, 1.1, 1.5, 2, 3):
        found = started(name, at + way * size, branch)
        assert step(found, at + way * 1.1 * size) is FollowerStatus.PROVED
        assert step(found, at - way * share * size) is not FollowerStatus.PROVED
        # It goes on where it was; nearer than that to the crossing it may refuse.
        if size >= 1e-3:
            assert step(found, at + way * 0.95 * size) is FollowerStatus.PROVED


@pytest.mark.parametrize("name", NAMES)
def test_no_other_pose_is_nearer_than_a_step_says(name: str) -> None:
    at = CROSSINGS[name].at
    way = -1 if name == "minus cosine" or name == "sine" else 1
    for size in (1e-4, 3e-4, 1e-3):
        found = started(name, at + way * size, 1)
        assert step(found, at + way * 1.05 * size) is FollowerStatus.PROVED
        _, _, alone, *_ = found.report()
        assert 0.1 * size < alone < 2 * size
        assert found.error() < 1e-3 * alone


@pytest.mark.parametrize("name", ["base crank", "platform crank"])
def test_no_step_turns_a_crank_across_the_crossing(name: str) -> None:
    """A rod as long as its crank: at a right angle both poses are the same."""
    for size in (0.03, 0.2):
        for share in (0.5, 1.0, 1.5, 3):
            found = controller_of_made_up_controllers(CROSSINGS[name])
            first = np.pi / 2 - size
            assert found.start(pose(name, first, 1)) == FollowerStatus.PROVED
            begun = found.values()[0]
            assert abs(begun - first) < 1e-9
            assert step(found, first + 0.1 * size) is FollowerStatus.PROVED
            assert step(found, np.pi / 2 + share * size) is not FollowerStatus.PROVED


@pytest.mark.parametrize("name", ["leg", "point-line", "line-point"])
def test_numbers_that_are_hardly_known_prove_no_step(name: str) -> None:
    """What rounding may do grows with the moduli of all that coordinates are sums of."""
    errors = []
    for moduli in (4.0, 1e3):
        found = started(name, 0.1, 1, moduli=moduli)
        assert step(found, 0.11) is FollowerStatus.PROVED
        errors.append(found.error())
    # They are of squares.
    assert errors[1] > 1e4 * errors[0]
    assert step(started(name, 0.1, 1, moduli=1e7), 0.11) is not FollowerStatus.PROVED


def test_values_beyond_a_limit_are_refused() -> None:
    found = started("leg", 0.5, 1, most=0.6)
    assert step(found, 0.55) is FollowerStatus.PROVED
    assert step(found, 0.65) is FollowerStatus.RANGE
    assert step(found, np.nan) is FollowerStatus.NOT_FINITE


# The step of a controller over slides and cranks where branches cross: nothing false is proved.


#: What keeps a platform in the plane: kind, point of the platform, directions of both bodies.
HELD_OF_MADE_UP_DRIVES = [("DPH", NONE, NONE, Z), ("ALH", NONE, Z, X), ("ALH", NONE, Z, Y)]
KINDS = ["BASE_SLIDE", "PLATFORM_SLIDE", "BASE_CRANK", "PLATFORM_CRANK"]


class Node(NamedTuple):
    """Three drives; arrays of shape (3, 3) but for the rods and the numbers of the drives."""

    kind: str
    y: np.ndarray
    """The joints of the platform."""
    x: np.ndarray
    """Those of the base."""
    A: np.ndarray
    """From centres of cranks to their joints; zero for slides."""
    B: np.ndarray
    """Directions of rails; of cranks the axis times A."""
    rods: np.ndarray
    rates: np.ndarray
    """The direction q' in which a branch crosses others."""

    def moved(self, q):
        """Return both joints of the rods where the drives are at q."""
        if "SLIDE" in self.kind:
            way = self.B * q[:, None]
        else:
            way = self.A * (np.cos(q) - 1)[:, None] + self.B * np.sin(q)[:, None]
        return (self.y + way, self.x) if "PLATFORM" in self.kind else (self.y, self.x + way)

    def stated_at(self, q):
        """Return the node with the numbers of its drives counted from q."""
        y, x = self.moved(q)
        if "SLIDE" in self.kind:
            return self._replace(y=y, x=x)
        cosine, sine = np.cos(q)[:, None], np.sin(q)[:, None]
        A, B = self.A * cosine + self.B * sine, self.B * cosine - self.A * sine
        return self._replace(y=y, x=x, A=A, B=B)

    def pose(self, q):
        """Return the pose (x, y, angle) of a branch near zero, by Newton's method, or None."""
        pose = np.zeros(3)
        for _ in range(30):
            y, x = self.moved(q)
            arms = y @ turn(pose[2]).T
            r = arms + np.append(pose[:2], 0) - x
            F = np.einsum("ki,ki->k", r, r) - self.rods**2
            J = 2 * np.column_stack((r[:, :2], arms[:, 0] * r[:, 1] - arms[:, 1] * r[:, 0]))
            pose = pose - np.linalg.lstsq(J, F, rcond=None)[0]
        return pose if np.abs(F).max() < 1e-12 * (1 + self.rods.max() ** 2) else None

    def controller(self, moduli=4.0):
        """Return a controller in units of its own."""
        on_platform, turns = "PLATFORM" in self.kind, "CRANK" in self.kind
        points, bases, A, B, U, V = np.zeros((6, 6, 3))
        points[:3] = self.y - self.A * on_platform
        bases[:3] = self.x - self.A * (not on_platform)
        A[:3], B[:3] = self.A, self.B
        points[3:], U[3:], V[3:] = (
            np.array([row[k] for row in HELD_OF_MADE_UP_DRIVES]) for k in (1, 2, 3)
        )
        names = [self.kind] * 3 + [row[0] for row in HELD_OF_MADE_UP_DRIVES]
        crank = np.linalg.norm(B, axis=1)
        numbers = PlatformNumbers(
            kind=np.array([CONTROLLER_KINDS.index(name) for name in names], np.uint8),
            Y=points,
            X=bases,
            U=U,
            V=V,
            A=A,
            B=B,
            crank=crank,
            rod=np.concatenate((self.rods, np.zeros(3))),
            lowest=np.full(6, -NEVER),
            highest=np.full(6, NEVER),
            norm_y=np.linalg.norm(points, axis=1) + crank * (on_platform and turns),
            moduli=np.full(6, moduli),
            middle=NONE,
            origin=NONE,
            reach=1.0,
            shift=0.0,
            unit=np.ones(6),
            offset=np.zeros(6),
            least=np.full(6, -1e9),
            most=np.full(6, 1e9),
            either=np.zeros(6, np.uint8),
        )
        return _kernel.Controller(numbers.kind, numbers.either, numbers.doubles)


def turn(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def placed(pose):
    """Return the position and quaternion of a pose in the plane."""
    return np.array([*pose[:2], 0, np.cos(pose[2] / 2), 0, 0, np.sin(pose[2] / 2)])


def random_node(kind, rng):
    """Return a node of random sizes; None if no branch goes through it with so little motion."""
    sizes = np.exp(rng.uniform(-2, 3, 4))
    y = np.append(rng.normal(size=(3, 2)) * sizes[0], np.zeros((3, 1)), axis=1)
    along = np.append(rng.normal(size=2) * sizes[1], 0) - y
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    ways = np.exp(rng.normal(size=(2, 3))) * rng.choice([-1, 1], (2, 3)) * sizes[2:, None]
    r = -along * ways[0, :, None]
    A = along * ways[1, :, None] * ("CRANK" in kind)
    B = np.cross(Z, A if "CRANK" in kind else along)
    moments = y[:, 0] * r[:, 1] - y[:, 1] * r[:, 0]
    balance = np.linalg.svd(np.column_stack((r[:, :2], moments)))[0][:, -1]
    bent = np.einsum("ki,ki->k", r, A) * (1 if kind == "BASE_CRANK" else -1)
    weights = balance * (np.einsum("ki,ki->k", B, B) + bent)
    up = weights > 0
    if up.all() or not up.any():
        return None
    squares = rng.uniform(0, 1, 3)
    squares[up] *= -(weights[~up] @ squares[~up]) / (weights[up] @ squares[up])
    rates = np.sqrt(squares) * rng.choice([-1, 1], 3)
    return Node(kind, y, y - r, A, B, np.abs(ways[0]), rates / np.linalg.norm(rates))


def started_of_made_up_drives(node, s):
    """Return a controller at s on the branch, numbers counted from there; None if it is another."""
    pose = node.pose(s * node.rates)
    # The motion is of the second order, and no larger than that of the ends of the rods.
    if pose is None or np.abs(pose).max() > abs(s):
        return None
    found = node.stated_at(s * node.rates).controller()
    if found.start(placed(pose)) != FollowerStatus.PROVED or np.abs(found.values()).max() > 1e-6:
        return None
    return found


def step_of_made_up_drives(found, rates, size):
    return FollowerStatus(found.forward(np.concatenate((rates * size, np.zeros(3)))))


@pytest.mark.parametrize("kind", KINDS)
def test_no_step_moves_drives_across_the_crossing(kind):
    rng, counts = np.random.default_rng(11), np.zeros(2, int)
    for _ in range(60):
        node = random_node(kind, rng)
        for size in (1e-3, 1e-2) if node else ():
            found = started_of_made_up_drives(node, size)
            if found is None:
                continue
            # Away from the crossing, and then across it from there.
            away = step_of_made_up_drives(found, node.rates, 0.1 * size) is FollowerStatus.PROVED
            counts += [1, away]
            if away:
                pose = node.pose(1.1 * size * node.rates)
                assert np.allclose(found.rotation(), placed(pose)[3:], atol=1e-7)
            for share in (0.02, 0.3, 1.0):
                status = step_of_made_up_drives(found, node.rates, -(1 + share) * size)
                assert status is not FollowerStatus.PROVED
    assert counts[0] > 30
    assert counts[1] > 0.7 * counts[0]


def slides(body):
    """Return a node of slides, and where they are on a branch: nearer than the other places."""
    rng = np.random.default_rng(2)
    node = next(filter(None, (random_node(f"{body}_SLIDE", rng) for _ in range(9))))
    node = node._replace(rates=np.abs(node.rates))
    return node, -0.01 * node.rates


@pytest.mark.parametrize("body", ["BASE", "PLATFORM"])
def test_a_slide_far_from_where_it_is_stated_is_known_less_well(body):
    node, q = slides(body)
    errors = []
    for far in (0.0, 100.0):
        found = node.stated_at(q - far).controller()
        assert found.start(placed(node.pose(q))) == FollowerStatus.PROVED
        assert np.allclose(found.values()[:3], far)
        assert step_of_made_up_drives(found, np.ones(3), far + 1e-6) is FollowerStatus.PROVED
        errors.append(found.error())
    assert errors[1] > 100 * errors[0]


@pytest.mark.parametrize("body", ["BASE", "PLATFORM"])
def test_a_slide_that_does_not_reach_is_refused(body):
    node, q = slides(body)
    found = node.stated_at(q).controller()
    assert found.start(placed(node.pose(q))) == FollowerStatus.PROVED
    assert found.start(placed([1e3, 1e3, 0])) == FollowerStatus.RANGE
