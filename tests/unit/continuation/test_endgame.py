"""The Cauchy endgame on systems whose ends are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.continuation.endgame import ENDGAME, find_ends
from gspcli.continuation.endpoints import random_start
from gspcli.continuation.ends import clusters, infinite
from gspcli.continuation.start import start_system
from gspcli.continuation.systems import System
from gspcli.continuation.tracker import PathStatus, track
from gspcli.continuation.tracker_options import CAREFUL


@pytest.fixture(scope="module")
def double(build):
    """Six legs at a pose where all meet a line, the way there, and the points in front of it."""
    rng = np.random.default_rng(1)
    r, t = build.rotation(rng), rng.standard_normal(3)
    y = rng.standard_normal((6, 3))
    point, direction = rng.standard_normal((2, 3))
    ends = y @ r.T + t
    on_line = point + rng.standard_normal((6, 1)) * direction
    given = build.legs_at(y, ends + (1.5 + rng.random((6, 1))) * (on_line - ends), r, t)
    target = System(given.structure, given.coefficients.balanced()[0])
    start = start_system(target.structure)
    origin = random_start(start, 2, 0)
    near = origin.towards(target, 1 - CAREFUL.waypoint)
    results = track(origin, near, start.points, options=CAREFUL)
    assert (results.status == PathStatus.REGULAR).all()
    return origin, target, results.points[0]


def test_two_paths_around_a_double_solution_are_one_cycle(double):
    origin, target, points = double
    ends = find_ends(origin, target, points, CAREFUL.waypoint)
    assert sorted(ends.winding.tolist()) == [1] * 38 + [2] * 2
    assert (ends.error < ENDGAME.accuracy).all()
    assert target.residuals(ends.points).max() < ENDGAME.residual
    pair = np.flatnonzero(ends.winding == 2)
    groups = clusters(ends.points, np.full(40, 1e-7))
    assert sorted(map(len, groups)) == [1] * 38 + [2]
    assert any(sorted(group) == pair.tolist() for group in groups)
    assert not infinite(ends.points, np.full(40, 1e-9)).any()


def test_simple_ends_are_where_the_tracker_arrives(double):
    origin, target, points = double
    ends = find_ends(origin, target, points[:8], CAREFUL.waypoint)
    near = origin.towards(target, 1 - CAREFUL.waypoint)
    arrived = track(near, target, points[:8], options=CAREFUL)
    for k in np.flatnonzero(ends.winding == 1):
        assert arrived.status[0, k] == PathStatus.REGULAR
        assert abs(np.vdot(ends.points[k], arrived.points[0, k])) > 1 - 1e-14


def test_what_does_not_return_stays_unknown(double):
    origin, target, points = double
    once = replace(ENDGAME, max_winding=1, rounds=2)
    ends = find_ends(origin, target, points, CAREFUL.waypoint, options=once)
    unknown = ends.winding == 0
    assert unknown.sum() == 2
    assert np.isinf(ends.error[unknown]).all()
    assert np.isnan(ends.points[unknown]).all()


def test_unknown_points_have_unknown_ends(double):
    origin, target, points = double
    ends = find_ends(origin, target, np.full_like(points[:2], np.nan), CAREFUL.waypoint)
    assert (ends.winding == 0).all()
    assert np.isinf(ends.error).all()


def test_circles_shrink_until_no_other_branch_point_is_inside(double):
    """From half the way other branch points are in the circle: the first mean is no solution."""
    origin, target, _ = double
    radius = 0.5
    start = start_system(target.structure)
    half = track(origin, origin.towards(target, 1 - radius), start.points, options=CAREFUL)
    first = find_ends(origin, target, half.points[0], radius, options=replace(ENDGAME, rounds=1))
    assert (first.error > ENDGAME.accuracy).any()
    ends = find_ends(origin, target, half.points[0], radius)
    assert sorted(ends.winding.tolist()) == [1] * 38 + [2] * 2
    assert target.residuals(ends.points).max() < ENDGAME.residual
