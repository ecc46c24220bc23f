"""Reports of a step: how singular the pose is, and how far from others, in any frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.catalogue.types import all_types
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import FollowerStatus, measure
from gspcli.motion.following.follower import platform_numbers
from gspcli.resources import instance_files
from gspcli.spec import loads

TYPES = list(all_types())


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
