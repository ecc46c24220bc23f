"""Expressed poses: their laws, and that a platform in expressed frames is the same platform."""

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.geometry.expressed_instances import expressed_instance
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.instance import Frame, Frames, HomePose
from gspcli.geometry.quaternions import rotation_from_vector

MACHINE = gspcli.example("workspace-study")
TOOL = Frame(["1/3", -20, 45], [1, "1/2", 0, "1/4"])
WORK = Frame([12, 0.5, -3], euler="xyz", angles=[10, "45/2", -70])
HOME = HomePose([3, -4, 400], euler="ZYX", angles=[1, 2, 60])
SOME = [
    replace(MACHINE, home=HOME, frames=frames)
    for frames in (None, Frames(TOOL), Frames(work=WORK), Frames(TOOL, WORK))
]


def _poses(count=20):
    generator = np.random.default_rng(5)
    return rotation_from_vector(generator.normal(size=(count, 3))), generator.normal(
        size=(count, 3), scale=50
    )


def _matrix(R, T):
    return np.block([[R, T[:, None]], [np.zeros(3), 1]])


def _close(found, wanted, atol=1e-11):
    return all(np.allclose(a, b, rtol=0, atol=atol) for a, b in zip(found, wanted, strict=True))


@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("instance", SOME)
def test_there_and_back_is_the_same_pose(instance, relative):
    expressed = PoseFrame.of(instance, pivot=(1, 2, -3), relative=relative)
    R, T = _poses()
    assert _close(expressed.to_platform(*expressed.from_platform(R, T)), (R, T))
    assert _close(expressed.from_platform(*expressed.to_platform(R, T)), (R, T))


def test_a_expressed_pose_is_that_of_the_tool_in_the_work_frame():
    """By products of matrices of four rows, written down for this test."""
    unit = np.pi / 180
    expressed = PoseFrame.of(SOME[3])
    for R, T in zip(*_poses(), strict=True):
        work, tool = (_matrix(frame.R(unit), frame.T) for frame in (WORK, TOOL))
        wanted = np.linalg.inv(work) @ _matrix(R, T) @ tool
        assert np.allclose(_matrix(*expressed.from_platform(R, T)), wanted, rtol=0, atol=1e-12)


@pytest.mark.parametrize("pivot", [(0, 0, 0), (5, -6, 7)])
@pytest.mark.parametrize("instance", SOME)
def test_relative_to_home_zero_is_home(instance, pivot):
    expressed = PoseFrame.of(instance, pivot=pivot, relative=True)
    home = HOME.R(np.pi / 180), HOME.T
    assert _close(expressed.to_platform(np.eye(3), np.zeros(3)), home)
    assert _close(expressed.from_platform(*home), (np.eye(3), np.zeros(3)))


@pytest.mark.parametrize("instance", SOME)
def test_relative_to_home_numbers_are_along_the_axes_of_the_work_frame(instance):
    """The point moves by the expressed vector in these axes, and the platform turns about them."""
    axes = np.eye(3) if not (f := instance.frames) or not f.work else f.work.R(np.pi / 180)
    point = np.zeros(3) if not f or not f.tool else f.tool.T
    expressed, home = PoseFrame.of(instance, relative=True), (HOME.R(np.pi / 180), HOME.T)
    for R, T in zip(*_poses(), strict=True):
        turned, moved = expressed.to_platform(R, T)
        way = turned @ point + moved - home[0] @ point - home[1]
        assert np.allclose(way, axes @ T, rtol=0, atol=1e-11)
        assert np.allclose(turned @ home[0].T, axes @ R @ axes.T, rtol=0, atol=1e-12)


@pytest.mark.parametrize("relative", [False, True])
def test_pivots_add_in_the_frame_of_the_tool(relative):
    expressed = PoseFrame.of(SOME[3], relative=relative)
    R, T = _poses()
    assert _close(
        expressed.at((1, 2, 3)).at((-4, 0, 1)).to_platform(R, T),
        expressed.at((-3, 2, 4)).to_platform(R, T),
    )
    # The position is that of the pivot; the rotation does not depend on the tool's axes.
    (turned, moved), (again, shifted) = (
        one.from_platform(R, T) for one in (expressed, expressed.at((1, 2, 3)))
    )
    assert np.allclose(turned, again, rtol=0, atol=1e-12)
    if not relative:
        assert np.allclose(shifted - moved, turned @ [1, 2, 3], rtol=0, atol=1e-11)


def test_frames_of_no_turn_and_no_shift_change_no_digit():
    still = replace(MACHINE, frames=Frames(Frame([0, 0, 0]), Frame([0, 0, 0], [2, 0, 0, 0])))
    expressed = PoseFrame.of(still)
    assert expressed.is_identity
    assert not expressed.words
    R, T = _poses()
    for found in (
        expressed.to_platform(R, T),
        expressed.from_platform(R, T),
        IDENTITY.to_platform(R, T),
    ):
        assert all(np.array_equal(a, b) for a, b in zip(found, (R, T), strict=True))
    assert gspcli.measure(still, R, T).tolist() == gspcli.measure(MACHINE, R, T).tolist()


def test_a_pivot_alone_is_subtracted_as_before():
    R, T = _poses()
    found = IDENTITY.at((1, 2, 3)).to_platform(R, T)[1]
    assert (found == T - np.einsum("...ij,...j->...i", R, np.tile([1.0, 2, 3], (20, 1)))).all()


@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("name", ["workspace-study-cones", "t-top-head", "example-6.8"])
def test_the_platform_in_expressed_frames_measures_the_same(name, relative):
    """With lines, planes, cones and cranks; and `--pivot` enters as in `PoseFrame`."""
    instance = replace(gspcli.example(name), home=HOME, frames=Frames(TOOL, WORK))
    there = expressed_instance(instance, pivot=(1, "1/7", -2), relative=relative)
    expressed = PoseFrame.of(instance, pivot=(1, 1 / 7, -2), relative=relative)
    R, T = _poses()
    values, again = (
        gspcli.measure(instance, R, T),
        gspcli.measure(there, *expressed.from_platform(R, T)),
    )
    assert np.allclose(values, again, rtol=1e-12, atol=1e-9)
    for row, moved in zip(instance.constraints, there.constraints, strict=True):
        for one, other in ((row.platform, moved.platform), (row.base, moved.base)):
            assert type(one) is type(other)
            assert (getattr(one, "cone", None) is None) == (getattr(other, "cone", None) is None)
    assert there.frames is there.home is None


def test_rational_frames_give_rational_coordinates():
    platform = replace(gspcli.example("platform-6-6"), frames=Frames(TOOL))
    there = expressed_instance(platform, pivot=("1/3", 0, 0))
    numbers = [x for row in there.constraints for x in row.platform.position]
    assert all(number.fraction is not None for number in numbers)


def test_home_is_needed_to_be_relative_to_it():
    with pytest.raises(gspcli.ArgumentError, match="states no home"):
        PoseFrame.of(replace(MACHINE, home=None), relative=True)
    with pytest.raises(gspcli.ArgumentError, match="states no home"):
        expressed_instance(replace(MACHINE, home=None), relative=True)


def test_values_do_not_depend_on_the_frames():
    """What an expressed pose measures is what the platform measures there."""
    R, T = _poses()
    wanted = gspcli.measure(MACHINE, R, T)
    for instance in SOME:
        for relative in (False, True):
            expressed = PoseFrame.of(instance, relative=relative)
            again = expressed.to_platform(*expressed.from_platform(R, T))
            assert np.allclose(gspcli.measure(instance, *again), wanted, rtol=1e-12, atol=1e-9)
