"""Proved ways of machines with motors against samples, and the judge itself."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import condition_numbers
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.paths.between import PathRows, cones_kept
from gspcli.motion.paths.planned_paths import Modes, PoseGuide
from gspcli.motion.paths.planner import PoseClass, PoseMap
from gspcli.motion.paths.ways import PoseWays, ValueWays, WayProof, fills_ranges
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.spec.reading import example
from tests.support import driven_paths
from tests.support.thick_legs import thick


@pytest.mark.parametrize("name", ["t-top 120", "mixed"])
def test_no_sample_contradicts_a_proved_way(name):
    found = driven_paths.segments(name, 25, 500)
    assert found.proved > 5
    assert found.wrong == 0


def test_ways_that_are_not_proved_are_found_wrong(monkeypatch):
    class Credulous(driven_paths.PoseWays):
        def prove(self, begin, end):
            del begin, end
            return WayProof(1, 1)

    monkeypatch.setattr(driven_paths, "PoseWays", Credulous)
    assert driven_paths.segments("reachy 90", 40, 300).wrong > 0


def test_paths_of_drives_are_followed_to_their_ends():
    assert driven_paths.paths("6-PUS", 1).proved == 1
    draw = driven_paths.Draw("6-PUS", 3)
    R, T = draw.machine.R[None], draw.machine.T[None]
    q = draw.geometry.numbers(R, T)
    rows = [np.concatenate((one, one)) for one in (R, T, q)]
    assert driven_paths.is_kept(draw, *rows)
    rows[2][1] += 1e-3
    assert not driven_paths.is_kept(draw, *rows)


# Planned paths on which legs keep a gap.


NEAR = np.eye(3), [10.0, 0, 420]


def test_a_path_keeps_a_gap_and_says_what_is_proved():
    found = gspcli.path(thick("workspace-study"), "home", NEAR, gap=15.0)
    assert found.verdict == "proved"
    assert found.gaps.min() >= 15
    assert all(part.gap >= 15 for part in found.parts)
    assert ComparedShapes(found.instance).bounds(found.R, found.T).high.min() >= 15
    row = found.rows()[0]
    assert row["gap"] == pytest.approx(23.412044, abs=1e-6)
    assert found.to_json()["parts"][0]["gap"] >= 15
    assert "gap" not in gspcli.path(thick("workspace-study"), "home", NEAR).rows()[0]


def test_a_gap_leads_a_path_another_way():
    """The straight way turns the platform so far that its legs come near to each other."""
    instance = thick("workspace-study", diameter=40)
    turn = np.radians(25)
    R = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    gaps = gspcli.motion.gaps(instance, R, [0, 0, 400]).least[0]
    found = gspcli.path(instance, "home", (R, [0, 0, 400]), gap=gaps - 0.5, time=1000)
    assert found.verdict == "proved"
    assert found.gaps.min() >= gaps - 0.5


def test_an_end_that_is_too_near_is_told():
    found = gspcli.path(thick("workspace-study"), "home", NEAR, gap=30.0)
    assert found.verdict == "impossible"
    assert "the gap between legs 1 and 6 is 23.412 mm, at least 30 is asked for" in found.reason


def test_what_cannot_be_asked_for():
    with pytest.raises(ArgumentError, match="states no shapes"):
        gspcli.path(example("workspace-study"), "home", 3, gap=1.0)
    with pytest.raises(ArgumentError, match="finite"):
        gspcli.path(thick("workspace-study"), "home", 3, gap=np.inf)
    with pytest.raises(ArgumentError, match="states no shapes"):
        gspcli.path(example("t-top-head"), "home", 2, gap=0.0)


# Straight ways in position and angles: what is proved is true at all samples.


#: Machines of all kinds of constraint, and with ranges and cones.
MACHINES = (
    "platform-6-6",
    "workspace-study",
    "workspace-study-cones",
    "surfaces-ccc",
    "surfaces-ppp",
    "sdss-primary",
    "figure-2",
    "fixture-3-2-1",
    "example-6.8",
)


@cache
def ways_of(name: str, *, limits: bool) -> tuple[PoseWays, np.ndarray]:
    """Return straight ways and the parameters of the modes."""
    instance = gspcli.example(name)
    ways = PoseWays(instance, limits=limits)
    solved = gspcli.solve(instance)
    real = solved.real
    return ways, ways.parameters(solved.R[real].real, solved.T[real].real)


def determinants(ways: PoseWays, parameters: np.ndarray) -> np.ndarray:
    R, T = ways.poses(parameters[:1])
    found = PoseMap(PoseGuide(ways, 1.0), R, T, lambda *_: PoseClass(()), seed=0)
    return found.determinants(parameters)


@pytest.mark.parametrize("name", MACHINES)
def test_a_regular_way_keeps_the_sign_of_the_determinant(name):
    ways, modes = ways_of(name, limits=False)
    draw = np.random.default_rng(1)
    parts = np.linspace(0, 1, 200)[:, None]
    proved, senses = 0, set()
    for k in range(60):
        begin = modes[k % len(modes)]
        width = 10.0 ** -draw.integers(0, 3)
        end = begin + draw.normal(size=6) * ways.sizes * width
        found = ways.prove(begin, end)
        signs = np.sign(determinants(ways, begin + (end - begin) * parts))
        if found.sign:
            proved += 1
            assert (signs == signs[0]).all()
            senses.add(found.sign * signs[0])
            assert ways.prove(end, begin).sign == found.sign
    assert proved > 10
    # Screws of angles have either sense, the same one at all poses.
    assert len(senses) == 1


@pytest.mark.parametrize("name", [name for name in MACHINES if name != "figure-2"])
def test_a_way_whose_determinant_changes_its_sign_is_not_proved(name):
    ways, modes = ways_of(name, limits=False)
    signs = np.sign(determinants(ways, modes))
    tried = 0
    for i in range(min(len(modes), 12)):
        for j in range(i):
            if signs[i] != signs[j]:
                tried += 1
                found = ways.prove(modes[i], ways.nearest(modes[i], modes[j]))
                assert found.sign == 0
                assert found.reason
    assert tried


@pytest.mark.parametrize("name", ["workspace-study", "workspace-study-cones"])
def test_a_way_within_the_limits_keeps_them_at_samples(name):
    ways, modes = ways_of(name, limits=True)
    instance = ways.instance
    draw = np.random.default_rng(2)
    parts = np.linspace(0, 1, 100)[:, None]
    proved = left = 0
    for _ in range(150):
        begin = modes[-1] + draw.normal(size=6) * ways.sizes * 0.02
        end = begin + draw.normal(size=6) * ways.sizes * 0.15
        R, T = ways.poses(begin + (end - begin) * parts)
        kept = Machine.of(instance).keeps(R, T).all()
        found = ways.prove(begin, end)
        if found.sign:
            proved += 1
            assert kept
        left += not kept
    assert proved > 20
    assert left > 20


def test_a_way_that_leaves_a_range_between_its_ends_is_refused():
    ways, modes = ways_of("workspace-study", limits=True)
    # Half a turn about z and back again by the other way: both ends are home, and no leg is then.
    found = ways.prove(modes[-1], modes[-1] + [0, 0, 0, 0, 0, 2 * np.pi])
    assert found.sign == 0


def test_angles_are_continued_by_whole_turns_and_over_the_pole():
    ways, _ = ways_of("platform-6-6", limits=False)
    draw = np.random.default_rng(3)
    here = draw.uniform(-7, 7, size=(50, 6))
    R, T = ways.poses(here + 0.1 * draw.normal(size=(50, 6)))
    found = ways.nearest(here, ways.parameters(R, T))
    assert np.abs(found - here).max() < 1
    again = ways.poses(found)
    assert np.abs(again[0] - R).max() < 1e-9
    assert np.abs(again[1] - T).max() < 1e-9


def test_a_singular_pose_is_not_proved():
    instance = gspcli.example("singular-pose")
    solved = gspcli.solve(instance)
    real = solved.real
    R, T = solved.R[real].real, solved.T[real].real
    singular = ~np.isfinite(condition_numbers(Arrangement.of(instance), R, T))
    assert singular.any()
    ways = PoseWays(instance, limits=False)
    at = ways.parameters(R, T)[singular][0]
    assert ways.at(at).sign == 0
    for size in (1e-1, 1e-5, 1e-9):
        away = np.full(6, size) * ways.sizes
        assert ways.prove(at - away, at + away).sign == 0


# Straight ways of values, and modes that fill their ranges.


def modes_of(name):
    instance = gspcli.example(name)
    modes = Modes(instance).all()
    return instance, modes, ValueWays(instance, np.sign(modes[0].values))


@pytest.fixture(scope="module")
def study():
    return modes_of("workspace-study")


def test_ranges_are_kept_by_all_values(study):
    _, modes, ways = study
    row = modes[0].values
    assert ways.ranged
    assert ways.kept(row)
    for k in range(6):
        for out in (319.9, 520.1):
            other = row.copy()
            other[k] = out
            assert not ways.kept(other)
            assert ways.kept(np.stack((row, other))).tolist() == [True, False]


def test_a_mode_arrives_only_if_it_is_followed_to_the_end(study):
    """On the way to random values in the ranges some modes end in folds."""
    instance, modes, ways = study
    points = ways.points(np.stack([m.R for m in modes]), np.stack([m.T for m in modes]))
    goals = np.random.default_rng(8).uniform(380, 460, size=(20, 6))
    lines = np.stack((np.tile(modes[0].values, (20, 1)), goals), axis=1)
    which = np.repeat(np.arange(20), len(modes))
    found = ways.follow(lines, which, np.tile(points, (20, 1)))
    assert 20 < found.there.sum() < len(which) - 20
    R, T = ways.poses(found.points[found.there, -1])
    assert np.abs(values_at(instance, R, T) - goals[which[found.there]]).max() < 1e-6
    outside = np.stack((modes[0].values, np.full(6, 530.0)))[None]
    assert not ways.follow(outside, np.zeros(1, np.int64), points[-1:]).there[0]
    nothing = ways.follow(lines, np.zeros(0, np.int64), points[:0])
    assert nothing.points.shape == (0, 2, 8)


def test_both_signs_of_a_study_point_are_one_pose(study):
    _, modes, ways = study
    points = ways.points(np.stack([m.R for m in modes]), np.stack([m.T for m in modes]))
    assert ways.same(points, -points).all()
    assert not ways.same(points[:-1], points[1:]).any()


def test_cones_are_kept_on_the_whole_way():
    instance, modes, ways = modes_of("workspace-study-cones")
    home = modes[7]
    points = ways.points(home.R[None], home.T[None])
    draw = np.random.default_rng(6)
    kept = left = 0
    for _ in range(12):
        goal = np.clip(home.values + draw.uniform(-45, 45, 6), ways.low, ways.high)
        rows = home.values + (goal - home.values) * np.linspace(0, 1, 60)[:, None]
        found = ways.follow(rows[None], np.zeros(1, np.int64), points)
        if not found.there[0]:
            continue
        R, T = ways.poses(found.points[0])
        inside = not Machine.of(instance).out_of_cones(R, T).any()
        ends = PathRows.of_values(ways, rows[[0, -1]], R[[0, -1]], T[[0, -1]])
        proved = cones_kept(ends)
        kept, left = kept + proved, left + (not inside)
        assert inside or not proved
    assert kept
    assert left


@pytest.mark.parametrize(
    ("name", "mode"), [("rubin-m2", 2), ("rubin-camera", 7), ("sdss-primary", 1)]
)
def test_a_mode_that_fills_its_ranges_is_at_all_their_values(name, mode):
    _, modes, ways = modes_of(name)
    end = modes[mode - 1]
    point = ways.points(end.R[None], end.T[None])
    assert fills_ranges(ways, end.values, point[0])
    draw = np.random.default_rng(7)
    goals = ways.low + (ways.high - ways.low) * draw.integers(0, 2, size=(40, 6))
    lines = np.stack((np.tile(end.values, (40, 1)), goals), axis=1)
    found = ways.follow(lines, np.arange(40), np.tile(point, (40, 1)))
    assert found.there.all()


@pytest.mark.parametrize("name", ["workspace-study", "workspace-study-cones"])
def test_a_mode_with_a_fold_in_its_ranges_does_not_fill_them(name):
    _, modes, ways = modes_of(name)
    for end in modes:
        point = ways.points(end.R[None], end.T[None])[0]
        assert not fills_ranges(ways, end.values, point)
