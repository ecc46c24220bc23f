"""Which of many poses are different, as far as they are known."""

from __future__ import annotations

import numpy as np

from gspcli.certification.poses.distinct import all_different, places


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
