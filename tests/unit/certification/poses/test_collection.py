"""Collections of proved poses: nothing twice, nothing unproved, conjugates, and near neighbours."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from gspcli.certification.equations.frames import OWN
from gspcli.certification.poses.collection import Collection
from gspcli.certification.poses.locator import Locator
from gspcli.geometry.quaternions import quaternion_from_rotation, study_from_pose

SIDES = (0,) * 6


def point(R: np.ndarray, T: np.ndarray) -> np.ndarray:
    return np.concatenate(study_from_pose(np.asarray(R, complex), np.asarray(T, complex)))


@pytest.fixture
def all_forty(dietmaier, forty) -> tuple[Collection, np.ndarray, np.ndarray]:
    R, T = (array.astype(complex) for array in forty)
    return Collection(Locator(dietmaier, OWN), SIDES), R, T


def test_doubles_prove_dietmaiers_forty_poses(all_forty):
    collection, R, T = all_forty
    proved = collection.add_doubles(R, T, quaternion_from_rotation(R))
    assert len(collection) == proved.sum() > 30
    # The others are not known well enough.
    rest = np.array([point(*pose) for pose in zip(R[~proved], T[~proved], strict=True)])
    assert collection.add(collection.locator.locate(rest, None, SIDES)) == len(rest)
    assert len(collection) == 40
    assert collection.real.all()


def test_what_is_no_pose_is_not_added(all_forty):
    collection, R, T = all_forty
    T[7] += 0.1
    proved = collection.add_doubles(R, T, quaternion_from_rotation(R))
    assert not proved[7]
    assert len(collection) == proved.sum() > 30


def test_a_pose_given_twice_counts_once(all_forty):
    collection, R, T = all_forty
    collection.add_doubles(R[:5], T[:5], quaternion_from_rotation(R[:5]))
    again = collection.locator.locate(
        np.array([point(*pose) for pose in zip(R[3:7], T[3:7], strict=True)]), None, SIDES
    )
    assert collection.add(again) == 2
    assert len(collection) == 7
    assert collection.add(again) == 0


def test_newton_that_goes_to_another_pose_makes_nothing_new(all_forty, monkeypatch):
    collection, R, T = all_forty
    collection.add_doubles(R[3:4], T[3:4], quaternion_from_rotation(R[3:4]))
    points = np.array([point(*pose) for pose in zip(R[3:5], T[3:5], strict=True)])
    same, other = collection.locator.locate(points, None, SIDES)
    monkeypatch.setattr(collection.locator, "locate_exactly", lambda *_: other)
    assert collection.add([same]) == 0
    assert len(collection) == 1


def test_equal_doubles_prove_one_pose(all_forty):
    collection, R, T = all_forty
    twice = [0, 1, 1]
    proved = collection.add_doubles(R[twice], T[twice], quaternion_from_rotation(R[twice]))
    assert proved.tolist() == [True, True, False]
    assert len(collection) == 2


def test_neighbours_that_doubles_cannot_tell_apart_are_two(tangent):
    instance = tangent(1 + Fraction(1, 10**40))
    collection = Collection(Locator(instance, OWN), SIDES)
    high = point(np.eye(3), [1, 0, 0])
    low = np.array([[[0, 0, 0, 0, *point(np.eye(3), [0, 0, z])[4:]]] for z in (1.4e-20, -1.4e-20)])
    poses = collection.locator.locate(np.array([high, high]), low, SIDES)
    assert collection.add(poses) == 2
    assert collection.add(poses) == 0
    assert np.abs(collection.T[0] - collection.T[1]).max() < 1e-15


def test_conjugates_of_complex_poses_are_poses(tangent):
    # d < 1: the sphere does not reach the line, the two poses are conjugate.
    instance = tangent(Fraction(1, 2))
    collection = Collection(Locator(instance, OWN), SIDES)
    start = point(np.eye(3), [1, 0, 0.75**0.5 * 1j])
    assert collection.add(collection.locator.locate(start[None], None, SIDES)) == 1
    assert collection.add_conjugates() == 1
    assert collection.add_conjugates() == 0
    np.testing.assert_allclose(collection.T[1], collection.T[0].conj(), rtol=0, atol=0)


def test_conjugates_that_doubles_cannot_tell_apart_are_compared_in_balls(tangent):
    instance = tangent(1 - Fraction(1, 10**40))
    for ways, new in (((1,), 1), ((1, -1), 0)):
        collection = Collection(Locator(instance, OWN), SIDES)
        high = np.array([point(np.eye(3), [1, 0, 0])] * len(ways))
        low = np.array(
            [[[0, 0, 0, 0, *point(np.eye(3), [0, 0, way * 1.4e-20j])[4:]]] for way in ways]
        )
        assert collection.add(collection.locator.locate(high, low, SIDES)) == len(ways)
        assert collection.add_conjugates() == 0
        assert collection.add_close_conjugates() == new
        assert collection.add_close_conjugates() == 0
        assert len(collection) == 2


@pytest.mark.parametrize("digits", [8, 30])
@pytest.mark.parametrize("sign", [1, -1])
def test_what_more_digits_prove_is_added_where_doubles_tell_it_from_the_rest(tangent, digits, sign):
    gap = (2 * sign * 10.0**-digits + 0j) ** 0.5
    points = np.array([point(np.eye(3), [1, 0, 0])] * 2)
    low = np.array(
        [[[0, 0, 0, 0, *point(np.eye(3), [0, 0, way])[4:] * gap]] for way in (0.9, -0.9)]
    )
    collection = Collection(Locator(tangent(1 + sign * Fraction(1, 10**digits)), OWN), SIDES)
    apart = digits == 8
    assert collection.add_with_digits(points, low).tolist() == [True, apart]
    assert len(collection) == 1 + apart
    assert collection.add_conjugates() == 0
    assert collection.add_close_conjugates() == (not apart and sign < 0)
    assert collection.add_close_conjugates() == 0
    # In balls nothing is new that was there, and what was too near is.
    again = collection.locator.locate(points, low, SIDES)
    assert collection.add(again) == (not apart and sign > 0)
    assert len(collection) == 2
    assert collection.add_with_digits(points, low).tolist() == [False, False]
    assert collection.real.tolist() == [sign > 0] * 2
