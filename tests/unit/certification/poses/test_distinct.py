"""Which of many poses are different, as far as they are known."""

from __future__ import annotations

import numpy as np
from flint import acb, arb, ctx

from gspcli.certification.equations.ball_system import PoseBall
from gspcli.certification.poses.isolation import all_different, close_pairs, places


def test_poses_are_different_only_beyond_their_deviations() -> None:
    rng = np.random.default_rng(1)
    entries = rng.normal(size=(50, 12)) + 1j * rng.normal(size=(50, 12))
    assert all_different(entries, np.full(50, 1e-6))
    near = np.concatenate((entries, entries[20:21]))
    assert not all_different(near, np.zeros(51))
    near[50, 4] += 2.5e-6
    assert all_different(near, np.full(51, 1e-6))
    assert not all_different(near, np.full(51, 1.3e-6))
    assert all_different(entries[:0], np.zeros(0))


def test_the_place_of_a_pose_is_that_of_the_first_that_it_may_be() -> None:
    entries = np.random.default_rng(2).normal(size=(6, 12)) + 0j
    entries[3], entries[5] = entries[1] + 1e-7, entries[0]
    assert places(entries, np.full(6, 1e-6), 0).tolist() == [0, 1, 2, 1, 4, 0]
    assert places(entries, np.full(6, 1e-8), 0).tolist() == [0, 1, 2, 3, 4, 0]
    # Those that are known to be different stay where they are.
    assert places(entries, np.full(6, 1e-6), 4).tolist() == [0, 1, 2, 3, 4, 0]


def test_what_is_left_out_is_no_place_for_others() -> None:
    """A chain of three: the third may be the second, which is left out, but not the first."""
    entries = np.tile(np.random.default_rng(3).normal(size=12) + 0j, (3, 1))
    entries[:, 4] += [0, 1.5e-6, 3e-6]
    assert places(entries, np.full(3, 1e-6), 0).tolist() == [0, 0, 2]


def test_poses_that_differ_in_all_entries_by_less_than_their_bounds_may_be_the_same() -> None:
    """Their linear forms differ by much more than the entries."""
    pose = np.random.default_rng(4).normal(size=12) + 1j
    pair = np.array([pose, pose + (1 + 1j) * 1.3e-6])
    assert np.abs(pair[1] - pair[0]).max() < 2e-6
    assert not all_different(pair, np.full(2, 1e-6))
    assert places(pair, np.full(2, 1e-6), 0).tolist() == [0, 0]
    assert all_different(pair, np.full(2, 0.9e-6))
    assert places(pair, np.full(2, 0.9e-6), 0).tolist() == [0, 1]


def test_the_bounds_of_both_poses_count() -> None:
    entries = np.tile(np.random.default_rng(5).normal(size=12) + 0j, (2, 1))
    entries[1, 7] += 1.5e-6
    for bounds in ([1e-6, 1e-6], [2e-6, 1e-9], [1e-9, 2e-6]):
        assert not all_different(entries, np.array(bounds))
        assert places(entries, np.array(bounds), 0).tolist() == [0, 0]


def _balls(shift: float, radius: float) -> PoseBall:
    entries = [acb(arb(k + shift, radius), arb(0, radius)) for k in range(12)]
    return PoseBall([entries[:3], entries[3:6], entries[6:9]], entries[9:])


def test_balls_with_a_common_point_are_pairs() -> None:
    with ctx.workprec(64):
        balls = [_balls(shift, 1e-6) for shift in (0, 1.9e-6, 5e-6, 6.5e-6, 1)]
        assert sorted(close_pairs(balls)) == [(0, 1), (2, 3)]
        assert sorted(close_pairs(balls[::-1])) == [(1, 2), (3, 4)]


def test_entries_beyond_the_range_of_doubles_are_not_proved_different() -> None:
    entries = np.ones((3, 12), complex)
    entries[1, 3], entries[2, 3] = np.inf, np.inf
    assert not all_different(entries, np.zeros(3))
    assert places(entries, np.zeros(3), 1).tolist()[2] == 1


def test_a_pose_without_a_bound_may_be_any() -> None:
    entries = np.random.default_rng(6).normal(size=(3, 12)) + 0j
    for bound in (np.nan, np.inf):
        bounds = np.array([1e-9, bound, 1e-9])
        assert not all_different(entries, bounds)
        found = places(entries, bounds, 0)
        assert found[1] == 0 or found[0] == 1
