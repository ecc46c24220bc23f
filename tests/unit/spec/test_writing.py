"""Instances as text: readable, exact, unambiguous."""

import pytest

import gspcli
from gspcli.catalogue.kinds import DPH, DPP
from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Plane, Point, vector
from gspcli.resources import data_path
from gspcli.spec import dumps, loads
from gspcli.spec.writing import scalar


def a_point(x, name="", value=1):
    return Constraint(
        DPP,
        Point(vector(x, 0, 0)),
        Point(vector(0, 0, "1/3")),
        Number.of(value),
        Side.BOTH,
        name,
        "A",
    )


def test_primitives_without_a_name_get_one():
    plane = Plane(vector(0, 0, 0), vector(0, 0, 1))
    instance = Instance(
        (
            *(a_point(x) for x in range(4)),
            a_point(4, "P2"),
            Constraint(DPH, Point(vector(9, 0, 0)), plane, Number.of("0.5"), Side.NEGATIVE),
        ),
        Units("mm", AngleUnit.RADIAN),
        source="Ä: 'x'\n",
    )
    text = dumps(instance)
    assert (
        text
        == """\
gsp: 1
source: "Ä: 'x'\\u000a"
units: {length: mm, angle: rad}
platform:
  P1: {point: [0, 0, 0]}
  P3: {point: [1, 0, 0]}
  P4: {point: [2, 0, 0]}
  P5: {point: [3, 0, 0]}
  P2: {point: [4, 0, 0]}
  P6: {point: [9, 0, 0]}
base:
  A: {point: [0, 0, 1/3]}
  H1: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
constraints:
  - {distance: [P1, A], value: 1}
  - {distance: [P3, A], value: 1}
  - {distance: [P4, A], value: 1}
  - {distance: [P5, A], value: 1}
  - {distance: [P2, A], value: 1}
  - {distance: [P6, H1], value: 0.5, side: negative}
"""
    )
    assert dumps(loads(text)) == text
    assert loads(text).source == instance.source


def test_one_name_for_two_primitives_is_refused():
    constraints = tuple(a_point(x, "B") for x in range(6))
    with pytest.raises(GspError, match="the name B stands for two different primitives"):
        dumps(Instance(constraints, Units("mm", AngleUnit.RADIAN)))


@pytest.mark.parametrize("text", ["P1", "L4'", "Example 6.8", "a_b.c"])
def test_plain_texts_stay_plain(text):
    assert scalar(text) == text


@pytest.mark.parametrize(
    "text", ["", "null", "Yes", "1.5", "a: b", "a #b", "-a", " a", "a,b", "[", "#"]
)
def test_others_are_quoted(text):
    assert scalar(text) == f'"{text}"'


def test_cones_read_back():
    text = dumps(loads(CONES))
    assert "B1: {point: [1, 0, 0], cone: {axis: [0, -1/3, 2], half_angle: 30.5}}" in text
    assert loads(text) == loads(CONES)


@pytest.mark.parametrize(
    ("legs", "lines"),
    [
        ("{rod: {mass: 1/3, centre: 2}}", 1),
        ("[{rod: {mass: 1, centre: 2}}" + ", {cylinder: {mass: 2, centre: 1}}" * 5 + "]", 7),
        ("{rod: {mass: 1, centre: 2, inertia: 3, axial: 1}, universal: [0, 1, -2]}", 1),
    ],
)
@pytest.mark.parametrize("drives", ["{inertia: [1, 2, 3, 4, 5, 6], stiffness: 1e6}", "{}"])
def test_masses_read_back(legs, lines, drives):
    body = "{mass: 12.5, centre: [0, 0, sqrt(2)], inertia: [4, 5, 6, 0, 0, -0.5]}"
    said = f"dynamics:\n  platform: {body}\n  legs: {legs}\n  drives: {drives}\n"
    instance = loads(CONES + said)
    text = dumps(instance)
    assert loads(text) == instance != loads(CONES)
    assert f"platform: {body}" in text
    assert "gravity: [0, 0, -9.81]" in text
    assert text[text.index("  legs:") : text.index("  drives:")].count("\n") == lines


CONES = """\
gsp: 1
units: {length: mm, angle: deg}
platform:
  P1: {point: [0, 0, 0], cone: {axis: [0, 0, -1], half_angle: sqrt(2)}}
  P2: {point: [0, 1, 0]}
base:
  B1: {point: [1, 0, 0], cone: {axis: [0, -1/3, 2], half_angle: 30.5}}
  B2: {point: [0, 3, 0]}
  B3: {point: [0, 0, 4]}
constraints:
  - {distance: [P1, B1], value: 2, range: [1/2, 3]}
  - {distance: [P1, B2], value: 2}
  - {distance: [P1, B3], value: 2}
  - {distance: [P2, B1], value: 2}
  - {distance: [P2, B2], value: 2}
  - {distance: [P2, B3], value: 2}
"""


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda good: gspcli.dump(good, 7), "file: found a int, expected a path or an open file"),
        (lambda _: gspcli.dumps(None), "instance: found a NoneType, expected an Instance"),
        (lambda _: gspcli.set_values(None, {1: 2}), "instance: found a NoneType"),
        (lambda _: gspcli.load(None), "source: found a NoneType, expected a path"),
        (lambda _: gspcli.loads(b"gsp: 1"), "text: found a bytes, expected the text"),
        (lambda _: gspcli.parse_type(None), "found a NoneType, expected a text, such as 6PP"),
        (lambda _: gspcli.parse_type([1, 2]), "found a list, expected a text"),
        (lambda _: gspcli.parse_kind(None), "found a NoneType, expected a text"),
        (lambda _: gspcli.parse_class(3), "found a int, expected a text"),
        (lambda _: gspcli.parse_kind_set(None), "found a NoneType, expected a text"),
    ],
)
def test_wrong_arguments_are_named(wrong, said):
    good = gspcli.load(data_path("examples", "dietmaier.yaml"))
    with pytest.raises(ArgumentError) as caught:
        wrong(good)
    assert str(caught.value).startswith(said)


HOMES = [
    ("{position: [0, 1/3, 20]}", "{position: [0, 1/3, 20], quaternion: [1, 0, 0, 0]}"),
    ("{position: [0, 0, 2], quaternion: [1, 0, 0, sqrt(3)]}",) * 2,
    (
        "{euler: ZYX, position: [0, 0, 2], rz: -90}",
        "{position: [0, 0, 2], rx: 0, ry: 0, rz: -90, euler: ZYX}",
    ),
]


@pytest.mark.parametrize(("stated", "written"), HOMES)
def test_home_is_written_and_read_back(stated, written):
    text = data_path("platforms", "linuxcnc-hexapod.yaml").read_text(encoding="utf-8")
    instance = loads(text + f"home: {stated}\n")
    assert f"\nhome: {written}\n" in dumps(instance)
    assert loads(dumps(instance)) == instance
    assert loads(dumps(instance)).home == instance.home
    assert loads(text) != instance
