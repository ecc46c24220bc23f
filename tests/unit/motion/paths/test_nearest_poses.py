"""The nearest poses within the limits, against searches of another kind and by their definition."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_vector
from gspcli.motion.paths.nearest_poses import NearestPoses
from tests.support.independent_machines import PlaneGeometry, machines
from tests.support.nearest import kept

MACHINES = ["workspace-study", "workspace-study-cones", "rubin-m2", "three-rps"]


def nearest_of(name: str) -> NearestPoses:
    instance = gspcli.example(name)
    home = gspcli.solve(instance).home
    return NearestPoses(instance, home.R.real, home.T.real)


@pytest.mark.parametrize("name", MACHINES)
def test_answers_keep_the_limits_and_no_small_motion_leads_nearer(name):
    nearest = nearest_of(name)
    draw = np.random.default_rng(5)
    length = nearest.length
    for _ in range(4):
        R = rotation_from_vector(0.3 * draw.normal(size=3)) @ nearest.R
        T = nearest.T + 0.2 * length * draw.normal(size=3)
        found = nearest.of(R, T)
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


@pytest.mark.parametrize("name", ["reachy 45", "t-top 60", "paradex"])
def test_motors_keep_their_ranges_and_reach_their_rods(name):
    """Judged by plane geometry, which shares no formula with the search."""
    machine = machines()[name]()
    nearest = NearestPoses(machine.instance, machine.R, machine.T)
    judge = PlaneGeometry(machine)
    draw = np.random.default_rng(7)
    met = set()
    for _ in range(3):
        R = rotation_from_vector(0.3 * draw.normal(size=3)) @ nearest.R
        T = nearest.T + 0.5 * nearest.length * draw.normal(size=3)
        found = nearest.of(R, T)
        assert judge.reached(found.R[None], found.T[None]).all()
        assert np.allclose(
            np.deg2rad(found.values) if name != "paradex" else found.values,
            judge.numbers(found.R[None], found.T[None])[0],
            atol=1e-9,
        )
        met |= set(found.limits)
    assert any(limit.startswith(("range of", "reach of")) for limit in met)


def test_what_a_motor_cannot_reach_is_named():
    """Lifted far beyond, the rods of a head without ranges are stretched."""
    instance = gspcli.example("t-top-head")
    home = gspcli.solve(instance).home
    nearest = NearestPoses(instance, home.R.real, home.T.real)
    found = nearest.of(nearest.R, nearest.T + np.array([0, 0, 0.3]))
    assert found.limits == tuple(f"reach of crank B{k}" for k in range(1, 7))
    drives = Machine.of(instance)
    both = drives.roots(found.R, found.T)
    assert np.isfinite(both).all()
    assert np.abs(both[:, 0] - both[:, 1]).max() < 0.01


def test_rods_that_share_a_motor_keep_the_orientation():
    instance = gspcli.example("delta")
    home = instance.home
    R, T = home.R(1.0), home.T
    nearest = NearestPoses(instance, R, T)
    inside = nearest.of(R, T + np.array([10.0, 20.0, -30.0]))
    assert (inside.limits, inside.shift) == ((), 0.0)
    turned = nearest.of(rotation_from_vector(np.array([0, 0, 0.2])), T)
    assert turned.R.tolist() == R.tolist()
    assert abs(np.deg2rad(turned.turn) - 0.2) < 1e-9
    far = nearest.of(R, T + np.array([0, 0, -3000.0]))
    assert far.limits == tuple(f"reach of crank {name}" for name in ("B1", "B3", "B5"))
    # The arms hang below their axes in line with the rods.
    assert -2100 < far.T[2] < -1600


def test_fixed_values_and_rails_move_along_drives():
    """The planes of a tripod hold its joints exactly: it moves along its three rails."""
    instance = gspcli.example("three-prs")
    nearest = NearestPoses(instance, np.eye(3), np.array([0, 0, 4.0]))
    found = nearest.of(np.eye(3), np.array([0.3, 0, 6.0]))
    assert {"range of slide B1", "range of slide B2", "range of slide B3"} <= set(found.limits)
    assert abs(found.T[2] - 5.0) < 1e-6


@pytest.mark.parametrize("name", ["workspace-study", "workspace-study-cones"])
def test_an_answer_that_is_outside_by_a_billionth_is_noticed(name):
    nearest = nearest_of(name)
    found = nearest.of(nearest.R, nearest.T + np.array([200.0, 50.0, 300.0]))
    room, slopes = nearest._kernel.slack(
        np.concatenate((found.T, quaternion_from_rotation(found.R)))
    )
    assert kept(nearest.instance, found.R, found.T)
    k = int(room.argmin())
    out = slopes[k, 3:] / (slopes[k, 3:] @ slopes[k, 3:])
    margin = 1e-7 * nearest.length
    less, more = (
        found.T - (room[k] + margin + part * nearest.length) * out for part in (-1e-9, 1e-9)
    )
    assert kept(nearest.instance, found.R, less)
    assert not kept(nearest.instance, found.R, more)
