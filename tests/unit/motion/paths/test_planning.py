"""Planned paths, checked by following them again; and proofs that there is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.errors import GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.machine import Machine
from gspcli.geometry.numbers import Number
from gspcli.motion import mode_groups
from gspcli.motion.following.tracks import departures, track_from
from gspcli.motion.paths import planner
from gspcli.motion.paths.between import limit_events
from gspcli.motion.paths.planned_paths import ValueGuide


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
