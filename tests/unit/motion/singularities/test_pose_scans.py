from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import PoseFormat
from gspcli.motion.singularities.scans import Axis, PoseScan
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
        found = PoseScan(instance, (axis("x", -2, 2, 7), axis("z", -1, 2, 5)), POSE, PoseFormat())
        R, T = found.poses(found.places.reshape(-1, 2))
        sizes = wrenches(instance, R, T).manipulability.reshape(7, 5)
        assert np.allclose(np.abs(found.determinants), sizes, rtol=1e-9)
        assert {-1, 1} == {*np.sign(found.determinants).ravel().tolist()}
        assert found.conditions.shape == (7, 5)


def test_the_singular_curve_separates_the_signs(hexapod):
    found = PoseScan(hexapod, (axis("x", -2, 2, 31), axis("y", -2, 2, 31)), POSE, PoseFormat())
    signs = np.sign(found.determinants)
    edges = sum(int((np.diff(signs, axis=k) != 0).sum()) for k in (0, 1))
    assert len(found.singular) == edges > 50
    points = np.concatenate(found.curves)
    assert len(points) >= edges
    R, T = found.poses(points)
    assert (wrenches(hexapod, R, T).conditions > 1e9).all()
    # The parts end on the border, or nowhere.
    for curve in found.curves:
        closed = np.array_equal(curve[0], curve[-1])
        assert closed or all(np.isclose(np.abs(end), 2).any() for end in (curve[0], curve[-1]))
        assert (np.linalg.norm(np.diff(curve, axis=0), axis=1) < 0.2).all()


def test_angles_and_one_coordinate(hexapod):
    form = PoseFormat("ZYX", (0.0, 0.0, 0.1), np.pi / 180)
    found = PoseScan(hexapod, (axis("rx", -180, 180, 73),), (0, 0, 0.5, 10, 0, 0), form)
    assert found.determinants[0] == pytest.approx(found.determinants[-1])
    changes = int((np.diff(np.sign(found.determinants)) != 0).sum())
    assert len(found.singular) == changes
    assert changes % 2 == 0
    assert found.curves == []


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
        PoseScan(hexapod, tuple(axis(name, 0, 1, 2) for name in names), pose, PoseFormat())
