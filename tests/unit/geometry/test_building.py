"""Instances from Python objects equal those from files, and every mistake has its place."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from gspcli.catalogue.kinds import DPP, KINDS, Kind
from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.building import angle, distance, hexapod, instance
from gspcli.geometry.instance import AngleUnit, Constraint, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane, Point
from gspcli.spec import dumps, loads
from tests.support.effort import calls

BASE = [[1, 0, 0], [0.5, 0.8, 0], [-0.5, 0.8, 0], [-1, 0, 0], [-0.5, -0.8, 0], [0.5, -0.8, 0.1]]
PLATFORM = [[0.3, 0.2, 0], [0.3, 0.2, 0], ["1/3", "sqrt(3)/2", 0], [0, 1, 2], [3, 4, 5], [6, 7, 8]]
LENGTHS = [1.1, 1.2, 1.3, 1.4, 1.5, 1.6]
AXIS = Line([0, 0, 0], [0, 0, 1])
FLOOR = Plane([0, 0, 0], [0, 0, 1])
ORIGIN = Point([0, 0, 0])


def test_a_hexapod_equals_the_file():
    made = hexapod(BASE, PLATFORM, LENGTHS, name="Mine")
    text = """
gsp: 1
name: Mine
units: {length: mm, angle: deg}
platform:
  P1: {point: [0.3, 0.2, 0]}
  P2: {point: [1/3, sqrt(3)/2, 0]}
  P3: {point: [0, 1, 2]}
  P4: {point: [3, 4, 5]}
  P5: {point: [6, 7, 8]}
base:
  P1: {point: [1, 0, 0]}
  P2: {point: [0.5, 0.8, 0]}
  P3: {point: [-0.5, 0.8, 0]}
  P4: {point: [-1, 0, 0]}
  P5: {point: [-0.5, -0.8, 0]}
  P6: {point: [0.5, -0.8, 0.1]}
constraints:
  - {distance: [P1, P1], value: 1.1}
  - {distance: [P1, P2], value: 1.2}
  - {distance: [P2, P3], value: 1.3}
  - {distance: [P3, P4], value: 1.4}
  - {distance: [P4, P5], value: 1.5}
  - {distance: [P5, P6], value: 1.6}
"""
    assert made == loads(text)
    assert loads(dumps(made)) == made


@pytest.mark.parametrize(
    "value",
    [0.1, np.float64(0.1), np.float32(0.1), Decimal("0.1"), Fraction(1, 10), "0.1", "1/10"],
    ids=lambda value: type(value).__name__,
)
def test_a_tenth_is_a_tenth(value):
    assert Number.of(value) == Number("rational", (Fraction(1, 10),))


def test_whole_numbers_and_arrays_of_them():
    assert Number.of(np.int32(3)) == Number.of(3) == Number.of(3.0)
    assert Point(np.array([1, 2, 3])) == Point((1.0, 2.0, 3.0))


def test_every_kind_of_constraint():
    primitives = {"P": ORIGIN, "L": AXIS, "H": FLOOR}
    for kind in KINDS:
        make = distance if kind.is_distance else angle
        pair = primitives[kind.platform.value], primitives[kind.base.value]
        assert make(*pair, "sqrt(2)").kind is kind


def test_a_mixed_platform_equals_the_file():
    made = instance(
        [
            distance(ORIGIN, AXIS, 6),
            distance(ORIGIN, FLOOR, 1.5, side="positive", range=(1, 2)),
            distance(AXIS, Point([1, 2, 3]), np.float64(2)),
            angle(AXIS, AXIS, 1),
            angle(AXIS, FLOOR, "pi/4"),
            angle(FLOOR, FLOOR, 0.5),
        ],
        length="m",
        angle="rad",
    )
    assert loads(dumps(made)) == made
    assert made.constraints[1].side is Side.POSITIVE
    assert made.units.angle is AngleUnit.RADIAN


def changed(rows, index, value):
    rows = [list(row) if isinstance(row, list) else row for row in rows]
    rows[index] = value
    return rows


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((BASE[:5], PLATFORM, LENGTHS), "base: found 5 points, expected six"),
        ((BASE, PLATFORM, [*LENGTHS, 1]), "lengths: found 7 lengths of legs, expected six"),
        ((BASE, 3, LENGTHS), "platform: found a int, expected six points"),
        (
            (BASE, changed(PLATFORM, 3, [0, 1]), LENGTHS),
            "platform[3]: found 2 entries, expected three numbers [x, y, z]",
        ),
        (
            (changed(BASE, 2, [0, float("nan"), 1]), PLATFORM, LENGTHS),
            "base[2][1]: found nan, expected a finite number",
        ),
        (
            (BASE, PLATFORM, changed(LENGTHS, 4, np.inf)),
            "lengths[4]: found inf, expected a finite number",
        ),
        (
            (BASE, PLATFORM, changed(LENGTHS, 1, -2)),
            "lengths[1]: found -2, expected a distance of at least 0",
        ),
        (
            (BASE, PLATFORM, changed(LENGTHS, 0, "sqrt(-1)")),
            "lengths[0]: found sqrt of -1 in 'sqrt(-1)', expected an argument of at least 0",
        ),
        (
            (BASE, PLATFORM, changed(LENGTHS, 0, None)),
            "lengths[0]: found a NoneType, expected a finite number",
        ),
        (
            (BASE, PLATFORM, changed(LENGTHS, 5, 1e99)),
            "lengths[5]: found 1e+99, expected 0 or a magnitude from 1e-60 to 1e+60",
        ),
    ],
)
def test_mistakes_in_a_hexapod(arguments, message):
    with pytest.raises(GspError) as caught:
        hexapod(*arguments)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Point("abc"), "position: found 'abc', expected three numbers [x, y, z]"),
        (lambda: Point([0, 0, True]), "position[2]: found True, expected a finite number"),
        (
            lambda: Line([0, 0, 0], [0, 0, 0]),
            "direction: found the zero vector, expected a direction: any nonzero vector",
        ),
        (lambda: Plane([0, 0, 0], [1, "x", 0]), "normal[1]: found 'x', expected a number, pi, "),
        (lambda: distance(ORIGIN, AXIS, "1/0"), "value: found a division by zero in '1/0'"),
        (
            lambda: distance(FLOOR, FLOOR, 1),
            "found the distance of a plane and a plane, expected one of PP PL LP PH HP LL",
        ),
        (
            lambda: angle(ORIGIN, AXIS, 1),
            "found the angle of a point and a line, expected one of LL LH HL HH: there is no other",
        ),
        (lambda: distance([0, 0, 0], AXIS, 1), "platform: found a list, expected a Point, a Line"),
        (lambda: distance(ORIGIN, FLOOR, 1, side="up"), "side: found 'up', expected positive, "),
        (lambda: distance(ORIGIN, AXIS, 1, range=3), "range: found 3, expected two numbers"),
        (lambda: distance(ORIGIN, AXIS, 1, range=(0, np.nan)), "range[1]: found nan, expected"),
        (
            lambda: instance([distance(ORIGIN, AXIS, 1)] * 5),
            "constraints: found 5 constraints, expected exactly six",
        ),
        (
            lambda: instance([angle(AXIS, AXIS, 1)] * 6),
            "constraints: found 6 angles, expected at most three",
        ),
        (
            lambda: instance([angle(AXIS, AXIS, 181)] * 6),
            "constraints[0].value: found 181, expected an angle of LL from 0 to 180 (deg)",
        ),
        (
            lambda: instance([distance(ORIGIN, AXIS, 1, side="positive")] * 6),
            "constraints[0].side: found a side for DPL, expected one only for DPH and DHP",
        ),
        (
            lambda: instance([distance(ORIGIN, FLOOR, 1, range=(3, 2))] * 6),
            "constraints[0].range: found 3 above 2, expected (low, high)",
        ),
        (lambda: instance([1] * 6), "constraints[0]: found a int, expected a Constraint"),
        (lambda: instance([], angle="grad"), "angle: found 'grad', expected deg or rad"),
    ],
)
def test_mistakes_in_other_platforms(make, message):
    with pytest.raises(ArgumentError) as caught:
        make()
    assert str(caught.value).startswith(message)


def test_a_number_where_a_number_object_is_wanted_is_made_one():
    row = Constraint(DPP, ORIGIN, ORIGIN, 0.1)  # type: ignore[arg-type]
    assert row.value == Number.of("0.1")
    assert isinstance(row.kind, Kind)


def test_a_hexapod_is_made_with_few_calls():
    """0.2 ms on a quiet machine."""
    rng = np.random.default_rng(0)
    base, platform = rng.normal(size=(2, 6, 3)).round(3)
    hexapod(base, platform, LENGTHS)
    assert calls(lambda: hexapod(base, platform, LENGTHS)) < 1500
