"""Telling ends apart, and finite ones from those at infinity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.continuation.endpoints import (
    ENDGAME,
    clusters,
    distances,
    find_ends,
    infinite,
    may_coincide,
    random_start,
    regular_error,
)
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.start import start_system
from gspcli.continuation.systems import System
from gspcli.continuation.tracker import CAREFUL, PathStatus, track


def random_points(count: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    points = rng.standard_normal((count, 8)) + 1j * rng.standard_normal((count, 8))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def test_a_longer_correction_is_a_larger_error():
    error = regular_error(np.array([0.0, 1e-15, 1e-10]))
    assert (np.diff(error) > 0).all()
    assert error[0] > 0


@pytest.mark.parametrize(("n", "is_infinite"), [(0.0, True), (1e-12, True), (1e-6, False)])
def test_infinite_is_zero_within_the_error(n, is_infinite):
    # e.e = n with |e| about one half.
    e = np.array([0.5, 0.5j * np.sqrt(1 - 4 * n), 0, 0])
    point = np.concatenate([e, [np.sqrt(0.5), 0, 0, 0]])
    assert infinite(point, np.array(1e-9)) == is_infinite


def test_far_away_is_not_infinite():
    """N = |e|^2 is small because e is, not because it cancels."""
    point = np.array([1e-7, 0, 0, 0, 0, 1, 0, 0], dtype=complex)
    assert not infinite(point, np.array(1e-9))


def test_distances_do_not_depend_on_the_phase_and_keep_small_angles():
    point, across = random_points(2, 1)
    across = across - point * (point.conj() @ across)
    across /= np.linalg.norm(across)
    angles = np.array([0.0, 1e-12, 1e-5, 0.5])
    turned = np.exp(0.7j) * (np.outer(np.cos(angles), point) + np.outer(np.sin(angles), across))
    np.testing.assert_allclose(distances(turned, point), np.sin(angles), rtol=1e-3, atol=1e-15)


def test_same_points_are_neighbours():
    points = random_points(5, 2)
    points[3] = points[0] * np.exp(2j)
    order, near = may_coincide(points[None], np.full((1, 5), 1e-10))
    pairs = {frozenset(order[0, i : i + 2].tolist()) for i in np.flatnonzero(near[0])}
    assert frozenset((0, 3)) in pairs


def test_clusters_are_what_is_the_same_within_its_error():
    points = random_points(6, 3)
    points[4] = points[1] * 1j
    points[5] = points[1] + 1e-9
    groups = {tuple(group) for group in clusters(points, np.full(6, 1e-12))}
    assert groups == {(0,), (1, 4), (2,), (3,), (5,)}
    groups = {tuple(group) for group in clusters(points, np.full(6, 1e-7))}
    assert groups == {(0,), (1, 4, 5), (2,), (3,)}


def test_equal_keys_are_not_enough():
    """Two points with one invariant are compared themselves."""
    key = np.exp(1j * np.arange(8) ** 2) / np.sqrt(8)
    first, second = (np.linalg.qr(np.c_[key.conj(), p])[0][:, 1] for p in random_points(2, 4))
    groups = clusters(np.array([first, second]), np.full(2, 1e-9))
    assert sorted(map(len, groups)) == [1, 1]


# The Cauchy endgame on systems whose ends are known.


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


# The account of all paths.


NOTHING = PathAccount(expected=0)


@pytest.mark.parametrize(
    "parts",
    [{"found": 39}, {"found": 41}, {"found": 41, "lost": -1}, {"found": 40, "at_infinity": 1}, {}],
)
def test_an_account_adds_up(parts):
    with pytest.raises(ValueError, match="must add up"):
        PathAccount(expected=40, **parts)


@pytest.mark.parametrize(
    ("parts", "verdict"),
    [
        ({"found": 40}, "complete"),
        ({"found": 1, "at_infinity": 20, "spurious": 19}, "complete"),
        ({"found": 39, "lost": 1}, "incomplete"),
        ({"found": 30, "on_curves": 10}, "infinite"),
        ({"found": 30, "on_curves": 9, "lost": 1}, "infinite"),
    ],
)
def test_verdict(parts, verdict):
    assert PathAccount(expected=40, **parts).verdict == verdict


def test_accounts_add():
    first = PathAccount(expected=40, found=28, at_infinity=12)
    second = PathAccount(expected=40, found=20, on_curves=10, spurious=9, lost=1)
    assert sum([first, second], NOTHING) == PathAccount(
        expected=80, found=48, at_infinity=12, on_curves=10, spurious=9, lost=1
    )
    assert second * 3 == second + second + second
    assert second * 0 == NOTHING


def test_a_sum_rests_on_counts_if_a_part_does():
    followed = PathAccount(expected=1, found=1)
    counted = PathAccount(expected=1, at_infinity=1, basis=Basis.COUNT)
    assert (followed + followed).basis is Basis.PATHS
    assert (followed + counted).basis is (counted + followed).basis is Basis.COUNT
    assert (counted * 2).basis is Basis.COUNT
