"""Poses located from approximate Study points: proved, distinct, and none where there is none."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import acb, arb, ctx

from gspcli.certification.equations.ball_system import pose_of_point
from gspcli.certification.equations.local_frames import OWN, StudyFrames
from gspcli.certification.poses.isolation import Isolation
from gspcli.certification.poses.locator import Located, Locator
from gspcli.geometry.quaternions import study_from_pose


def point(R: np.ndarray, T: np.ndarray) -> np.ndarray:
    return np.concatenate(study_from_pose(np.asarray(R, complex), np.asarray(T, complex)))


@pytest.mark.parametrize(
    "names", ["DPP DPP DPP DPP DPP DPP", "DPL DLP DPH DHP DLL DPP", "DPL DLL DLP ALL ALH AHH"]
)
def test_an_approximate_pose_becomes_a_proved_one(known, names):
    platform = known(names, 3)
    R, T = platform.floats
    start = point(R, T)
    start = start + 1e-6 * np.abs(start).max() * np.random.default_rng(1).standard_normal(8)
    [pose] = Locator(platform.instance, OWN).locate(start[None], None, (0,) * 6)
    assert pose is not None
    assert pose.real
    np.testing.assert_allclose(pose.R, R, atol=2e-15)
    np.testing.assert_allclose(pose.T, T, atol=1e-14)


def test_frames_move_points_to_those_of_the_instance(known):
    platform = known("DPP DPL DPH DLP DLL DHP", 4)
    R, T = platform.floats
    frames = StudyFrames(length=2.5, platform=(1.0, -2.0, 0.5), base=(0.25, 3.0, -1.0))
    inner = (T - np.array(frames.base) + R @ np.array(frames.platform)) / frames.length
    [pose] = Locator(platform.instance, frames).locate(point(R, inner)[None], None, (0,) * 6)
    assert pose is not None
    np.testing.assert_allclose(pose.T, T, atol=1e-13)


@pytest.mark.parametrize("digits", [8, 16, 30, 60])
def test_poses_nearer_to_each_other_than_doubles_can_tell(tangent, digits):
    instance = tangent(1 + Fraction(1, 10**digits))
    gap = (2 * 10.0**-digits) ** 0.5
    high = point(np.eye(3), [1, 0, 0])
    # f is linear in T.
    low = np.array([[[0, 0, 0, 0, *point(np.eye(3), [0, 0, 0.9 * z])[4:]]] for z in (gap, -gap)])
    poses = Locator(instance, OWN).locate(np.array([high, high]), low, (0,) * 6)
    assert [pose is not None and pose.real for pose in poses] == [True, True]
    assert not poses[0].isolation.contains(poses[1].isolation)
    np.testing.assert_allclose(
        [pose.T[2].real for pose in poses], [gap, -gap], rtol=1e-6, atol=1e-16
    )


def test_a_double_pose_is_never_located(tangent):
    start = point(np.eye(3), [1, 0, 0])
    assert Locator(tangent(Fraction(1)), OWN).locate(start[None], None, (0,) * 6) == [None]


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-22, 1e-60])
@pytest.mark.parametrize("phase", [1, -1, 1j])
def test_poses_next_to_isotropic_quaternions_keep_theirs(size, phase):
    """N is as small as can be, on the negative numbers, and of the conjugate, too."""
    with ctx.workprec(512):
        last = (acb(phase) * acb(str(size)) - 1).sqrt().mid()
        centre = (acb(1), acb(0), acb(0), last, acb(0), acb(0), acb(0), acb(0))
        isolation = Isolation(centre, 0, (0,) * 6, arb(2) ** -400, 1e-9, 512)
        pose = pose_of_point(isolation.point)
    assert pose is not None
    located = Located(isolation, pose, 1.0, real=False)
    for one in (located, located.conjugate):
        e = one.quaternion
        assert np.isfinite(e).all()
        np.testing.assert_allclose(4 * e[0] ** 2 - 1, np.trace(one.R), rtol=1e-13)
    np.testing.assert_array_equal(located.conjugate.R, located.R.conj())
