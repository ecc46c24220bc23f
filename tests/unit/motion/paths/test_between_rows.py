"""Bounds between the rows of paths hold at all samples, and come near to what they bound."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import condition_numbers
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.motion.following.tracks import track_from
from gspcli.motion.paths.between import (
    PathRows,
    can_be_bounded,
    condition_bounds,
    largest_conditions,
    least_clearances,
    worst_between,
)
from gspcli.motion.paths.ways import PoseWays, ValueWays
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.singularities.clearances import clearances, weights_of
from tests.unit.motion.paths.test_pose_ways import MACHINES, ways_of


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
