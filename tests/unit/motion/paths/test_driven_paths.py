"""Paths of machines with cranks and slides: drives or poses change linearly."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion import mode_groups
from gspcli.motion.following.tracks import departures
from gspcli.motion.paths import planned_paths
from gspcli.motion.paths.between import PathRows
from gspcli.motion.paths.ways import PoseWays
from gspcli.motion.singularities.clearances import clearances, weights_of

#: Machines with six freedoms; delta and three-prs have three.
SIX = ("t-top-head", "reachy-mini-head", "hexaglide", "modified-paradex")


def home_of(instance):
    solved = gspcli.solve(instance)
    one = solved.home or solved.solutions[int(np.flatnonzero(solved.real)[0])]
    return one.R.real, one.T.real


def near(instance, turn, shift, seed=0):
    R, T = home_of(instance)
    length = gspcli.geometry.arrangement.Arrangement.of(instance).length
    if instance.type.id.count("DPP") < 6 or len(Machine.of(instance).names) < 6:
        return R, T + shift * length * np.eye(3)[2]
    draw = np.random.default_rng(seed)
    turned = rotation_from_vector(turn * draw.normal(size=3)) @ R
    return turned, T + shift * length * draw.normal(size=3)


def checked(found, start):
    """Rows are poses that the drives reach in their modes; the kernel follows them again."""
    assert found.verdict == "proved"
    instance, R, T, q = found.instance, found.R, found.T, found.drives
    motors = Machine.of(instance).at_home(*start)
    drives = motors
    assert motors.keeps(R, T).all()
    assert not drives.outside(q).any()
    rods = np.linalg.norm(drives.ends(R, T, q)[2], axis=-1)
    size = np.nanmax(drives.rods)
    assert np.abs(rods - drives.rods)[:, drives.driven].max() < 1e-9 * size
    gains = drives.gains(R, T, q)[:, drives.driven]
    assert (np.sign(gains) == motors.signs[drives.driven]).all()
    moved = np.flatnonzero(drives.moved)
    columns = {drives.names[k]: drives.readings(q)[:, k] for k in moved}
    followed = gspcli.track(
        instance, found.values, coordinates=columns, near=(R[0], T[0]), t=found.t
    )
    assert followed.certified
    assert followed.ends == ()
    assert departures(followed, R, T) == []
    return found


@pytest.mark.parametrize("along", ["drives", "poses"])
@pytest.mark.parametrize("name", [*SIX, "delta", "three-prs"])
def test_straight_ways(name, along):
    instance = gspcli.example(name)
    start, goal = home_of(instance), near(instance, 0.05, 0.03)
    asked = "values" if along == "drives" else along
    found = checked(gspcli.path(instance, start, goal, along=asked, pivot=[0, 0, 0]), start)
    assert (found.along, len(found.parts)) == (along, 1)
    assert found.parts[0].pieces > 0
    assert np.abs(found.T[-1] - goal[1]).max() < 1e-9 * np.abs(goal[1]).max()
    assert np.abs(found.R[-1] - goal[0]).max() < 1e-9
    numbers = found.drives if along == "drives" else found.T
    bent = np.diff(numbers, 2, axis=0)
    assert np.abs(bent).max() < 1e-9 * (np.abs(numbers).max() + 1)


def test_columns_are_readings_of_the_drives():
    found = gspcli.path(gspcli.example("three-prs"), "home", (np.eye(3), [0, 0, 4.5]))
    row = found.rows()[-1]
    assert list(row)[:7] == ["t", "slide.B1", "slide.B2", "slide.B3", "4", "5", "6"]
    assert row["slide.B1"] == pytest.approx(0.5)
    assert "clearance" not in row


def test_a_goal_out_of_the_range_of_a_drive():
    instance = gspcli.example("three-prs")
    found = gspcli.path(instance, "home", (np.eye(3), [0, 0, 5.5]))
    assert found.verdict == "impossible"
    assert "slide B1 at 1.5 is outside its range from -1 to 1" in found.reason
    found = gspcli.path(gspcli.example("t-top-head"), "home", 1)
    assert found.reason.startswith("mode 1 is outside the limits: crank B1 is beyond a dead point")


def test_a_map_of_poses_joins_modes():
    instance = gspcli.example("hexaglide")
    solved = gspcli.solve(instance)
    start = tuple(part[solved.real].real[0] for part in (solved.R, solved.T))
    found = checked(gspcli.path(instance, 1, 4, time=1000), start)
    assert len(found.parts) > 1
    assert found.along == "poses"
    assert found.conditions.max() < 1e4


def test_modes_beyond_dead_points_are_outside():
    groups = mode_groups(gspcli.example("three-prs"), time=0.1)
    outside = [one for one in groups.modes if one.group is None]
    assert [one.mode for one in outside] == [2, 3, 6, 7]
    assert all("is beyond a dead point from home" in one.left for one in outside)
    assert 8 in groups.groups


def test_motors_are_not_quicker_than_asked():
    instance = gspcli.example("t-top-head")
    goal = near(instance, 0.1, 0.05)
    for along in ("values", "poses"):
        found = gspcli.path(instance, "home", goal, along=along, speed=10.0, acceleration=20.0)
        readings = np.degrees(found.drives)
        gaps = np.diff(found.t)[:, None]
        mean = np.diff(readings, axis=0) / gaps
        bent = np.diff(mean, axis=0) / ((gaps[1:] + gaps[:-1]) / 2)
        assert 5 < np.abs(mean).max() <= 10 * (1 + 1e-6)
        assert 10 < np.abs(bent).max() <= 20 * (1 + 1e-6)


def test_without_a_proof_of_the_working_modes_there_is_no_straight_way_of_drives(monkeypatch):
    instance = gspcli.example("t-top-head")
    goal = near(instance, 0.05, 0.03)
    monkeypatch.setattr(planned_paths, "keeps_working_modes", lambda _: False)
    assert gspcli.path(instance, "home", goal, along="values").verdict == "not found"


def test_a_way_of_drives_ends_at_its_goal():
    """With the drives of another mode the straight way comes to a pose that is not the goal."""
    instance = gspcli.example("hexaglide")
    solved = gspcli.solve(instance)
    R, T = (part[solved.real].real for part in (solved.R, solved.T))
    found = gspcli.path(instance, (R[6], T[6]), (R[0], T[0]), along="values")
    assert found.verdict != "proved"


def test_rods_that_share_a_crank_keep_the_orientation():
    instance = gspcli.example("delta")
    R, T = home_of(instance)
    turned = rotation_from_vector([0, 0, 0.01]) @ R
    found = gspcli.path(instance, (R, T), (turned, T), along="poses")
    assert found.verdict in ("impossible", "not found")


def test_a_map_of_positions_where_rods_share_cranks():
    """The straight way leaves what the rods reach; all poses have the orientation of the ends."""
    instance = gspcli.example("delta")
    start, goal = (np.eye(3), [-890.0, 811.0, -732.0]), (np.eye(3), [585.0, -1107.0, -112.0])
    ways = PoseWays(instance, working_modes=Machine.of(instance).at_home(*start).signs)
    assert not ways.prove(*(ways.parameters(*one) for one in (start, goal))).sign
    found = gspcli.path(instance, start, goal, along="poses")
    assert (found.verdict, found.along) == ("proved", "poses")
    assert len(found.parts) > 1
    assert (np.eye(3) == found.R).all()
    assert ways.machine.keeps(found.R, found.T).all()
    assert found.T[[0, -1]] == pytest.approx(np.array([start[1], goal[1]]))


def test_a_long_straight_way_of_drives_passes_no_dead_point():
    instance = gspcli.example("delta")
    start, goal = (np.eye(3), [-890.0, 811.0, -732.0]), (np.eye(3), [585.0, -1107.0, -112.0])
    found = gspcli.path(instance, start, goal)
    assert (found.verdict, found.along, len(found.parts)) == ("proved", "drives", 1)
    machine = Machine.of(instance).at_home(*start)
    gains = machine.gains(found.R, found.T, found.drives)
    assert (np.sign(gains) == np.sign(gains[0])).all()
    assert machine.transmission(gains)[:, machine.driven].min() > 0.2


@pytest.mark.parametrize("along", ["values", "poses"])
def test_a_clearance_of_the_drives_is_kept_between_the_rows(along):
    instance = gspcli.example("three-prs")
    start, goal = home_of(instance), near(instance, 0.0, 0.03)
    ends = [clearances(Machine.of(instance), R[None], T[None])[0][0] for R, T in (start, goal)]
    clear = 0.7 * min(ends)
    found = checked(gspcli.path(instance, start, goal, along=along, clear=clear), start)
    assert found.clearances[[0, -1]].tolist() == pytest.approx(ends, rel=1e-9)
    assert clear <= found.parts[0].clearance < min(ends)
    assert found.rows()[0]["clearance"] == found.clearances[0]
    middle = found.T[:-1] + np.diff(found.T, axis=0) / 3
    assert (
        clearances(Machine.of(instance), found.R[:-1], middle)[0] >= found.parts[0].clearance
    ).all()


def test_more_clearance_than_the_start_has_is_not_kept():
    instance = gspcli.example("three-prs")
    start = home_of(instance)
    clear = 1.1 * clearances(Machine.of(instance), start[0][None], start[1][None])[0][0]
    goal = near(instance, 0.0, 0.03)
    found = gspcli.path(instance, start, goal, clear=clear, along="values", time=0)
    assert found.verdict == "not found"


@pytest.mark.parametrize("along", ["values", "poses"])
def test_how_far_drives_move_between_rows_is_bounded_closely(along):
    instance = gspcli.example("t-top-head")
    found = gspcli.path(instance, "home", near(instance, 0.05, 0.03), along=along)
    motors = Machine.of(instance).at_home()
    ways = PoseWays(instance, working_modes=motors.signs)
    if along == "values":
        rows = PathRows.of_drives(motors, None, found.drives, found.R, found.T)
    else:
        rows = PathRows.of_poses(ways, found.R, found.T, ways.continued(found.R, found.T))
    weights = weights_of(motors)[0]
    moved = (np.abs(np.diff(found.drives, axis=0)) / weights).max(axis=1)
    travels = (rows.travels() / weights).max(axis=1)
    assert (travels >= moved).all()
    assert (travels <= 1.2 * moved).all()
