"""Planned paths, checked by following them again; and proofs that there is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.machine import Machine
from gspcli.geometry.numbers import Number
from gspcli.motion import mode_groups
from gspcli.motion.following.tracks import departures, track_from
from gspcli.motion.paths import planner
from gspcli.motion.paths.between import limit_events
from gspcli.motion.paths.planned_paths import LineMove, PathEnd, PathLimits, ValueGuide, moves_of
from gspcli.motion.paths.planner import Planner, finished
from gspcli.motion.poses.inverse_kinematics import values_at


def checked(found):
    """Follow a path again by its values: it stays at its poses, and within the limits."""
    assert found.verdict == "proved"
    followed = track_from(found.instance, found.values, found.R[:1], found.T[:1])
    assert followed.certified
    assert followed.ends == ()
    assert departures(followed, found.R, found.T) == []
    assert limit_events(followed) == []
    assert Machine.of(found.instance).keeps(found.R, found.T).all()
    return found


@pytest.fixture(scope="module")
def study():
    return gspcli.example("workspace-study")


@pytest.fixture(scope="module")
def around(study):
    """A path with corners: its ends have the same values."""
    return checked(gspcli.path(study, "home", 3))


def test_a_path_around_has_all_its_parts(study, around):
    solved = gspcli.solve(study)
    T = solved.T[solved.real].real
    assert np.abs(around.T[0] - T[15]).max() < 1e-9
    assert np.abs(around.T[-1] - T[2]).max() < 1e-9
    assert len(around.parts) > 1
    assert around.parts[0].first == 0
    assert around.parts[-1].last == len(around.t) - 1
    assert all(a.last == b.first for a, b in zip(around.parts, around.parts[1:], strict=False))
    assert (np.diff(around.t) > 0).all()
    assert around.straight_length < around.length < 5 * around.straight_length
    assert max(part.condition for part in around.parts) == around.conditions.max()


def test_the_same_seed_gives_the_same_path(study, around):
    again = gspcli.path(study, "home", 3, time=1000)
    assert again.to_json() == around.to_json()
    other = gspcli.path(study, "home", 3, seed=1)
    assert other.to_json() != around.to_json()


def test_straight_ways_come_first(study):
    home = np.eye(3), np.array([0.0, 0, 400])
    there = home[0], np.array([10.0, 20, 410])
    found = checked(gspcli.path(study, home, there))
    assert (found.along, len(found.parts)) == ("values", 1)
    found = checked(gspcli.path(study, home, there, along="poses"))
    assert (found.along, len(found.parts)) == ("poses", 1)
    middle = found.T[len(found.T) // 2]
    assert np.abs(np.cross(middle - home[1], there[1] - home[1])).max() < 1e-9
    assert found.length == pytest.approx(found.straight_length, rel=1e-12)


def test_the_pose_where_one_is(study):
    found = checked(gspcli.path(study, "home", "home"))
    assert found.length == found.straight_length == 0


@pytest.mark.parametrize(
    ("name", "start", "goal", "reason"),
    [
        ("workspace-study", 16, 2, "the sign of det J differs"),
        ("rubin-camera", "home", 5, "the mode fills its box of ranges"),
        ("surfaces-scc", 1, 4, "the sign of the factor of constraints 4, 5, 6 (angles) differs"),
        ("workspace-study-cones", 8, 1, "mode 1 is outside the limits: leg 2 is tilted by"),
    ],
)
def test_no_path_proved(name, start, goal, reason):
    found = gspcli.path(gspcli.example(name), start, goal)
    assert found.verdict == "impossible"
    assert reason in found.reason
    assert found.rows() == []


def test_neither_found_nor_impossible_in_no_time(study):
    found = gspcli.path(study, "home", 3, time=0)
    assert found.verdict == "not found"
    assert found.parts == ()


def test_without_ranges_paths_are_along_poses():
    platform = gspcli.example("nano-hexapod")
    groups = mode_groups(platform)
    first, second = groups.groups[1][:2]
    found = checked(gspcli.path(platform, first, second))
    assert found.along == "poses"


def test_a_clearance_is_kept_between_the_rows(study):
    home = np.eye(3), np.array([0.0, 0, 400])
    there = home[0], np.array([10.0, 20, 410])
    free = gspcli.path(study, home, there)
    least = min(part.clearance for part in free.parts)
    assert least > 0.03
    found = checked(gspcli.path(study, home, there, clear=least))
    assert min(part.clearance for part in found.parts) >= least
    assert gspcli.path(study, home, there, clear=0.5, time=0).verdict == "not found"


def test_offsets_of_readings_are_not_values(study):
    rows = list(study.constraints)
    rows[0] = replace(rows[0], offset=Number.of(7))
    offset = replace(study, constraints=tuple(rows))
    found = gspcli.path(offset, "home", (np.eye(3), [0, 0, 405.0]))
    first = found.rows()[0]["1"]
    assert first == pytest.approx(found.values[0, 0] - 7)


@pytest.mark.parametrize(
    ("name", "groups", "alone"),
    [
        ("rubin-camera", [[1, 5, 6], [2, 3, 4], [7], [8]], [7, 8]),
        ("rubin-m2", [[1], [2]], [1, 2]),
        ("apo-tertiary", [[k] for k in range(1, 9)], list(range(1, 9))),
        ("sdss-primary", [[k] for k in range(1, 9)], list(range(1, 9))),
        ("surfaces-sss", [[1, 5], [2, 6], [3, 7], [4, 8]], []),
        ("platform-5-5", None, []),
    ],
)
def test_groups_of_modes(name, groups, alone):
    found = mode_groups(gspcli.example(name))
    assert found.complete
    if groups is None:
        assert len(found.groups) == 2
    else:
        assert list(found.groups.values()) == groups
    assert [one.mode for one in found.modes if one.alone] == alone
    rows = found.rows()
    assert [row["mode"] for row in rows] == list(range(1, len(rows) + 1))


def test_modes_outside_the_limits_are_in_no_group():
    found = mode_groups(gspcli.example("workspace-study-cones"))
    assert list(found.groups.values()) == [[8]]
    assert [one.group for one in found.modes[:7]] == [None] * 7


def test_groups_that_are_not_joined_in_no_time_are_undecided(study):
    found = mode_groups(study, time=0)
    assert not found.complete
    assert len(found.groups) > 2
    assert all(row["apart"] is False for row in found.rows())


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"start": 17}, "found mode 17, expected one of the 16"),
        ({"start": "here"}, "found 'here', expected a number"),
        ({"start": (np.eye(3)[None], np.zeros((1, 3)))}, "expected one"),
        ({"along": "lines"}, "found 'lines', expected values or poses"),
        ({"clear": -1.0}, "found -1.0, expected a number that is not negative"),
        ({"clear": np.nan}, "expected a number that is not negative"),
        ({"time": np.inf}, "expected seconds"),
        ({"seed": 0.5}, "expected a whole number"),
        ({"sequence": "XXY"}, "expected three different axes"),
    ],
)
def test_wrong_arguments(study, arguments, match):
    given = {"start": "home", "goal": 3, "time": 0} | arguments
    with pytest.raises(GspError, match=match):
        gspcli.path(study, given.pop("start"), given.pop("goal"), **given)


def test_a_distance_of_lines_does_not_pass_zero_along_values():
    """The value turns at zero: the way there and back is no path of values."""
    platform = gspcli.example("surfaces-ppp")
    lines = [k for k, row in enumerate(platform.constraints) if row.kind.name == "DLL"]
    assert lines
    solved = gspcli.solve(platform)
    R, T = (part[solved.real].real for part in (solved.R, solved.T))
    from gspcli.motion.paths.ways import ValueWays

    values = gspcli.measure(platform, R, T)
    ways = ValueWays(platform, np.sign(values[0]))
    row = np.asarray(values[0]).copy()
    assert ways.kept(row)
    row[lines[0]] = 0.0
    assert not ways.kept(row)
    assert Arrangement.of(platform).kinds[lines[0]].name == "DLL"


def test_a_path_of_poses_within_ranges_is_found_along_one_of_values():
    study = gspcli.example("workspace-study")
    found = gspcli.path(study, "home", 3, along="poses")
    assert (found.verdict, found.along) == ("proved", "poses")
    assert Machine.of(study).keeps(found.R, found.T).all()
    assert found.length < 3 * found.straight_length


def test_the_time_is_looked_at_after_each_path_that_is_tried(monkeypatch):
    """Paths that do not keep a clearance are refused one by one, and each takes long."""
    study = gspcli.example("workspace-study")
    looked, tried = [], []
    monkeypatch.setattr(planner.time, "monotonic", lambda: looked.append(1) or len(looked))
    trace = ValueGuide.trace

    def counted(guide, corners, rows):
        tried.append(len(corners) > 2)
        return trace(guide, corners, rows)

    monkeypatch.setattr(ValueGuide, "trace", counted)
    found = gspcli.path(study, "home", 3, clear=0.02, time=8, along="values")
    assert found.verdict == "not found"
    assert 0 < sum(tried) <= len(looked) <= 11


# Speeds and accelerations along planned paths, measured at samples between all rows.


SPEED, ACCELERATION = 50.0, 200.0


def rates(found, samples=20_000):
    """Return the largest speed and acceleration of each value, from differences of samples."""
    moves = found.timing.moves
    times = np.linspace(0, moves.seconds, samples + 1)
    numbers = moves.at(times)[0]
    if found.along == "poses":
        numbers = values_at(found.instance, *Planner(found.instance).ways.poses(numbers))
    step = times[1]
    speeds = np.abs(np.diff(numbers, axis=0)) / step
    return speeds.max(), (np.abs(np.diff(numbers, 2, axis=0)) / step**2).max(), numbers


def least_time(found, speed, acceleration):
    """Return how long the motors need at least from the first to the last values, rest to rest."""
    far = np.abs(found.values[-1] - found.values[0]).max()
    reached = far >= speed**2 / acceleration
    return far / speed + speed / acceleration if reached else 2 * np.sqrt(far / acceleration)


def checked_of_timing(found, speed=SPEED, acceleration=ACCELERATION):
    """Limits hold between the rows, rows are where the moves are, and the way is proved."""
    v, a, numbers = rates(found)
    assert 0.5 * speed < v < speed * (1 + 1e-6)
    assert 0.5 * acceleration < a < acceleration * (1 + 1e-4)
    assert found.timing.seconds >= least_time(found, speed, acceleration) * (1 - 1e-9)
    assert np.abs(numbers[-1] - found.values[-1]).max() < 1e-9 * np.abs(numbers).max()
    gaps = np.diff(found.t)
    assert (gaps > 0).all()
    assert found.t[-1] == found.timing.seconds
    # What a reader of the file computes from its rows.
    mean = np.diff(found.values, axis=0) / gaps[:, None]
    bent = np.diff(mean, axis=0) / ((gaps[1:] + gaps[:-1]) / 2)[:, None]
    assert np.abs(mean).max() < speed * (1 + 1e-6)
    assert np.abs(bent).max() < acceleration * (1 + 1e-6)
    followed = track_from(found.instance, found.values, found.R[:1], found.T[:1])
    assert followed.ends == ()
    assert departures(followed, found.R, found.T) == []
    return found


@pytest.fixture(scope="module")
def plain(study):
    """A path with corners, without a time."""
    return gspcli.path(study, "home", 3)


def timed(study, goal, **more):
    return gspcli.path(study, "home", goal, speed=SPEED, acceleration=ACCELERATION, **more)


def around_of_timing(plain, *, clear=0.0):
    """Return the path with corners with a time: it is not planned again."""
    ends = [
        PathEnd(name, *(getattr(plain, key)[row] for key in ("values", "R", "T")))
        for name, row in ((plain.start, 0), (plain.goal, -1))
    ]
    planner = Planner(plain.instance, clear=clear)
    guide = planner.value_guide(planner.values(ends[0]), *ends)
    corners = plain.values[[0, *(part.last for part in plain.parts)]]
    limits = PathLimits.of(SPEED, ACCELERATION)
    return finished(plain.instance, guide, corners, *ends, limits)


def test_a_path_that_is_planned_with_a_speed(study, plain):
    found = timed(study, 3)
    again = around_of_timing(plain)
    assert found.timing.to_json() == again.timing.to_json()
    assert np.abs(found.values - again.values).max() < 1e-9
    assert np.array_equal(found.t, again.t)


def test_a_path_around_stops_at_corners(plain):
    found = checked_of_timing(around_of_timing(plain))
    assert len(found.timing.moves.tops) == len(found.parts) == len(plain.parts)
    # At rest at each corner: the path is the same.
    corners = found.values[[part.last for part in found.parts]]
    assert np.array_equal(corners, plain.values[[part.last for part in plain.parts]])
    moves = found.timing.moves
    ends = [found.t[part.last] for part in found.parts[:-1]]
    short = 1e-6
    near = moves.at(np.add.outer(ends, (0.0, short)).ravel())[0].reshape(len(ends), 2, -1)
    assert np.abs(np.diff(near, axis=1)).max() < ACCELERATION * short**2


def test_motors_keep_limits_on_ways_of_poses(study):
    goal = np.eye(3), [40.0, 20, 430]
    found = checked_of_timing(timed(study, goal, along="poses"))
    assert (found.along, len(found.parts)) == ("poses", 1)


def test_the_platform_keeps_limits_around_corners():
    platform = gspcli.example("surfaces-sss")
    speed = {"drives": 1.0, "platform": 0.005, "turn": 20.0}
    acceleration = {"platform": 0.02, "turn": 60.0}
    more = {"speed": speed, "acceleration": acceleration}
    found = gspcli.path(platform, 1, 5, **more)
    assert len(found.parts) > 1
    v, _, _ = rates(found)
    assert 0.5 < v < 1 + 1e-6
    moves = found.timing.moves
    times = np.linspace(0, moves.seconds, 40_001)
    numbers, step = moves.at(times)[0], times[1]
    velocity = np.diff(numbers[:, :3], axis=0) / step
    assert 0.004 < np.linalg.norm(velocity, axis=1).max() <= 0.005 * (1 + 1e-6)
    bend = np.diff(velocity, axis=0) / step
    assert np.linalg.norm(bend, axis=1).max() <= 0.02 * (1 + 1e-4)
    R = rotation_from_euler("ZYX", numbers[:, 3:])
    step = np.swapaxes(R[:-1], 1, 2) @ R[1:]
    cosine = (np.trace(step, axis1=1, axis2=2) - 1) / 2
    assert np.degrees(np.arccos(np.minimum(cosine, 1)).max()) / times[1] < 20 * (1 + 1e-3)


def test_a_clearance_is_kept_around_corners(plain):
    least = min(plain.clearances) / 4
    assert least > 0
    found = around_of_timing(plain, clear=least)
    assert len(found.parts) > 1
    assert min(part.clearance for part in found.parts) >= least


def test_nothing_moves_in_no_time(study):
    found = timed(study, "home")
    assert found.timing.seconds < 1e-6


def test_a_short_part_does_not_reach_its_speed():
    """Speeds rise and fall at 2 a second squared: a way of 0.1 takes 2 sqrt(0.1 / 2) s."""
    lines = [LineMove(np.array([w, 0.0]), w, 2.0) for w in (10.0, 0.1)]
    moves = moves_of(np.array([[0, 0], [10, 0], [10.1, 0]]), lines)
    assert np.diff(moves.begins) == pytest.approx([10.5, 2 * np.sqrt(0.05)])
    places, parts = moves.at(np.array([0.5, 10.5 + np.sqrt(0.05), moves.seconds]))
    assert places[:, 0] == pytest.approx([0.25, 10.05, 10.1])
    assert parts.tolist() == [0, 1, 1]


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"speed": 5}, "acceleration: found none"),
        ({"acceleration": 5}, "speed: found none"),
        ({"speed": 0, "acceleration": 5}, "found 0.0 for drives"),
        ({"speed": np.nan, "acceleration": 5}, "found nan for drives"),
        ({"speed": {"motor": 1}, "acceleration": 5}, "found 'motor'"),
        ({"speed": {"turn": 1}, "acceleration": 5}, "found no limit of the drives"),
        (
            {"speed": {"drives": 1, "turn": 1}, "acceleration": 5, "along": "values"},
            "proved along poses only",
        ),
    ],
)
def test_mistakes(study, more, message):
    with pytest.raises(ArgumentError, match=message):
        gspcli.path(study, "home", 3, **more)
