"""The order of poses, against NumPy's sort of the same rounded numbers."""

import numpy as np

from gspcli.geometry.pose_order import stable_order


def test_poses_are_sorted_by_what_is_rounded_to_nine_decimals_then_by_the_rest():
    rng = np.random.default_rng(5)
    # Few different numbers, off by less than what counts: ties of every sort.
    numbers = rng.integers(-1, 2, (400, 7)) + 1j * rng.integers(0, 2, (400, 7))
    numbers = numbers + rng.uniform(-1e-10, 1e-10, numbers.shape)
    real = rng.random(400) < 0.5
    q, T = numbers[:, :4], 250.0 * numbers[:, 4:]
    rounded = np.concatenate((q, T / 100.0), axis=1).view(float).round(9)
    exact = np.concatenate((q, T), axis=1).view(float)
    parts = ~real[:, None], rounded[:, ::2], rounded[:, 1::2], exact[:, ::2], exact[:, 1::2]
    expected = np.lexsort(np.concatenate(parts, axis=1).T[::-1])
    np.testing.assert_array_equal(stable_order(real, q, T, 250.0), expected)


def test_the_order_in_which_poses_were_found_does_not_matter():
    rng = np.random.default_rng(6)
    q = np.tile([0.6, 0.8, 0, 0], (20, 1)) + 1e-13j * rng.integers(-2, 3, (20, 4))
    T, real = np.ones((20, 3), complex), np.zeros(20, bool)
    shuffled = rng.permutation(20)
    first, second = (q[k][stable_order(real, q[k], T, 1.0)] for k in (np.arange(20), shuffled))
    np.testing.assert_array_equal(first, second)


def test_real_poses_come_first_and_none_is_no_order():
    q = np.array([[1, 0, 0, 0], [2, 0, 0, 0]], complex)
    T = np.zeros((2, 3), complex)
    assert stable_order(np.array([False, True]), q, T, 1.0).tolist() == [1, 0]
    assert stable_order(np.zeros(0, bool), q[:0], T[:0], 1.0).tolist() == []
