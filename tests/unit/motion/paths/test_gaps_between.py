"""Gaps between the rows of proved ways: no sample is below what is proved."""

from itertools import pairwise

import numpy as np
import pytest

from gspcli.geometry.expressed_instances import expressed_instance
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.home_mode import home_mode
from gspcli.geometry.readings import without_corrections
from gspcli.motion import measure, track
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.paths.between import PathRows, least_gaps, pose_track, worst_between
from gspcli.motion.paths.ways import PoseWays
from gspcli.solver import solve
from tests.support.thick_legs import MACHINES, poses_near, thick


def home_of(instance):
    found = solve(instance)
    R, T = found.R[found.real].real, found.T[found.real].real
    home = home_mode(instance, R, T)
    return home.R, home.T


def pose_rows(name, near=None, rows=6, seed=1):
    """Return rows of straight ways of poses, about home."""
    instance = without_corrections(thick(name, near))
    R, T = poses_near(*home_of(instance), rows, 0.1 * MACHINES[name][1], 0.3, seed)
    ways = PoseWays(instance, limits=False)
    parameters = ways.continued(R, T)
    return PathRows.of_poses(ways, R, T, parameters)


@pytest.mark.parametrize("near", [None, 1.0])
@pytest.mark.parametrize("name", MACHINES)
def test_no_sample_of_a_way_of_poses_is_below_what_is_proved(name, near):
    rows = pose_rows(name, None if near is None else near * MACHINES[name][0])
    compared = ComparedShapes(rows.instance)
    parts = np.linspace(0, 1, 400)[:, None]
    sampled = []
    for k in range(len(rows.T) - 1):
        way = rows.numbers[k] + (rows.numbers[k + 1] - rows.numbers[k]) * parts
        sampled.append(compared.bounds(*rows.ways.poses(way)).high.min())
    least = np.array(sampled)
    size = MACHINES[name][1]
    for wanted in (least.min() - 0.05 * size, least.min() - 1e-3 * size, np.sort(least)[2]):
        _, proved = least_gaps(rows, wanted)
        assert (proved <= least + 1e-9 * size).all()
        # What is well above is proved.
        assert (proved >= wanted)[least > wanted + 1e-4 * size].all()
        assert not (proved >= wanted)[least < wanted - 1e-9 * size].any()


@pytest.mark.parametrize("name", ["workspace-study"])
def test_no_sample_of_a_way_of_values_is_below_what_is_proved(name):
    instance = thick(name)
    R, T = poses_near(*home_of(instance), 4, 0.05 * MACHINES[name][1], 0.1, 2)
    values = measure(instance, R, T)
    coarse = track(instance, values, near=(R[0], T[0]))
    fine = track(
        instance,
        np.stack([np.interp(np.linspace(0, 3, 601), range(4), one) for one in values.T], axis=1),
        near=(R[0], T[0]),
    )
    least = ComparedShapes(instance).bounds(fine.R[0], fine.T[0]).high.min()
    size = MACHINES[name][1]
    assert worst_between(coarse, "gap", least - 1e-3 * size) is None
    found = worst_between(coarse, "gap", least + 1e-6 * size)
    assert found is not None
    assert found.bound <= least + 1e-9 * size


def test_a_gap_that_is_too_small_between_two_rows_only_is_seen():
    """Both rows are far from it, and the legs come near each other in the middle."""
    instance = thick("workspace-study")
    turn = np.radians(35)
    R = np.stack([turned(-turn), turned(turn)])
    T = np.array([[0, 0, 330.0]] * 2)
    done = pose_track(instance, instance, PoseFrame(), np.arange(2.0), R, T, sequence="ZYX", mode=1)
    compared = ComparedShapes(instance)
    ends = compared.bounds(R, T).high.min(axis=1)
    middle = compared.bounds(turned(0.0)[None], T[:1]).high.min()
    worse, better = sorted((middle, ends.min()))
    if middle < ends.min():
        found = worst_between(done.track, "gap", (worse + better) / 2, done.ways)
        assert found is not None
        assert found.bound <= middle
    assert worst_between(done.track, "gap", worse - 2.0, done.ways) is None


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def test_bounds_of_ways_of_poses_are_about_the_poses_of_the_file():
    """Poses of a pivot are expressed in a frame of their own."""
    given, pivot = thick("workspace-study"), (0, 0, -200)
    frame, expressed = PoseFrame.of(given, pivot=pivot), expressed_instance(given, pivot=pivot)
    R, T = poses_near(np.eye(3), np.array([0.0, 0, 400]), 3, 20, 0.1, 1)
    done = pose_track(given, expressed, frame, np.arange(3.0), R, T, sequence="ZYX", mode=1)
    own = PoseWays(given, limits=False)
    rows = PathRows.of_poses(own, R, T, own.continued(R, T))
    there = PathRows.of_poses(
        done.ways, *frame.from_platform(R, T), done.ways.continued(*frame.from_platform(R, T))
    )
    assert there.conditions() == pytest.approx(rows.conditions(), rel=1e-6)
    worst = rows.conditions().max()
    assert worst_between(done.track, "condition", worst * 1.1, done.ways, frame) is None
    assert least_gaps(there, 0.0)[0] == pytest.approx(least_gaps(rows, 0.0)[0], abs=1e-8)


def test_weaker_bounds_are_noticed(monkeypatch):
    """Without what gaps can change by, too much would be proved of some way."""
    rows = pose_rows("apo-tertiary", rows=20)
    compared = ComparedShapes(rows.instance)
    parts = np.linspace(0, 1, 400)[:, None]
    sampled = []
    for first, last in pairwise(rows.numbers):
        sampled.append(compared.bounds(*rows.ways.poses(first + (last - first) * parts)).high.min())
    least = np.array(sampled)
    assert (least_gaps(rows, -1e9)[1] <= least).all()
    monkeypatch.setattr(
        ComparedShapes, "moves", lambda self, shifts, *_: np.zeros((len(shifts), 1))
    )
    assert (least_gaps(rows, -1e9)[1] > least + 1e-3).any()
