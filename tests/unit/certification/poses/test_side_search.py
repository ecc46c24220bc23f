"""Proved poses are kept once, none unproved; conjugates, and near neighbours."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from gspcli.certification.equations.local_frames import OWN
from gspcli.certification.poses.locator import Locator
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.certification.poses.pose_arrays import PoseProofs
from gspcli.geometry.quaternions import study_from_pose
from gspcli.solver.problem import Problem
from gspcli.solver.side_search import SideSearch

SIDES = (0,) * 6


def searched(instance) -> SideSearch:
    """Return a search whose locator takes points in the frames of the instance."""
    side = SideSearch(Problem(instance), 0)
    side.locator = Locator(instance, OWN)
    return side


def point(R: np.ndarray, T: np.ndarray) -> np.ndarray:
    return np.concatenate(study_from_pose(np.asarray(R, complex), np.asarray(T, complex)))


@pytest.fixture
def all_forty(dietmaier, forty) -> tuple[SideSearch, np.ndarray]:
    R, T = forty
    points = np.array([point(*pose) for pose in zip(R, T, strict=True)])
    return searched(dietmaier), points


def proved(collection: SideSearch, points: np.ndarray) -> PoseProofs:
    """Return what the kernel proves near points in lengths of the instance."""
    proofs = ValueProofs(collection.locator.instance, None)
    found, _ = proofs.decide(np.ones((1, 6)), points[None, None], OWN)
    known = found[found.certified & found.rounded]
    assert len(known.R)
    return known


def same_poses(collection: SideSearch, others: PoseProofs) -> None:
    for name in ("R", "T", "quaternions", "real"):
        np.testing.assert_array_equal(getattr(collection.poses, name), getattr(others, name))


def test_the_kernel_proves_dietmaiers_forty_poses(all_forty):
    collection, points = all_forty
    found = proved(collection, points)
    assert collection.add_proved(found).tolist() == list(range(40))
    assert len(collection) == 40
    assert collection.poses.real.all()
    same_poses(collection, found)
    # What balls locate is there already.
    assert collection.add_located(collection.locator.locate(points, None, SIDES)) == 0
    assert len(collection) == 40


def test_a_pose_given_twice_counts_once(all_forty):
    collection, points = all_forty
    assert collection.add_proved(proved(collection, points[:5])).tolist() == [0, 1, 2, 3, 4]
    again = proved(collection, points[3:7])
    assert collection.add_proved(again).tolist() == [3, 4, 5, 6]
    located = collection.locator.locate(points[5:9], None, SIDES)
    assert collection.add_located(located) == 2
    assert collection.add_located(located) == 0
    assert len(collection) == 9


def test_what_balls_locate_are_the_same_numbers(all_forty):
    collection, points = all_forty
    assert collection.add_located(collection.locator.locate(points, None, SIDES)) == 40
    found = proved(collection, points)
    same_poses(collection, found)
    assert collection.add_proved(found).tolist() == list(range(40))


def test_a_pose_twice_in_one_call_counts_once(all_forty):
    collection, points = all_forty
    found = proved(collection, points[[0, 1, 1]])
    assert collection.add_proved(found).tolist() == [0, 1, 1]
    assert len(collection) == 2


def test_the_place_of_a_pose_is_told_up_to_its_bound(all_forty):
    collection, points = all_forty
    found = proved(collection, points)
    collection.add_proved(found[:10])
    for k in range(10):
        assert collection.place_near(found.R[k], found.T[k] + 1e-9, 1e-8) == k
    assert collection.place_near(found.R[20], found.T[20], 1e-8) == -1
    # If two are possible, none is named.
    assert collection.place_near(found.R[0], found.T[0], 1e3) == -1


def test_newton_that_goes_to_another_pose_makes_nothing_new(all_forty, monkeypatch):
    collection, points = all_forty
    collection.add_proved(proved(collection, points[3:4]))
    same, other = collection.locator.locate(points[3:5], None, SIDES)
    monkeypatch.setattr(collection.locator, "locate_exactly", lambda *_: other)
    assert collection.add_located([same]) == 0
    assert len(collection) == 1


def test_neighbours_that_doubles_cannot_tell_apart_are_two(tangent):
    instance = tangent(1 + Fraction(1, 10**40))
    collection = searched(instance)
    high = point(np.eye(3), [1, 0, 0])
    low = np.array([[[0, 0, 0, 0, *point(np.eye(3), [0, 0, z])[4:]]] for z in (1.4e-20, -1.4e-20)])
    poses = collection.locator.locate(np.array([high, high]), low, SIDES)
    assert collection.add_located(poses) == 2
    assert collection.add_located(poses) == 0
    assert np.abs(collection.poses.T[0] - collection.poses.T[1]).max() < 1e-15


def test_conjugates_of_complex_poses_are_poses(tangent):
    # d < 1: the sphere does not reach the line, the two poses are conjugate.
    instance = tangent(Fraction(1, 2))
    collection = searched(instance)
    start = point(np.eye(3), [1, 0, 0.75**0.5 * 1j])
    assert collection.add_located(collection.locator.locate(start[None], None, SIDES)) == 1
    assert collection.add_conjugates() == 1
    assert collection.add_conjugates() == 0
    np.testing.assert_allclose(collection.poses.T[1], collection.poses.T[0].conj(), rtol=0, atol=0)


def test_conjugates_that_doubles_cannot_tell_apart_are_compared_in_balls(tangent):
    instance = tangent(1 - Fraction(1, 10**40))
    for ways, new in (((1,), 1), ((1, -1), 0)):
        collection = searched(instance)
        high = np.array([point(np.eye(3), [1, 0, 0])] * len(ways))
        low = np.array(
            [[[0, 0, 0, 0, *point(np.eye(3), [0, 0, way * 1.4e-20j])[4:]]] for way in ways]
        )
        assert collection.add_located(collection.locator.locate(high, low, SIDES)) == len(ways)
        assert collection.add_conjugates() == 0
        assert collection.add_close_conjugates() == new
        assert collection.add_close_conjugates() == 0
        assert len(collection) == 2


@pytest.mark.parametrize("digits", [8, 30])
@pytest.mark.parametrize("sign", [1, -1])
def test_what_is_known_only_up_to_its_neighbour_is_compared_in_balls(tangent, digits, sign):
    """Bounds of proved poses overlap where doubles do not tell them apart."""
    gap = (2 * sign * 10.0**-digits + 0j) ** 0.5
    points = np.array([point(np.eye(3), [1, 0, 0])] * 2)
    low = np.array(
        [[[0, 0, 0, 0, *point(np.eye(3), [0, 0, way])[4:] * gap]] for way in (0.9, -0.9)]
    )
    collection = searched(tangent(1 + sign * Fraction(1, 10**digits)))
    one, other = collection.locator.locate(points, low, SIDES)
    yes = np.ones(1, bool)
    # As bad as a bound may be: the other pose is within it.
    given = PoseProofs(
        quaternions=one.quaternion[None],
        R=one.R[None],
        T=one.T[None],
        real=np.array([one.real]),
        certified=yes,
        multiplicity=yes.astype(int),
        rounded=yes,
        deviation=np.array([1e-3]),
    )
    assert collection.add_proved(given).tolist() == [0]
    assert collection.add_located([one]) == 0
    assert collection.add_located([other]) == 1
    assert collection.add_located([one, other]) == 0
    assert collection.poses.real.tolist() == [sign > 0] * 2


def test_a_known_pose_that_balls_do_not_find_may_be_any_near_one(all_forty, monkeypatch):
    """What may be a pose that is known, and is not proved to be another one, is not added."""
    collection, points = all_forty
    found = replace(proved(collection, points[3:4]), deviation=np.array([1e-6]))
    collection.add_proved(replace(found, T=found.T + 1e-7))
    located = collection.locator.locate(points[3:4], None, SIDES)
    monkeypatch.setattr(collection.locator, "near", lambda *_: None)
    assert collection.add_located(located) == 0
    assert len(collection) == 1


def test_a_pose_that_balls_find_elsewhere_is_not_the_one_that_is_known(all_forty):
    """A pose of doubles is proved within its bound: what is found farther away is another one."""
    collection, points = all_forty
    given = replace(proved(collection, points[3:4]), deviation=np.array([1e-6]))
    for gap, found in ((0.9e-6, True), (1.2e-6, False)):
        known = searched(collection.locator.instance)
        known.add_proved(replace(given, T=given.T + gap * collection.locator.scale))
        assert (known._exactly(0) is not None) is found


def test_the_bounds_of_both_count_for_the_place(all_forty):
    collection, points = all_forty
    found = replace(proved(collection, points[3:4]), deviation=np.array([1e-6]))
    collection.add_proved(found)
    R, T = found.R, found.T
    scale = collection.locator.scale
    assert collection.place_near(R[0], T[0] + 0.9e-6 * scale, 1e-9) == 0
    assert collection.place_near(R[0], T[0] + 0.9e-6 * scale, 0.0) == 0
    assert collection.place_near(R[0], T[0] + 3e-6 * scale, 0.0) == -1
