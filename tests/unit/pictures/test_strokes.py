"""What is drawn is what is measured: the length of a leg, the angle of an arc, right angles."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from gspcli.catalogue.kinds import AHH, ALL, KINDS, Kind, Primitive
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.measurement import measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point, vector
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.pictures.scene import Stroke, StrokeStyle
from gspcli.pictures.stage import ConstraintEnds, Sizes, angle_strokes, connection, distance_strokes

SIZES = Sizes(0.1, 1.0, 0.5)
POSES = 20


def _primitive(sort: Primitive, rng: np.random.Generator) -> Geometry:
    position = vector(*rng.normal(size=3).tolist())
    if sort is Primitive.POINT:
        return Point(position)
    direction = vector(*rng.normal(size=3).tolist())
    return (Line if sort is Primitive.LINE else Plane)(position, direction)


def _drawn(kind: Kind) -> tuple[list[Stroke], np.ndarray, ConstraintEnds]:
    """Return the strokes of a random constraint at random poses, its values and its ends."""
    rng = np.random.default_rng(kind.order)
    row = Constraint(kind, _primitive(kind.platform, rng), _primitive(kind.base, rng), Number.of(1))
    one = Arrangement.of(Instance((row,), Units("m", AngleUnit.RADIAN)))
    R, T = rotation_from_vector(rng.normal(size=(POSES, 3))), rng.normal(size=(POSES, 3))
    ends = ConstraintEnds(
        R @ one.y[0] + T,
        np.broadcast_to(one.x[0], (POSES, 3)),
        R @ one.u[0],
        np.broadcast_to(one.v[0], (POSES, 3)),
    )
    if kind.is_distance:
        ends = connection(kind, ends.platform, ends.w, ends.base, ends.v)
        strokes = [*distance_strokes(kind, ends, SIZES)]
    else:
        strokes = [*angle_strokes(kind, ends, SIZES)]
    return strokes, measured(one, R, T)[:, 0], ends


@pytest.mark.parametrize("kind", [k for k in KINDS if k.is_distance], ids=str)
def test_a_leg_is_as_long_as_the_distance_and_perpendicular(kind: Kind) -> None:
    strokes, values, ends = _drawn(kind)
    leg = strokes[0].points[:, 0] - strokes[0].points[:, 1]
    np.testing.assert_allclose(np.linalg.norm(leg, axis=1), np.abs(values), atol=1e-12)
    for sort, direction in ((kind.platform, ends.w), (kind.base, ends.v)):
        if sort is Primitive.LINE:
            np.testing.assert_allclose(np.einsum("ni,ni->n", leg, direction), 0, atol=1e-12)
        elif sort is Primitive.PLANE:
            np.testing.assert_allclose(np.cross(leg, direction), 0, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_marks_of_right_angles_are_right(kind: Kind) -> None:
    for stroke in _drawn(kind)[0]:
        if stroke.style is StrokeStyle.SQUARE:
            first, corner, last = np.moveaxis(stroke.points, 1, 0)
            turn = np.einsum("ni,ni->n", first - corner, last - corner)
            np.testing.assert_allclose(turn, 0, atol=1e-12)


@pytest.mark.parametrize("kind", [k for k in KINDS if not k.is_distance], ids=str)
def test_an_arc_is_as_wide_as_the_angle(kind: Kind) -> None:
    strokes, values, ends = _drawn(kind)
    arc = (strokes[0].points - ends.base[:, None]) / SIZES.arc
    steps = [
        np.arccos(np.clip(np.einsum("ni,ni->n", a, b), -1, 1))
        for a, b in pairwise(np.moveaxis(arc, 1, 0))
    ]
    np.testing.assert_allclose(sum(steps), np.abs(values), atol=1e-6)
    if kind in (ALL, AHH):
        np.testing.assert_allclose(arc[:, 0], ends.v, atol=1e-12)


def test_parallel_lines_and_right_angles_to_planes_are_drawn() -> None:
    along = np.array([[0.0, 0.0, 1.0]])
    offset = np.array([[2.0, 0.0, 5.0]])
    ends = connection(KINDS[5], offset, along, np.zeros((1, 3)), along)
    assert np.linalg.norm(ends.platform - ends.base) == pytest.approx(2)
    for kind in KINDS[6:]:
        for stroke in angle_strokes(kind, ConstraintEnds(offset, offset, along, along), SIZES):
            assert np.isfinite(stroke.points).all()
