from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import PoseFormat
from gspcli.motion.singularities.scans import Axis, VariedPoses, boundary, scan_grid
from gspcli.motion.statics.wrenches import wrenches
from gspcli.resources import data_path

POSE = (0, 0, 0.5, 1, 0.2, 0.1, 0)


@pytest.fixture(scope="module")
def hexapod():
    return gspcli.load(data_path("examples", "platform-6-6.yaml"))


def axis(name, low, high, count):
    return Axis(name, tuple(np.linspace(low, high, count).tolist()))


def test_determinants_are_the_manipulability_with_a_sign(hexapod):
    rng = np.random.default_rng(3)
    other = random_instance(gspcli.parse_type("PL LP PH DLL ALL ALH"), rng)[0]
    for instance in (hexapod, other):
        axes = (axis("x", -2, 2, 7), axis("z", -1, 2, 5))
        varied = VariedPoses(instance, axes, POSE, PoseFormat())
        determinants, conditions = scan_grid(varied).numbers.values()
        R, T = varied.poses(varied.nodes.reshape(-1, 2))
        sizes = wrenches(instance, R, T).manipulability.reshape(7, 5)
        assert np.allclose(np.abs(determinants), sizes, rtol=1e-9)
        assert {-1, 1} == {*np.sign(determinants).ravel().tolist()}
        assert conditions.shape == (7, 5)


def test_the_singular_curve_separates_the_signs(hexapod):
    axes = (axis("x", -2, 2, 31), axis("y", -2, 2, 31))
    varied = VariedPoses(hexapod, axes, POSE, PoseFormat())
    found = scan_grid(varied)
    limits, signs = boundary(found), np.sign(found.numbers["determinant"])
    edges = sum(int((np.diff(signs, axis=k) != 0).sum()) for k in (0, 1))
    assert len(limits.crossings) == edges > 50
    points = np.concatenate([curve.values for curve in limits.curves])
    assert len(points) >= edges
    R, T = varied.poses(points)
    assert (wrenches(hexapod, R, T).conditions > 1e9).all()
    # The parts end on the border, or nowhere.
    for curve in limits.curves:
        ends = curve.values[[0, -1]]
        assert curve.closed or np.isclose(np.abs(ends), 2).any(axis=1).all()
        assert (np.linalg.norm(np.diff(curve.values, axis=0), axis=1) < 0.2).all()


def test_angles_and_one_coordinate(hexapod):
    form = PoseFormat("ZYX", (0.0, 0.0, 0.1), np.pi / 180)
    pose = (0, 0, 0.5, 10, 0, 0)
    found = scan_grid(VariedPoses(hexapod, (axis("rx", -180, 180, 73),), pose, form))
    determinants, limits = found.numbers["determinant"], boundary(found)
    assert determinants[0] == pytest.approx(determinants[-1])
    signs = np.diff(np.sign(determinants))
    assert [one.change for one in limits.crossings] == signs[signs != 0].tolist()
    assert len(limits.crossings) % 2 == 0
    assert limits.curves == []


@pytest.mark.parametrize(
    ("names", "pose", "error", "message"),
    [
        ("", POSE, ArgumentError, "expected one or two"),
        ("xx", POSE, ArgumentError, "expected one or two"),
        (["rx"], POSE, ArgumentError, "that the pose has: x y z qw"),
    ],
)
def test_mistakes(hexapod, names, pose, error, message):
    with pytest.raises(error, match=message):
        VariedPoses(hexapod, tuple(axis(name, 0, 1, 2) for name in names), pose, PoseFormat())
