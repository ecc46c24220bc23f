"""Which real pose is home: nearest to the stated one, else the least turned, then the highest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.geometry.home_mode import home_mode
from gspcli.geometry.instance import HomePose
from gspcli.geometry.quaternions import rotation_from_vector, stable_order
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load

HEXAPOD = load(instance_files()["simmechanics-hexapod"])
LOOSE = replace(HEXAPOD, home=None)


def test_the_pose_nearest_to_the_stated_home():
    result = solve(HEXAPOD)
    R, T = result.R[result.real].real, result.T[result.real].real
    for k in range(len(R)):
        near = HomePose(list(T[k] + [0.01, 0, -0.02]), list(result.quaternions[k].real))
        found = home_mode(replace(HEXAPOD, home=near), R, T)
        assert (found.number, found.stated, found.count) == (k + 1, True, len(R))
        assert (R[k] == found.R).all()
        assert (T[k] == found.T).all()
        assert found.reason.startswith("nearest to the stated home, 0.0224 m and ")


def test_a_stated_home_in_angles_is_the_same_pose():
    given = HomePose([0, 0, 2], euler="xyz", angles=[10, -20, 30])
    turn = given.R(np.pi / 180)
    x, y, z = (
        rotation_from_vector(np.deg2rad(a) * e)
        for a, e in zip((10, -20, 30), np.eye(3), strict=True)
    )
    assert turn == pytest.approx(z @ y @ x, abs=1e-15)


def test_without_one_the_least_turned_and_then_the_highest():
    upper, lower = np.array([[0, 0, 2.0], [0, 0, -2.0]])
    turned = rotation_from_vector(np.array([0, 0, 0.1]))
    R = np.stack([turned, np.eye(3), np.eye(3)])
    found = home_mode(LOOSE, R, np.stack([upper, lower, upper]))
    assert (found.number, found.stated, found.equal) == (3, False, 2)
    found = home_mode(LOOSE, R[:2], np.stack([upper, lower]))
    assert (found.number, found.equal) == (2, 1)
    assert home_mode(LOOSE, R[:0], np.zeros((0, 3))) is None


def test_equal_is_what_differs_by_less_than_a_millionth():
    T = np.array([[0, 0, -2.0], [0, 0, 2.0]])
    for turn, number in ((0.5e-6, 2), (2e-6, 1)):
        R = np.stack([np.eye(3), rotation_from_vector(np.array([turn, 0, 0]))])
        assert home_mode(LOOSE, R, T).number == number


def test_the_mode_is_marked_in_every_form():
    result = solve(HEXAPOD)
    number = result.home.number
    assert [s.number for s in result.solutions if s.home] == [number]
    frame = result.to_frame()
    assert frame.index[frame["home"]].tolist() == [number]
    document = result.to_json()
    assert document["home"] == {
        "mode": number,
        "stated": True,
        "reason": "nearest to the stated home",
    }
    assert [s["number"] for s in document["solutions"] if s["home"]] == [number]


@pytest.mark.parametrize(
    ("quaternion", "euler"), [([0, 0, 0, 0], None), ([1, 0, 0], None), ([1, 0, 0, 0], "ZYX")]
)
def test_what_is_no_home(quaternion, euler):
    with pytest.raises(ValueError, match="quaternion"):
        HomePose([0, 0, 0], quaternion, euler=euler)


# The order of poses, against NumPy's sort of the same rounded numbers.


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
