"""Bounds between the rows of paths hold at all samples, and come near to what they bound."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Shapes
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import condition_numbers
from gspcli.geometry.quaternions import rotation_from_quaternion, rotation_from_vector
from gspcli.motion import mode_groups
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.following.tracks import departures, track_from
from gspcli.motion.paths import planned_paths
from gspcli.motion.paths.between import (
    PathRows,
    ValueParts,
    _rows,
    can_be_bounded,
    condition_bounds,
    drive_travels,
    largest_conditions,
    least_clearances,
    least_gaps,
    least_transmissions,
    pose_track,
    worst_between,
)
from gspcli.motion.paths.planned_paths import largest_rates
from gspcli.motion.paths.ways import PoseWays, ValueWays, WayProof
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.singularities.clearances import clearances, weights_of
from tests.unit.motion.paths.test_ways import MACHINES, ways_of


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize(
    ("size", "moved", "turned"),
    [(1e-2, 1, 1), (1e-3, 1, 1), (1e-3, 0, 1), (1e-3, 1, 0), (1e-5, 1, 1)],
)
def test_no_near_pose_has_a_larger_condition_number(name, size, moved, turned):
    ways, modes = ways_of(name, limits=False)
    a = Arrangement.of(ways.instance)
    R, T = ways.poses(modes[:8])
    shift, turn = moved * size * a.length, turned * size
    count = len(T)
    bound = condition_bounds(a, R, T, np.full(count, shift), np.full(count, turn), a.length)
    draw = np.random.default_rng(5)
    worst = np.zeros(count)
    for _ in range(100):
        axis = draw.normal(size=3)
        half = np.sin(turn / 2) * axis / np.linalg.norm(axis)
        E = rotation_from_quaternion(np.array([np.cos(turn / 2), *half]))
        move = draw.normal(size=3)
        there = E @ R
        place = T + (R - there) @ a.platform_centre + shift * move / np.linalg.norm(move)
        worst = np.maximum(worst, condition_numbers(a, there, place))
    known = np.isfinite(bound)
    assert (worst[known] <= bound[known]).all()
    if size <= 1e-5:
        assert known.mean() > 0.5
        assert (bound[known] < 1.1 * condition_numbers(a, R, T)[known]).all()


def rows_on_values(name, change, count=4):
    """Return rows of a mode along a straight way of values, and its poses at many samples."""
    instance = gspcli.example(name)
    solved = gspcli.solve(instance)
    assert solved.home is not None
    R, T = solved.home.R, solved.home.T
    values = values_at(instance, R, T)
    step = np.resize([1, -1, 0.5, -0.3, 0.8, -1], 6) * change * values
    found = []
    for rows in (count, 200):
        line = values + step * np.linspace(0, 1, rows)[:, None]
        track = track_from(instance, line, R[None], T[None])
        assert track.certified
        assert not track.ends
        found.append((line, track.R[0], track.T[0]))
    free = replace(
        instance, constraints=tuple(replace(row, limits=None) for row in instance.constraints)
    )
    ways = ValueWays(free, np.sign(values))
    weights = weights_of(Machine.of(instance))[0]
    return PathRows.of_values(ways, *found[0], weights), found[1], weights


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("workspace-study", 0.08),
        ("platform-6-6", 0.005),
        ("surfaces-ccc", 0.01),
        ("rubin-m2", 0.02),
    ],
)
def test_bounds_along_values_hold_at_samples(name, change):
    rows, (_, R, T), weights = rows_on_values(name, change)
    instance = rows.instance
    a = Arrangement.of(instance)
    worst = condition_numbers(a, R, T).max()
    at, between = largest_conditions(rows, 1.5 * worst)
    assert at.max() <= worst * (1 + 1e-9)
    assert worst <= between.max() <= 1.5 * worst
    some = slice(None, None, 10)
    least = clearances(rows.machine, R[some], T[some], weights=weights)[0].min()
    at, between = least_clearances(rows, 0.7 * least)
    assert between.min() >= 0.7 * least
    assert between.min() <= at.min()
    # Nothing is nearer to a fold than what is proved.
    assert least >= between.min() * (1 - 1e-9)


@pytest.mark.parametrize("name", ["workspace-study", "fixture-3-2-1", "surfaces-ccc"])
def test_bounds_along_poses_hold_at_samples(name):
    ways, modes = ways_of(name, limits=False)
    instance = ways.instance
    begin = modes[-1]
    end = begin + 0.02 * ways.sizes * [1, -1, 0.5, 1, 1, -1]
    assert ways.prove(begin, end).sign
    parts = np.linspace(0, 1, 3)[:, None]
    parameters = begin + (end - begin) * parts
    R, T = ways.poses(parameters)
    rows = PathRows.of_poses(ways, R, T, parameters)
    many = begin + (end - begin) * np.linspace(0, 1, 300)[:, None]
    R, T = ways.poses(many)
    worst = condition_numbers(Arrangement.of(instance), R, T).max()
    _, between = largest_conditions(rows, 1.5 * worst)
    assert worst <= between.max() <= 1.5 * worst
    some = slice(None, None, 20)
    least = clearances(rows.machine, R[some], T[some], weights=rows.units)[0].min()
    _, between = least_clearances(rows, 0.5 * least)
    assert 0.5 * least <= between.min() <= least * (1 + 1e-9)


def test_a_peak_between_two_rows_is_found():
    """At both rows the condition number is small; between them the mode is nearly singular."""
    platform = gspcli.example("workspace-study")
    ways = PoseWays(platform, limits=False)
    # About z by up to 80 degrees: legs of such hexapods are in one plane bundle near 90.
    turns = np.radians(np.linspace(-80, 80, 401))
    line = np.zeros((401, 6))
    line[:, 2], line[:, 5] = 400.0, turns
    conditions = condition_numbers(Arrangement.of(platform), *ways.poses(line))
    ends = int(conditions[len(line) // 2 :].argmin()) + len(line) // 2
    peak = int(conditions[ends:].argmax()) + ends
    assert conditions[peak] > 2 * conditions[ends]
    before = int(np.flatnonzero(conditions[:peak] < 0.6 * conditions[peak])[-1])
    parameters = line[[ends, before]] if ends != before else line[[ends - 20, before]]
    R, T = ways.poses(parameters)
    rows = PathRows.of_poses(ways, R, T, parameters)
    inner = condition_numbers(
        Arrangement.of(platform),
        *ways.poses(
            parameters[0] + (parameters[1] - parameters[0]) * np.linspace(0, 1, 50)[:, None]
        ),
    ).max()
    assert largest_conditions(rows, 1.2 * inner)[1].max() >= inner


def test_tracks_are_judged_between_their_rows():
    platform = gspcli.example("workspace-study")
    R = np.tile(np.eye(3), (3, 1, 1))
    T = np.array([[0, 0, 400], [40, 0, 420], [0, 30, 380.0]])
    values = gspcli.measure(platform, R, T)
    track = gspcli.track(platform, values, near=(R[0], T[0]))
    assert can_be_bounded(track)
    at = float(np.nanmax(track.conditions))
    assert worst_between(track, "condition", 1.2 * at) is None
    found = worst_between(track, "condition", at * (1 - 1e-6))
    assert found is not None
    assert found.mode == 16
    assert found.bound > at * (1 - 1e-6)
    assert worst_between(track, "clearance", 0.03) is None
    found = worst_between(track, "clearance", 10.0)
    assert found is not None
    assert found.bound < 10
    assert not can_be_bounded(gspcli.track(platform, values, near=(R[0], T[0]), certify=False))
    assert not can_be_bounded(gspcli.track(platform, values[:1], near=(R[0], T[0])))


def test_a_clearance_falls_with_the_way():
    """At least that in the middle less the travel is proved, and never more than at an end."""
    for change in (0.08, 1e-3):
        rows, (_, R, T), _ = rows_on_values("workspace-study", change, count=2)
        at, between = least_clearances(rows, 0.0)
        travel = (np.abs(np.diff(rows.values, axis=0)) / rows.units).max()
        middle = clearances(rows.machine, R[100:101], T[100:101], weights=rows.units)[0][0]
        assert between[0] <= min(at.min(), middle)
        assert between[0] > middle - travel


# Paths of machines with cranks and slides: drives or poses change linearly.


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


# Files of poses of machines with motors, proved between rows; and what their tracks keep there.


ROWS, SAMPLES = 3, 60


def thick(name):
    """Return a machine with rods and arms that have shapes, its home, and the length of its rods.

    The arms are nearer to each other than the rods.
    """
    solved = gspcli.solve(gspcli.example(name))
    home = 0 if solved.home is None else solved.home.number - 1
    size = float(Machine.of(solved.instance).rods[0])
    shapes = Shapes(size / 60, near_joint=size / 10)
    rows = []
    for row in solved.instance.constraints:
        crank = getattr(row.base, "crank", None)
        arm = gspcli.Number.of(size / 8)
        turned = crank and replace(row.base, crank=replace(crank, diameter=arm))
        rows.append(replace(row, base=turned or row.base))
    instance = replace(solved.instance, constraints=tuple(rows), shapes=shapes)
    return instance, solved.R[home].real, solved.T[home].real, size


def tracked(instance, R, T, steps=1):
    """Return the straight ways of poses between rows."""
    return pose_track(
        instance, instance, PoseFrame(), np.arange(float(len(T))), R, T,
        sequence="ZYX", mode=1, steps=steps,
    )  # fmt: skip


def along_rows(numbers):
    """Return numbers at the samples between rows."""
    places = np.linspace(0, ROWS - 1, SAMPLES * (ROWS - 1) + 1)
    return np.stack([np.interp(places, range(ROWS), one) for one in numbers.T], axis=1)


def rows_and_samples(name, along, seed=1, spread=0.05):
    """Return rows of a track about home, and poses with drives at samples of its ways."""
    instance, R0, T0, size = thick(name)
    draw = np.random.default_rng(seed)
    turned = [rotation_from_vector(spread * draw.normal(size=3)) @ R0 for _ in range(ROWS - 1)]
    shifts = spread * size * draw.normal(size=(ROWS - 1, 3))
    R, T = np.stack([R0, *turned]), np.concatenate((T0[None], T0 + shifts))
    motors = Machine.of(instance).at_home(R[0], T[0])
    drives, q = motors, motors.along(R, T)
    if along == "poses":
        found = tracked(instance, R, T)
        assert found.track.ends == ()
        samples = found.ways.poses(along_rows(found.ways.continued(R, T)))
        rows = _rows(found.track, 0, np.arange(ROWS), found.ways, None)
        return rows, *samples, motors.along(*samples)
    values = motors.values(R, T)

    def follow(values, q):
        columns = {one: drives.readings(q)[:, k] for k, one in enumerate(drives.names)}
        return gspcli.track(instance, values, coordinates=columns, near=(R0, T0))

    coarse, fine = follow(values, q), follow(along_rows(values), along_rows(q))
    assert can_be_bounded(coarse)
    rows = _rows(coarse, 0, np.arange(ROWS), None, None)
    return rows, fine.R[0], fine.T[0], along_rows(q)


def sampled(instance, R, T, q):
    """Return gaps, transmissions and condition numbers with a minus, at samples."""
    drives = Machine.of(instance)
    length = Arrangement.of(instance).length
    return {
        least_gaps: ComparedShapes(instance).bounds(R, T, q).high.min(axis=1),
        least_transmissions: drives.transmission(drives.gains(R, T, q)).min(axis=1),
        largest_conditions: -condition_numbers(drives.arrangement(q), R, T, length),
    }


@pytest.mark.parametrize("along", ["poses", "drives"])
@pytest.mark.parametrize("name", ["reachy-mini-head", "modified-paradex"])
def test_no_sample_is_worse_than_what_is_proved(name, along):
    rows, *samples = rows_and_samples(name, along)
    for bound, numbers in sampled(rows.instance, *samples).items():
        worse = -1 if bound is largest_conditions else 1
        least = np.minimum(numbers[:-1].reshape(-1, SAMPLES).min(axis=1), numbers[SAMPLES::SAMPLES])
        room = 1e-9 * np.abs(least)
        for wanted in (least.min() - 2e-3 * abs(least.min()), least.max(), -1e9):
            proved = worse * bound(rows, worse * wanted)[1]
            assert (proved <= least + room).all()
            assert not (proved >= wanted)[least < wanted - room].any()
            # What is well above is proved.
            assert (proved >= wanted)[least > wanted + 1e-3 * abs(wanted)].all()


def test_rows_have_the_numbers_of_their_motors():
    instance, R0, T0, size = thick("three-prs")
    T = T0 + np.array([[0, 0, 0], [0, 0, 0.1 * size]])
    found = tracked(instance, np.stack([R0, R0]), T, steps=4)
    track = found.track
    assert [one.name for one in track.coordinates] == ["slide.B1", "slide.B2", "slide.B3"]
    motors = Machine.of(instance).at_home(R0, T0)
    assert (track.places == motors.along(track.R[0], track.T[0])[:, :3]).all()
    assert (track.values[:, :3] == motors.rods[:3]).all()
    assert (found.limits, track.events, len(track.t)) == ((), (), 5)


def test_a_range_that_a_slide_leaves():
    instance, R0, T0, _ = thick("three-prs")
    T = T0 + np.array([[0, 0, 0], [0, 0, 1.5]])
    found = tracked(instance, np.stack([R0, R0]), T)
    assert sorted(one.drive for one in found.limits) == ["slide.B1", "slide.B2", "slide.B3"]
    for one in found.limits:
        assert one.proved
        assert (one.low, one.high) == pytest.approx((1 / 1.5, 1 / 1.5), abs=1e-9)
    assert found.track.ends == ()


def test_a_way_beyond_the_reach_of_the_rods_ends():
    """A row that is not reached is refused; of two that are the way between them may not be."""
    instance, R0, T0, size = thick("reachy-mini-head")
    T = T0 + size * np.array([[0, 0, 0], [0, 0, 10]])
    with pytest.raises(ArgumentError, match=r"at t = 1: the leg of crank.B1 does not reach"):
        tracked(instance, np.stack([R0, R0]), T)
    delta = gspcli.example("delta")
    T = np.array([[-890.0, 811.0, -732.0], [585.0, -1107.0, -112.0]])
    (event,) = tracked(delta, np.tile(np.eye(3), (2, 1, 1)), T).track.ends
    assert event.reason == "a rod does not reach its motor on the straight way"


def test_rods_that_share_a_motor_do_not_turn():
    delta = gspcli.example("delta")
    R0, T0 = delta.home.R(1.0), np.array([delta.home.T] * 2)
    R = np.stack([R0, rotation_from_vector([0, 0, 1e-12]) @ R0])
    (event,) = tracked(delta, R, T0 + np.eye(3)[:2]).track.ends
    assert event.reason == "rods that share a motor are not parallel on the straight way"


def test_a_range_that_is_left_and_kept_again_on_one_way():
    """Of a way up and down the slides leave their range in between; samples show where."""
    instance = gspcli.example("workspace-study")
    T = np.array([[-100, 0, 401], [100, 0, 401.0]])
    R = np.tile(np.eye(3), (2, 1, 1))
    t = np.linspace(0, 1, 2001)
    lengths = gspcli.measure(
        instance, np.tile(np.eye(3), (2001, 1, 1)), T[0] + t[:, None] * (T[1] - T[0])
    )
    least = (lengths[[0, -1]].min(axis=0) + lengths.min(axis=0)) / 2
    rows = [
        replace(row, limits=(gspcli.Number.of(low), gspcli.Number.of(600)))
        for row, low in zip(instance.constraints, least.tolist(), strict=True)
    ]
    found = tracked(replace(instance, constraints=tuple(rows)), R, T)
    outside = lengths < least
    for k in range(6):
        events = [one for one in found.limits if one.constraint == k]
        changes = np.flatnonzero(np.diff(outside[:, k]))
        assert [one.leaves for one in events] == outside[changes + 1, k].tolist()
        for one, j in zip(events, changes.tolist(), strict=True):
            assert one.proved
            assert t[j] <= one.low <= one.high <= t[j + 1]
            assert one.high - one.low < 1e-8


def test_a_wider_change_of_drives_leaves_a_way_undecided(monkeypatch):
    """A range is kept on a way only if the drives are proved to move no farther."""
    instance, R0, T0, size = thick("three-prs")
    T = T0 + np.array([[0, 0, 0], [0, 0, 0.1 * size]])
    prove = PoseWays.prove

    def open_(ways, *ends):
        inside = ways._conditions == ways.boxes.conditions
        return WayProof(0, 0, "limit") if inside else prove(ways, *ends)

    monkeypatch.setattr(PoseWays, "prove", open_)
    assert tracked(instance, np.stack([R0, R0]), T).limits == ()
    monkeypatch.setattr(
        PathRows, "moved", lambda self, begins, _: np.full((len(begins), 6), np.inf)
    )
    limits = tracked(instance, np.stack([R0, R0]), T).limits
    assert [(one.drive, one.proved) for one in limits] == [
        ("slide.B1", False), ("slide.B2", False), ("slide.B3", False)
    ]  # fmt: skip


def test_drives_that_stay_have_their_points_where_the_file_states_them():
    """The lengths of rods change: nothing is asked of the cranks."""
    instance, R0, T0, size = thick("reachy-mini-head")
    base = gspcli.measure(instance, R0, T0)
    values = np.stack([base, base + 0.02 * size * np.array([1, -1, 1, -1, 1, -1])])
    track = gspcli.track(instance, values, near=(R0, T0))
    assert can_be_bounded(track)
    drives = Machine.of(instance)
    q = np.zeros((2, drives.count))
    ends = ComparedShapes(instance).bounds(track.R[0], track.T[0], q).low.min()
    found = worst_between(track, "gap", ends + size)
    assert found is None or found.bound <= ends
    assert worst_between(track, "gap", ends - 0.2 * abs(ends)) is None


def test_a_planned_path_of_drives_keeps_a_gap():
    instance, R, T, size = thick("reachy-mini-head")
    goal = rotation_from_vector([0.08, -0.05, 0.06]) @ R, T + 0.05 * size
    compared = ComparedShapes(instance)
    ends = min(compared.gaps(one[None], two[None]).min() for one, two in ((R, T), goal))
    found = gspcli.path(instance, (R, T), goal, along="values", gap=ends - size / 10)
    assert (found.verdict, found.along) == ("proved", "drives")
    assert ends - size / 10 <= min(part.gap for part in found.parts) <= found.gaps.min()
    between = gspcli.path(instance, (R, T), goal, along="values", gap=ends + size / 10)
    assert between.verdict == "impossible"


def test_joints_on_a_piece_of_a_way_of_drives_are_as_near_as_is_said():
    rows, *_ = rows_and_samples("reachy-mini-head", "drives")
    drives = rows.machine
    parts = ValueParts(rows, np.array([0]), 4)
    which = np.arange(len(parts.way))
    low, high = parts.begin, parts.end
    middle = parts.near(which, low, high)
    assert (middle.slips > 0).all()
    for place in (-0.5, -0.2, 0.4, 0.5):
        here = (low + high) / 2 + place * (high - low)
        there = parts.near(which, here, here)
        moved = np.linalg.norm(drives.points(there.q) - drives.points(middle.q), axis=-1)
        assert (moved <= middle.slips).all()
        assert (moved > 0.3 * abs(place) * middle.slips).all()
    first_and_last = np.array([0.0, 1.0])
    ends = parts.near(which[[0, -1]], first_and_last, first_and_last).q
    assert ends == pytest.approx(rows.numbers[[0, 1]], abs=1e-12)


# Speeds, accelerations and travels of drives, compared with differences of many samples.


PIVOT = np.array([0.1, 0.2, -0.05])
NAMES = [
    *("workspace-study", "six-planes", "figure-2", "fixture-3-2-1", "surfaces-scc"),
    *("example-6.8", "hexaglide", "t-top-head", "reachy-mini-head"),
]


def ways_and_home(name, sequence):
    instance = gspcli.example(name)
    solved = gspcli.solve(instance)
    home = solved.home or solved.solutions[int(np.flatnonzero(solved.real)[0])]
    R, T = home.R.real, home.T.real
    signs = Machine.of(instance).at_home(R, T).signs
    return PoseWays(instance, pivot=PIVOT, sequence=sequence, working_modes=signs), R, T


@pytest.mark.parametrize("sequence", ["ZYX", "xyz", "YXZ"])
@pytest.mark.parametrize("name", NAMES)
def test_rates_are_those_of_many_samples(name, sequence):
    ways, R, T = ways_and_home(name, sequence)
    machine = ways.machine
    draw = np.random.default_rng(3)
    velocity = draw.normal(size=6) * 0.003 * ways.sizes
    place = ways.parameters(R, T)
    speeds, bends = largest_rates(ways, place, velocity)
    t = np.linspace(0, 1, 1001)[:, None]
    turned, moved = ways.poses(place + velocity * t)
    if machine.moves:
        numbers = machine.along(turned, moved) / machine.units
    else:
        numbers = values_at(ways.instance, turned, moved)
    step = t[1, 0]
    seen = np.abs(np.diff(numbers, axis=0)).max(axis=0) / step
    seen_bends = np.abs(np.diff(numbers, 2, axis=0)).max(axis=0) / step**2
    assert (seen <= speeds[:-2]).all()
    assert speeds[:-2] == pytest.approx(seen, rel=1e-2)
    assert bends[:-2] == pytest.approx(seen_bends, rel=1e-2, abs=1e-7 * np.abs(numbers).max())
    spin = turned[:-1].swapaxes(1, 2) @ turned[1:]
    angle = np.arccos(np.minimum((np.trace(spin, axis1=1, axis2=2) - 1) / 2, 1))
    assert angle.max() / step == pytest.approx(speeds[-1], rel=0.01)
    assert np.linalg.norm(velocity[:3]) == pytest.approx(speeds[-2], rel=0.01)


@pytest.mark.parametrize("sequence", ["ZYX", "xyz", "YXZ"])
@pytest.mark.parametrize("name", NAMES)
def test_drives_move_at_most_as_far_as_is_proved_and_nearly_as_far(name, sequence):
    ways, R, T = ways_and_home(name, sequence)
    machine, draw = ways.machine, np.random.default_rng(3)
    place = ways.parameters(R, T)
    ends = place + draw.normal(size=6) * 0.003 * ways.sizes * [[1.0], [0.01]]
    found = drive_travels(ways, np.stack((place, place)), ends)
    for bound, end in zip(found, ends, strict=True):
        turned, moved = ways.poses(place + (end - place) * np.linspace(0, 1, 400)[:, None])
        if machine.moves:
            numbers, angles = machine.along(turned, moved), []
        else:
            given = Arrangement.of(ways.instance)
            numbers, angles = values_at(ways.instance, turned, moved), given.angles
            numbers[:, angles] *= given.in_radians
        seen = np.abs(np.diff(numbers, axis=0)).sum(axis=0)
        assert (seen <= bound + 1e-12).all()
        # Of an angle the bound is that of the turn.
        others = np.delete(np.arange(len(bound)), angles)
        assert (bound[others] <= 1.02 * seen[others] + 1e-12).all()
