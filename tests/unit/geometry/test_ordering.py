"""The order of poses, against NumPy's sort of the same rounded numbers."""

import numpy as np

from gspcli.geometry.ordering import stable_order


def test_poses_are_sorted_by_what_is_rounded_to_nine_decimals():
    rng = np.random.default_rng(5)
    # Few different numbers, off by less than what counts: ties of every sort.
    numbers = rng.integers(-1, 2, (400, 7)) + 1j * rng.integers(0, 2, (400, 7))
    numbers = numbers + rng.uniform(-1e-10, 1e-10, numbers.shape)
    real = rng.random(400) < 0.5
    q, T = numbers[:, :4], 250.0 * numbers[:, 4:]
    rounded = np.concatenate((q, T / 100.0), axis=1).view(float).round(9)
    keys = np.concatenate((~real[:, None], rounded[:, ::2], rounded[:, 1::2]), axis=1)
    expected = np.lexsort(keys.T[::-1])
    np.testing.assert_array_equal(stable_order(real, q, T, 250.0), expected)


def test_real_poses_come_first_and_none_is_no_order():
    q = np.array([[1, 0, 0, 0], [2, 0, 0, 0]], complex)
    T = np.zeros((2, 3), complex)
    assert stable_order(np.array([False, True]), q, T, 1.0).tolist() == [1, 0]
    assert stable_order(np.zeros(0, bool), q[:0], T[:0], 1.0).tolist() == []
