"""Straight ways of values, and modes that fill their ranges."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.geometry.machine import Machine
from gspcli.motion.paths.between import PathRows, cones_kept
from gspcli.motion.paths.planned_paths import Modes
from gspcli.motion.paths.ways import ValueWays, fills_ranges
from gspcli.motion.poses.inverse_kinematics import values_at


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
