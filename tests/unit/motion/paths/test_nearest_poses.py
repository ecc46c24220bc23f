"""The nearest poses within the limits, against searches of another kind and by their definition."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion.paths.nearest_poses import NearestPoses, _Slack
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.resources import instance_files
from tools.verify.nearest import kept

MACHINES = ["workspace-study", "workspace-study-cones", "rubin-m2", "three-rps"]


def nearest_of(name: str) -> NearestPoses:
    instance = gspcli.example(name)
    home = gspcli.solve(instance).home
    return NearestPoses(instance, home.R.real, home.T.real)


@pytest.mark.parametrize("name", MACHINES)
def test_the_slack_has_these_derivatives(name):
    nearest = nearest_of(name)
    slack = nearest._slack
    draw = np.random.default_rng(3)
    sizes = np.array([1 / nearest.length] * 3 + [1.0] * 3)
    R = rotation_from_vector(0.2 * draw.normal(size=3)) @ nearest.R
    T = nearest.T + 0.1 * nearest.length * draw.normal(size=3)
    for _ in range(3):
        twist, step = draw.normal(size=6) * sizes, 1e-5 * nearest.length
        ends = [
            slack.at(rotation_from_vector(sign * step * twist[:3]) @ R, T + sign * step * twist[3:])
            for sign in (1, -1)
        ]
        measured = (ends[0][0] - ends[1][0]) / (2 * step)
        assert np.abs(measured - slack.at(R, T)[1] @ twist).max() < 1e-6


@pytest.mark.parametrize("name", MACHINES)
def test_answers_keep_the_limits_and_no_small_motion_leads_nearer(name):
    nearest = nearest_of(name)
    draw = np.random.default_rng(5)
    length = nearest.length
    for _ in range(4):
        R = rotation_from_vector(0.3 * draw.normal(size=3)) @ nearest.R
        T = nearest.T + 0.2 * length * draw.normal(size=3)
        found = nearest.of(R, T)
        assert found.way
        assert kept(nearest.instance, found.R, found.T)
        assert bool(found.limits) == (found.shift > 0)
        turn = found.turn * nearest.instance.units.angle.in_radians
        distance = np.hypot(found.shift, length * turn)
        for _ in range(200):
            size = 10.0 ** -draw.integers(1, 5)
            other_R = rotation_from_vector(size * draw.normal(size=3)) @ found.R
            other_T = found.T + size * length * draw.normal(size=3)
            if nearest.slack(other_R, other_T).min() < -1e-12 * length:
                continue
            w = np.arccos(np.clip((np.trace(other_R @ R.T) - 1) / 2, -1, 1))
            away = np.hypot(np.linalg.norm(other_T - T), length * w)
            assert away > distance - 1e-5 * length


def test_a_wanted_pose_within_the_limits_is_the_answer():
    nearest = nearest_of("workspace-study")
    T = nearest.T + np.array([1.0, -2.0, 3.0])
    found = nearest.of(nearest.R, T)
    assert (found.shift, found.turn, found.limits) == (0.0, 0.0, ())
    assert found.T.tolist() == T.tolist()


def test_the_exact_answer_where_one_leg_is_too_long():
    """Lifted straight up by equal legs, the platform stops at their greatest length."""
    nearest = nearest_of("workspace-study")
    found = nearest.of(nearest.R, nearest.T + np.array([0, 0, 500.0]))
    assert found.limits == tuple(f"range of {k}" for k in range(1, 7))
    high = [row.limits[1].value for row in nearest.instance.constraints]
    assert np.abs(found.values - high).max() < 1e-4
    assert (found.values <= high).all()
    assert np.abs(found.R - nearest.R).max() < 1e-6


def test_poses_are_sought_each_from_the_one_before():
    nearest = nearest_of("workspace-study")
    wanted = nearest.T + np.array([[0, 0, 500.0], [60.0, 0, 500.0], [400.0, 0, 0]])
    rows = list(nearest.along(np.stack([nearest.R] * 3), wanted))
    assert all(row.way for row in rows)
    assert all(kept(nearest.instance, row.R, row.T) for row in rows)
    assert nearest.T.tolist() == nearest_of("workspace-study").T.tolist()


def test_another_point_of_the_platform_is_compared():
    instance = gspcli.example("workspace-study")
    home = gspcli.solve(instance).home
    tool = np.array([0.0, 0.0, 120.0])
    goal = (
        rotation_from_vector(np.array([0.5, 0.0, 0.0])) @ home.R.real,
        home.T.real + np.array([0, 0, 90]),
    )
    of_tool = NearestPoses(instance, home.R.real, home.T.real, pivot=tool).of(*goal)
    of_origin = NearestPoses(instance, home.R.real, home.T.real).of(*goal)
    offs = [
        float(np.linalg.norm(one.T + one.R @ tool - goal[1] - goal[0] @ tool))
        for one in (of_tool, of_origin)
    ]
    assert abs(offs[0] - of_tool.shift) < 1e-9
    assert abs(offs[1] - of_origin.shift) > 1.0


def test_a_start_outside_the_limits_is_refused():
    instance = gspcli.example("workspace-study")
    home = gspcli.solve(instance).home
    with pytest.raises(gspcli.ArgumentError, match="within all ranges and cones"):
        NearestPoses(instance, home.R.real, home.T.real + np.array([0, 0, 400.0]))


def test_cranks_are_refused():
    instance = gspcli.example("reachy-mini-head")
    home = gspcli.solve(instance).home
    with pytest.raises(gspcli.ArgumentError, match="cranks or slides"):
        NearestPoses(instance, home.R.real, home.T.real)


def test_a_singular_pose_between_is_not_passed():
    """For a goal upside down the platform stays on its side of the singular poses."""
    nearest = nearest_of("workspace-study")
    over = np.diag([1.0, -1.0, -1.0])
    found = nearest.of(over @ nearest.R, nearest.T)
    assert found.turn > 90
    assert nearest._pose_ways.at(nearest._pose_ways.parameters(found.R, found.T)).sign == (
        nearest._pose_ways.at(nearest._parameters).sign
    )


def test_signed_distances_keep_their_side():
    instance = gspcli.example("three-rps")
    values = values_at(instance, np.eye(3), np.zeros(3))
    slack = _Slack(instance, values - 1, values + 1)
    assert slack.at(np.eye(3), np.zeros(3))[0].min() > 0.9


def test_machines_with_motors_are_told_what_there_is_for_them():
    machine = gspcli.load(instance_files()["t-top-head"])
    with pytest.raises(gspcli.GspError, match="nearest poses are for legs, and cranks or slides"):
        gspcli.NearestPoses(machine, np.eye(3), np.array([0, 0, 0.17]))
