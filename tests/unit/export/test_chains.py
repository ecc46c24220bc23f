"""The chains of joints: their values are what the constraints measure, one coordinate of six."""

import math

import numpy as np
import pytest

from gspcli.catalogue.kinds import AHH, AHL, ALH, ALL, ANGLE_KINDS, DISTANCE_KINDS, DLL, DPH, DPP
from gspcli.export.chains import chain, feet
from gspcli.geometry.arrangement import Bodies
from gspcli.geometry.measurement import measured

ORIGIN = np.zeros(3)
X, Y, Z = np.eye(3)
FREEDOMS = {"hinge": 1, "slide": 1, "ball": 3}


def _joints(links):
    return [joint for link in links for joint in link.joints]


def _value(links):
    (value,) = (joint.value for joint in _joints(links) if joint.value is not None)
    return value


def _measured(kind, x, v, y, w):
    bodies = Bodies((kind,), y[None], x[None], w[None], v[None])
    return float(measured(bodies, np.eye(3), ORIGIN)[0])


@pytest.mark.parametrize("kind", [*DISTANCE_KINDS, *ANGLE_KINDS], ids=str)
def test_six_freedoms_and_the_value_that_is_measured(kind):
    rng = np.random.default_rng(5)
    for _ in range(20):
        x, y = rng.normal(size=(2, 3))
        v, w = (a / np.linalg.norm(a) for a in rng.normal(size=(2, 3)))
        links = chain(kind, x, v, y, w)
        assert sum(FREEDOMS[joint.type] for joint in _joints(links)) == 6
        expected = _measured(kind, x, v, y, w)
        assert _value(links) == pytest.approx(abs(expected) if kind.is_distance else expected)


@pytest.mark.parametrize(
    ("kind", "w", "degrees"),
    [(ALL, Z, 0), (ALL, -Z, 180), (AHH, Z, 180), (AHH, -Z, 0), (ALH, Z, 90), (AHL, -Z, -90)],
)
def test_parallel_directions_have_their_exact_angle_and_perpendicular_axes(kind, w, degrees):
    links = chain(kind, ORIGIN, Z, X, w)
    assert _value(links) == pytest.approx(math.radians(degrees), abs=1e-15)
    axes = [joint.axis for joint in _joints(links) if joint.type == "hinge"]
    assert axes[1] @ axes[0] == 0
    assert axes[1] @ axes[2] == 0


def test_parallel_lines_are_joined_at_a_common_perpendicular():
    links = chain(DLL, ORIGIN, Z, np.array([3.0, 4.0, 7.0]), Z)
    assert _value(links) == 5
    near, far = feet(ORIGIN, Z, np.array([3.0, 4.0, 7.0]), Z)
    assert near.tolist() == [0, 0, 0]
    assert far.tolist() == [3, 4, 0]


def test_feet_of_skew_lines():
    near, far = feet(np.array([5.0, 0, 0]), X, np.array([2.0, 9.0, 3.0]), Y)
    assert near.tolist() == [2, 0, 0]
    assert far.tolist() == [2, 0, 3]


@pytest.mark.parametrize("kind", DISTANCE_KINDS, ids=str)
def test_a_distance_of_zero_has_unit_axes(kind):
    links = chain(kind, X, Z, X, Y)
    assert _value(links) == 0
    for joint in _joints(links):
        assert np.linalg.norm(joint.axis) == pytest.approx(1)


def test_a_distance_grows_with_its_coordinate_on_both_sides_of_a_plane():
    for height in (2.0, -2.0):
        (slide,) = (j for j in _joints(chain(DPH, ORIGIN, Z, height * Z, Z)) if j.value is not None)
        assert (slide.axis @ Z, slide.value) == (math.copysign(1, height), 2)
    (leg,) = (j for j in _joints(chain(DPP, X, Z, 4 * X, Z)) if j.value is not None)
    assert leg.axis.tolist() == X.tolist()
