"""Proofs with 86 digits against those in balls: poses side by side, and what is none."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import ctx

from gspcli.certification.equations import study
from gspcli.certification.equations.frames import OWN, Frames
from gspcli.certification.poses.digit_proofs import DigitProofs
from gspcli.certification.poses.locator import Located, Locator
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import study_from_pose

SIDES = (0,) * 6


def points_of(R: np.ndarray, T: np.ndarray) -> np.ndarray:
    return np.concatenate(study_from_pose(R.astype(complex), T.astype(complex)), axis=-1)


@pytest.fixture
def forty_points(dietmaier, forty) -> tuple[Locator, np.ndarray]:
    return Locator(dietmaier, OWN), points_of(*map(np.asarray, forty))


def test_poses_agree_with_those_in_balls(forty_points):
    locator, points = forty_points
    proofs = DigitProofs.of(locator, SIDES)
    found = proofs.prove(points)
    assert found.proved.all()
    assert found.real.all()
    for k, pose in enumerate(locator.locate(points, None, SIDES)):
        assert isinstance(pose, Located)
        np.testing.assert_allclose(found.R[k], pose.R, rtol=0, atol=4e-16)
        np.testing.assert_allclose(found.T[k], pose.T, rtol=0, atol=4e-16 * np.abs(pose.T).max())
        sign = np.sign((found.quaternions[k] @ pose.quaternion).real)
        np.testing.assert_allclose(sign * found.quaternions[k], pose.quaternion, atol=1e-15)


def test_points_of_other_frames_and_norms_are_the_same_poses(dietmaier, forty_points):
    _, points = forty_points
    there = Frames(length=4.0, platform=(1.0, -2.0, 0.5), base=(0.25, 3.0, -1.0))
    e, f = points[:, :4], points[:, 4:]
    # The inverse of what the frames mean: 4 f' + (base e - e platform) / 2 = f.
    base, platform = ((0, *x) for x in (there.base, there.platform))
    ahead = np.array([study.product(base, x) for x in e])
    behind = np.array([study.product(x, platform) for x in e])
    inner = np.concatenate((e, (f - (ahead - behind) / 2) / there.length), axis=1) * (3 - 2j)
    found = DigitProofs.of(Locator(dietmaier, there), SIDES).prove(inner)
    same = DigitProofs.of(Locator(dietmaier, OWN), SIDES).prove(points)
    assert found.proved.all()
    np.testing.assert_allclose(found.T, same.T, atol=1e-15 * np.abs(same.T).max())
    np.testing.assert_allclose(found.R, same.R, atol=4e-16)


def test_what_is_no_pose_is_not_proved(forty_points):
    """Only what Newton's method leads to a solution is, and then it is that solution."""
    locator, points = forty_points
    rng = np.random.default_rng(3)
    wrong = points + rng.normal(size=points.shape) * 0.3 * np.abs(points).max(axis=1)[:, None]
    wrong[0] = np.nan
    wrong[1] = 0
    wrong[2] = 1e300
    found = DigitProofs.of(locator, SIDES).prove(wrong)
    assert not found.proved[:3].any()
    assert not found.proved.all()
    for k in np.flatnonzero(found.proved):
        again = locator.locate(points_of(found.R[k], found.T[k])[None], None, SIDES)[0]
        assert isinstance(again, Located)
        np.testing.assert_allclose(found.R[k], again.R, atol=1e-12 * np.abs(again.R).max())


def test_equations_that_are_off_prove_nothing(forty_points):
    """With coefficients known to a few digits only, and with those of another platform."""
    locator, points = forty_points
    proofs = DigitProofs.of(locator, SIDES)
    proofs._error = 1e-2
    assert not proofs.prove(points).proved.any()
    # One more bit in the place of 2^-8 of N's coefficient in one equation moves all poses.
    exact = DigitProofs.of(locator, SIDES)
    before = exact.prove(points)
    exact._numbers[3, study.NORM, 4] += np.uint64(1 << 24)
    after = exact.prove(points)
    moved = np.abs(after.R - before.R).max(axis=(1, 2))
    assert (moved[after.proved] > 1e-6).all()


@pytest.mark.parametrize("digits", [8, 16, 30])
@pytest.mark.parametrize("sign", [1, -1])
def test_poses_side_by_side_are_told_apart(tangent, digits, sign):
    """Real ones if the leg is longer than where both are one, else conjugates of each other."""
    locator = Locator(tangent(1 + sign * Fraction(1, 10**digits)), OWN)
    gap = (2 * sign * 10.0**-digits + 0j) ** 0.5
    high = points_of(np.eye(3)[None], np.array([[1, 0, 0]]))
    away = points_of(np.eye(3)[None], np.array([[0, 0, 0.9]]))[0, 4:] * gap
    low = np.array([[[0, 0, 0, 0, *way * away]] for way in (1, -1)])
    found = DigitProofs.of(locator, SIDES).prove(high.repeat(2, axis=0), low)
    assert found.proved.all()
    assert (found.real == (sign > 0)).all()
    np.testing.assert_allclose(found.T[:, 2], [gap, -gap], rtol=1e-6, atol=1e-16)


def test_a_double_pose_is_never_proved(tangent):
    point = points_of(np.eye(3)[None], np.array([[1, 0, 0]]))
    assert not DigitProofs.of(Locator(tangent(Fraction(1)), OWN), SIDES).prove(point).proved.any()


def test_lines_at_a_distance_are_left_to_balls(known):
    locator = Locator(known("DPL DLP DPP DPP DPP DPP", 3).instance, OWN)
    assert DigitProofs.of(locator, SIDES) is None


def test_lines_that_meet_are_left_to_balls(known):
    """Their one quadric vanishes where they are parallel, too, however far apart they are."""
    instance = known("DLL DPP DPP DPP DPP DPP", 3).instance
    first, *others = instance.constraints
    meeting = Constraint(first.kind, first.platform, first.base, Number.of(0))
    locator = Locator(Instance((meeting, *others), instance.units), OWN)
    with ctx.workprec(64):
        assert not locator.system(64).equations[0][0].squares
    assert DigitProofs.of(locator, SIDES) is None
