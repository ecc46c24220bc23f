"""Instance files that are read, and what is wrong in them."""

from __future__ import annotations

import io
import json
import math
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import gspcli
from gspcli import ArgumentError, Instance, angle, distance, instance
from gspcli.cli.commands.solve import _complain
from gspcli.errors import GspError, IncompleteError, SpecError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.building import hexapod
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.expressed_instances import expressed_instance
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import AngleUnit, Frame, Frames, Shapes, Side
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane, Point
from gspcli.motion import gaps
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import dumps, load, loads, out_of_proportion, read, read_text, set_values, sharing
from gspcli.spec.document import MAX_BYTES
from gspcli.spec.motor_files import motor_file
from gspcli.spec.reading import example

# Every mistake that a person can make in an instance file, at its place.


GOOD = """\
gsp: 1
name: Example
type: 3D3A PP PL PH all alh ahh
units: {length: mm, angle: deg}
platform:
  P1: {point: [0, 1/2, 'sqrt(3)/2']}
  L1: {line: {point: [0, 0, 0], direction: [0, 0, 2]}}
  H1: {plane: {point: [0, 0, 1], normal: [0, 1, 1]}}
base:
  P1: {point: [1e-3, 0, 0]}
  L4: {line: {point: [0, 0, 0], direction: [0, 0, 1]}}
  H4: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
constraints:
  - {distance: [P1, P1], value: 2}
  - {distance: [P1, L4], value: 0.10}
  - {distance: [P1, H4], value: 1.5, side: positive}
  - {angle: [L1, L4], value: 60}
  - {angle: [L1, H4], value: -90}
  - {angle: [H1, H4], value: 180}
dynamics:
  gravity: [0, 0, -9.81]
  platform: {mass: 12, centre: [0, 0, 20], inertia: [4, 5, 6, 0, 0, 0.5]}
  legs:
    cylinder: {mass: 0.35, centre: 30, inertia: 9, axial: 1}
    rod: {mass: 0.2, centre: 30, inertia: 5}
    universal: [1, 0, 0]
  drives: {inertia: 0, stiffness: [1e6, 2e6, 1e6, 1e3, 1e3, 1e3]}
home: {position: [0, 0, 20], rx: 1, euler: xyz}
"""


def mistakes_of(text):
    with pytest.raises(SpecError) as caught:
        loads(text, name="f")
    return [str(mistake) for mistake in caught.value.mistakes]


def test_a_good_file():
    instance = loads(GOOD)
    assert instance.name == "Example"
    assert instance.source is None
    assert instance.units.length == "mm"
    assert instance.units.angle is AngleUnit.DEGREE
    assert instance.type.id == "DPP DPL DPH ALL ALH AHH"
    sorts = [(type(c.platform), type(c.base)) for c in instance.constraints]
    assert sorts[:4] == [(Point, Point), (Point, Line), (Point, Plane), (Line, Line)]
    assert [c.side for c in instance.constraints] == [Side.BOTH] * 2 + [Side.POSITIVE] + [
        Side.BOTH
    ] * 3
    assert [str(c.value) for c in instance.constraints] == ["2", "0.1", "1.5", "60", "-90", "180"]
    assert [str(x) for x in instance.constraints[0].platform.position] == [
        "0",
        "0.5",
        "sqrt(3) / 2",
    ]
    assert sharing(instance) == ({"P1": [1, 2, 3], "L1": [4, 5]}, {"L4": [2, 4], "H4": [3, 5, 6]})


MISTAKES = [
    case.split("\n")
    for case in Path(__file__)
    .with_name("mistakes.txt")
    .read_text(encoding="utf-8")
    .strip()
    .split("\n\n")[1:]
]


@pytest.mark.parametrize(("change", "mistake"), MISTAKES)
def test_a_mistake_is_reported_where_it_is(change, mistake):
    old, new = map(json.loads, change.split(" => "))
    assert old in GOOD
    assert mistake in mistakes_of(GOOD.replace(old, new, 1))


def test_all_mistakes_are_reported_at_once_in_order():
    text = (
        GOOD.replace("name: E", "nmae: E").replace("1e-3", "x").replace("value: 60", "value: 600")
    )
    text = text.replace("[L1, H4]", "[L9, H4]").replace("180", "1/0")
    assert [mistake.split(": ")[0] for mistake in mistakes_of(text)] == [
        "f:2:1",
        "f:10:16",
        "f:17:30",
        "f:18:14",
        "f:19:30",
    ]


def test_several_repetitions_and_missing_parts_do_not_hide_others():
    assert mistakes_of("gsp: 1\nbase: {P1: {point: [0, 0]}}\nconstraints: []") == [
        "f:1:1: the keys units and platform are missing",
        "f:2:20: base.P1.point: found 2 entries, expected three numbers [x, y, z]",
        "f:3:14: constraints: found 0 constraints, expected exactly six; gsp freedoms takes any "
        "number",
    ]


@pytest.mark.parametrize(
    ("text", "mistake"),
    [
        ("", "found nothing, expected an instance"),
        ("# only a comment\n", "found nothing, expected an instance"),
        ("- 1", "found no keys, expected an instance: gsp, units, platform, base, constraints"),
        ("hello", "found no keys, expected an instance: gsp, units, platform, base, constraints"),
        ("[" * 5000, "found more than 12 levels of nesting"),
        ("a" * (MAX_BYTES + 1), "found 100001 characters, expected an instance of at most 100000"),
    ],
)
def test_what_is_no_instance_at_all(text, mistake):
    (found,) = mistakes_of(text)
    assert found.startswith("f:1:1")
    assert found.endswith(mistake)


@pytest.mark.parametrize(
    ("content", "mistake"),
    [
        (
            b"name: \xe4",
            ":1:7: found the byte 0xe4 (ä in Windows-1252), expected text in UTF-8: save it as "
            "UTF-8, in Excel as 'CSV UTF-8'",
        ),
        (
            GOOD.encode("utf-16"),
            ":1:1: found text in UTF-16, expected UTF-8: save it as UTF-8, in Excel as 'CSV UTF-8'",
        ),
        (b"a:\n " + bytes(200), ":2:2: found the character U+0000, expected printable text"),
        (b" " * 100_001, ":1:1: found 100001 bytes, expected an instance file of at most 100000"),
    ],
)
def test_files_that_are_no_text(tmp_path, content, mistake):
    path = tmp_path / "x.yaml"
    path.write_bytes(content)
    with pytest.raises(SpecError) as caught:
        load(path)
    assert str(caught.value) == f"{path}{mistake}"


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_line_ends_and_byte_order_mark_do_not_matter(tmp_path, end, mark):
    path = tmp_path / "x.yaml"
    path.write_bytes((mark + GOOD.replace("\n", end)).encode())
    assert load(path) == load(str(path)) == loads(mark + GOOD) == loads(GOOD)


def test_open_files_and_standard_input(monkeypatch):
    assert load(io.StringIO(GOOD)) == load(io.BytesIO(GOOD.encode())) == loads(GOOD)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"gsp: 1")))
    with pytest.raises(SpecError, match=r"^standard input:1:1: the keys units, platform, base and"):
        load("-")


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(SpecError, match=r"none\.yaml: cannot be read: No such file or directory"):
        load(tmp_path / "none.yaml")
    with pytest.raises(SpecError, match="cannot be read: Is a directory"):
        load(tmp_path)


def test_radians_include_the_ends_of_the_range():
    text = GOOD.replace("angle: deg", "angle: rad").replace("60", "1")
    text = text.replace("180", "acos(-1)").replace("-90", "-pi/2")
    assert loads(text).units.angle is AngleUnit.RADIAN
    assert (
        "expected an angle of HH from 0 to pi (rad)"
        in mistakes_of(text.replace("acos(-1)", "3.15"))[0]
    )


def test_quoted_words_are_text_and_null_is_nothing():
    assert loads(GOOD.replace("name: Example", "name: 'null'")).name == "null"
    for nothing in ("", "~", "null"):
        assert loads(GOOD.replace("name: Example", f"name: {nothing}")).name is None
    renamed = loads(GOOD.replace("L4", "on").replace("H4", "1_0"))
    assert {c.base_name for c in renamed.constraints} == {"P1", "on", "1_0"}


def test_warnings_tell_what_is_perhaps_not_meant():
    text = GOOD.replace("value: 2", "value: 0").replace("value: 0.10", "value: 0")
    text = text.replace("1.5", "0").replace("base:", "  Q: {point: [0, 0, 0]}\nbase:")
    text = text.replace("[H1, H4]", "[H2, H4]").replace(
        "  L4", "  P2: {point: [0.001, 0, 0]}\n  L4"
    )
    text = text.replace("  Q:", "  H2: {plane: {point: [0, 0, 1], normal: [0, 1, 1]}}\n  Q:")
    text = text.replace("[L1, L4]", "[H1, L4]").replace("all alh ahh", "alh ahl ahh")
    text = text.replace("[P1, P1]", "[P1, P2]")
    assert [f"{w.path}: {w.message.split(':')[0]}" for w in read_text(text).warnings] == [
        "platform.H2: the same as H1",
        "platform.Q: not used by any constraint",
        "base.P1: not used by any constraint",
        "constraints[1]: DPP with value 0 is 3 equations, not one (Section 2)",
        "constraints[2]: DPL with value 0 is 2 equations, not one (Section 2)",
        "constraints[3]: DPH with value 0 has no sides",
        "constraints[5]: ALH with value -90 is 2 equations, not one (Section 2)",
        "constraints[6]: AHH with value 180 is 2 equations, not one (Section 2)",
    ]


def test_sharing_that_never_fixes_the_platform_is_proved():
    text = GOOD.replace("[H1, H4]", "[L1, H5]").replace("all alh ahh", "all alh alh")
    text = text.replace(
        "constraints:", "  H5: {plane: {point: [0, 0, 0], normal: [1, 0, 1]}}\nconstraints:"
    )
    text = text.replace("-90", "30").replace("180", "30")
    (warning,) = (w for w in read_text(text).warnings if w.path.startswith("constraints"))
    assert warning.path == "constraints[4]"
    assert warning.message == (
        "no solution, or infinitely many: motions that keep the direction of the platform's L1 in "
        "place have 4 freedoms, so at most 2 of these 3 constraints are independent "
        "(constraints 4 5 6)"
    )


def test_values_can_be_set_exactly():
    instance = set_values(loads(GOOD), ["1=5.2", " 4 = acos(1/3)*180/pi"])
    assert str(instance.constraints[0].value) == "5.2"
    assert instance.constraints[3].value.value == pytest.approx(70.528779, abs=1e-6)
    assert instance.constraints[1:3] == loads(GOOD).constraints[1:3]


def test_wrong_settings_are_all_reported():
    with pytest.raises(SpecError) as caught:
        set_values(loads(GOOD), ["1=5", "1=6", "2", "7=1", "x=1", "4=200", "2=-1", "3=1/0", "²=1"])
    assert [str(mistake) for mistake in caught.value.mistakes] == [
        "--set '1=6': found constraint 1 twice",
        "--set '2': expected I=V, as 1=5.2",
        "--set '7=1': found constraint '7', expected a number from 1 to 6",
        "--set 'x=1': found constraint 'x', expected a number from 1 to 6",
        "--set '4=200': found '200', expected an angle of LL from 0 to 180 (deg)",
        "--set '2=-1': found '-1', expected a distance of at least 0",
        "--set '3=1/0': found a division by zero in '1/0', expected a nonzero divisor",
        "--set '²=1': found constraint '²', expected a number from 1 to 6",
    ]


def test_read_names_the_source(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("gsp: 1", encoding="utf-8")
    with pytest.raises(SpecError, match=r"^given:1:1"):
        read(path, name="given")


def test_a_range_is_read_written_and_warned_of():
    text = GOOD.replace("value: 0.10}", "value: 0.10, range: [1/5, sqrt(2)]}")
    reading = read_text(text)
    limits = reading.instance.constraints[1].limits
    assert limits is not None
    assert [str(limit) for limit in limits] == ["0.2", "sqrt(2)"]
    assert loads(dumps(reading.instance)) == reading.instance
    message = "the value 0.1 is outside its range from 0.2 to sqrt(2)"
    assert message in [warning.message for warning in reading.warnings]
    inside = read_text(text.replace("1/5", "1/10"))
    assert not [warning for warning in inside.warnings if "range" in warning.message]


def test_a_tolerance_is_read_and_written():
    instance = loads(GOOD.replace("value: 0.10}", "value: 0.10, tolerance: 1/100}"))
    assert [str(c.tolerance) for c in instance.constraints[:2]] == ["None", "0.01"]
    assert loads(dumps(instance)) == instance


# What was perhaps not meant is pointed out: radians among degrees, lengths out of proportion.


HEXAPOD = instance_files()["dietmaier"].read_text(encoding="utf-8")


def _doubts(old: str = "", new: str = "") -> list[str]:
    assert old in HEXAPOD
    return [mistake.message for mistake in read_text(HEXAPOD.replace(old, new, 1)).doubts]


def _first_point() -> str:
    return HEXAPOD[HEXAPOD.index("point: [") :].partition("]")[0] + "]"


@pytest.mark.parametrize(
    ("number", "message"),
    [
        ("cos(60)", "cos(60) is of 60 radians: for degrees write cosd(60)"),
        ("2*sin( -30.5 )", "sin( -30.5 ) is of 30.5 radians: for degrees write sind(30.5)"),
        ("cosd(60)", None),
        ("cos(pi/3)", None),
        ("cos(60*pi/180)", None),
        ("sin(0)", None),
    ],
)
def test_radians_among_degrees(number: str, message: str | None) -> None:
    assert _doubts(_first_point(), f"point: [{number}, 0.2, 0.1]") == ([message] if message else [])


def test_radians_among_radians_are_meant() -> None:
    text = HEXAPOD.replace(_first_point(), "point: [cos(60), 0.2, 0.1]").replace("deg", "rad")
    assert read_text(text).doubts == ()


def test_lengths_out_of_proportion() -> None:
    (message,) = _doubts(_first_point(), "point: [3e9, 0, 0]")
    assert message.startswith("lengths differ by a factor of ")
    assert "of the base are apart by 3e+09" in message or "of the platform are apart" in message


def test_lines_and_planes_out_of_proportion() -> None:
    text = instance_files()["example-6.8"].read_text(encoding="utf-8")
    far = text.replace("L1: {line: {point: [0, 0, 0]", "L1: {line: {point: [3e9, 0, 7e9]", 1)
    assert far != text
    (doubt,) = read_text(far).doubts
    assert "L1 and" in doubt.message
    assert "of the platform are apart by 3" in doubt.message
    # A point of a line is any of its points.
    along = text.replace("L1: {line: {point: [0, 0, 0]", "L1: {line: {point: [0, 0, 7e9]", 1)
    assert read_text(along).doubts == ()


@pytest.mark.parametrize("path", instance_files().values(), ids=lambda path: path.stem)
def test_shipped_files_leave_no_doubts(path: Path) -> None:
    assert read_text(path.read_text(encoding="utf-8")).doubts == ()


def test_missing_poses_are_put_down_to_proportions() -> None:
    instance = read_text(HEXAPOD.replace(_first_point(), "point: [3e9, 0, 0]", 1)).instance
    result = SimpleNamespace(
        counts=None, verdict="incomplete", account=SimpleNamespace(lost=8), expected=40
    )
    for given, reason in ((instance, "lengths differ by"), (read_text(HEXAPOD).instance, "--seed")):
        with pytest.raises(IncompleteError, match=f"8 of 40 expected .*\n.*{reason}"):
            _complain(SimpleNamespace(**vars(result), instance=given))


def test_solving_says_so_on_stderr(gsp, tmp_path: Path) -> None:
    path = tmp_path / "spec.yaml"
    path.write_text(HEXAPOD.replace(_first_point(), "point: [cos(60), 0.2, 0.1]"))
    assert "warning: " in gsp("measure", path, "--pose", "0,0,0,1,0,0,0").err


def test_primitives_without_a_name_are_different_ones() -> None:
    """They were one primitive, so that no length between them was seen."""
    platform = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [2, 0, 1], [3e9, 0, 0]]
    base = [[k, k * k, -1] for k in range(6)]
    made = hexapod(base, platform, range(1, 7))
    bare = replace(
        made,
        constraints=tuple(replace(r, platform_name="", base_name="") for r in made.constraints),
    )
    assert "lengths differ by a factor of" in out_of_proportion(made)
    assert "lengths differ by a factor of" in out_of_proportion(bare)


# Cranks, slides, shared carriages and values at home in files: read, written, warned of.


BASE = """\
base:
  B1: {point: [100, 0, 0], crank: {centre: [80, 0, 0], axis: [0, 1, 0], range: [-60, 70], MORE}}
  B2: {point: [50, 80, 0], slide: {direction: [0, 0, 2], range: [-20, 30], LESS}}
  B3: {point: [-50, 80, 0], with: B2, cone: {axis: [0, 0, 1], half_angle: 40}}
  B4: {point: [-100, 0, 0], crank: {centre: [-80, 0, 0], axis: [0, -1, 0]}}
  B5: {point: [-50, -80, 0], with: B4}
  B6: {point: [50, -80, 0]}
"""
BASE = BASE.replace("MORE", "tolerance: 0.05, offset: 1.5, scale: -0.5")
BASE = BASE.replace("LESS", "tolerance: 0.01, offset: 2, scale: 0.01")
TEXT = f"""\
gsp: 1
units: {{length: mm, angle: deg}}
platform:
  P1: {{point: [60, 10, 0]}}
  P2: {{point: [40, 50, 0]}}
  P3: {{point: [-40, 50, 0]}}
  P4: {{point: [-60, 10, 0]}}
  P5: {{point: [-40, -50, 0]}}
  P6: {{point: [40, -50, 0]}}
{BASE}constraints:
  - {{distance: [P1, B1], value: home}}
  - {{distance: [P2, B2], value: home}}
  - {{distance: [P3, B3], value: home}}
  - {{distance: [P4, B4], value: 125}}
  - {{distance: [P5, B5], value: home}}
  - {{distance: [P6, B6], value: home, offset: 3, range: [100, 150]}}
home: {{position: [0, 0, 120]}}
"""


def test_what_is_stated_is_read_with_ranges_as_values():
    instance = loads(TEXT)
    assert not read_text(TEXT).warnings
    points = instance.named("base")
    crank, slide = points["B1"].crank, points["B2"].slide
    # A range is of readings: -60 and 70 are 1.5 - 30 and 1.5 + 35.
    assert [x.value for x in crank.limits] == [-28.5, 36.5]
    assert [crank.reading_of(x).value for x in crank.limits] == [-60, 70]
    assert [x.value for x in slide.limits] == [-18.2, 32.3]
    assert (crank.tolerance.value, slide.scale.value) == (0.05, 0.01)
    assert points["B3"].slide == slide
    assert points["B3"].partner == "B2"
    assert points["B5"].crank == points["B4"].crank
    assert points["B6"].drive is None


def test_blanks_and_quotation_marks_change_nothing():
    assert loads(TEXT.replace("axis: [0, 1, 0]", "axis: [ 0, '1', 0]")) == loads(TEXT)


def test_values_at_home_are_the_distances_there_exactly():
    instance = loads(TEXT)
    values = [row.value for row in instance.constraints]
    assert str(values[0]) == "sqrt(16100)"
    assert values[3].value == 125
    # The value is that at home, and its reading is less by the offset.
    assert values[5].value == math.hypot(10, 30, 120)
    assert instance.constraints[5].reading_of(values[5]).value == values[5].value - 3
    at_home = measured(Arrangement.of(instance), np.eye(3), np.array([0, 0, 120.0]))
    np.testing.assert_allclose(at_home, [x.value for x in values], rtol=3e-2)
    np.testing.assert_allclose(
        np.delete(at_home, 3), np.delete([x.value for x in values], 3), rtol=1e-15
    )


def test_what_is_written_is_read_as_the_same():
    instance = loads(TEXT)
    text = dumps(instance)
    assert loads(text) == instance
    assert "with: B2" in text
    assert "crank: {centre: [80, 0, 0], axis: [0, 1, 0], range: [-60, 70], tolerance: 0.05" in text


KINDS = """\
gsp: 1
units: {length: m, angle: UNIT}
platform:
  P: {point: [1, 2, 3]}
  L: {line: {point: [0, 1, 1], direction: [1, 1, 0]}}
  H: {plane: {point: [0, 0, 1], normal: [0, 3, 4]}}
  M: {line: {point: [0, 0, 0], direction: [1, 0, "sqrt(2)"]}}
base:
  P: {point: [0, 0.5, 0]}
  L: {line: {point: [0, 0, 0], direction: [0, 0, 1]}}
  H: {plane: {point: [0, 0, 10], normal: [0, 0, 1]}}
constraints:
  - {distance: [P, L], value: home}
  - {distance: [P, H], value: home}
  - {distance: [H, P], value: home}
  - {distance: [FIRST, L], value: home}
  - {angle: [M, L], value: home}
  - {angle: [L, H], value: home}
home: {HOME}
"""
HOMES = {
    "quaternion": "position: [0.1, 0.2, 0.3], quaternion: [1, 2, 0.5, -1]",
    "euler": "position: [0.1, 0.2, 0.3], rx: 30, rz: 0.7, euler: ZYX",
    "fixed": "position: [0.1, 0.2, 0.3], rx: 0.3, ry: -0.4, rz: 0.5, euler: zxy",
}


@pytest.mark.parametrize("home", HOMES)
@pytest.mark.parametrize("first", ["L", "M"])
@pytest.mark.parametrize("unit", ["deg", "rad"])
def test_values_of_all_kinds_are_what_is_measured(home, first, unit):
    changes = {"UNIT": unit, "FIRST": first, "HOME": HOMES[home]}
    text = KINDS
    for word, meant in changes.items():
        text = text.replace(word, meant, 1)
    instance = loads(text)
    arrangement = Arrangement.of(instance)
    found = measured(arrangement, instance.home.R(arrangement.in_radians), instance.home.T)
    found[:4] = np.abs(found[:4])
    np.testing.assert_allclose(arrangement.targets, found, rtol=1e-14)
    # Decimals and roots of fractions: short enough to be read again.
    assert all(len(str(row.value)) <= 110 for row in instance.constraints)
    assert loads(dumps(instance)) == instance


def test_home_on_the_other_side_is_a_mistake():
    text = KINDS.replace("UNIT", "deg").replace("FIRST", "L")
    text = text.replace("[P, H], value: home", "[P, H], value: home, side: SIDE").replace(
        "HOME", HOMES["euler"]
    )
    assert loads(text.replace("SIDE", "negative"))
    with pytest.raises(
        SpecError, match=r"constraints\[2\].value: found 'home', expected a distance"
    ):
        loads(text.replace("SIDE", "positive"))


def test_values_at_home_need_a_home():
    text = TEXT.replace("home: {position: [0, 0, 120]}\n", "")
    with pytest.raises(SpecError) as caught:
        loads(text, name="f")
    first = str(caught.value.mistakes[0])
    assert first == (
        "f:18:33: constraints[1].value: found home, but the file states no home pose: "
        "home: {position: [x, y, z]}"
    )
    assert len(caught.value.mistakes) == 5
    # Only the mistake in the home pose is reported.
    with pytest.raises(SpecError) as caught:
        loads(TEXT.replace("position: [0, 0, 120]", "position: [0, 120]"), name="f")
    assert len(caught.value.mistakes) == 1


def test_doubtful_drives_are_warned_of():
    text = TEXT.replace("centre: [80, 0, 0]", "centre: [100, 7, 0]").replace("[-20, 30]", "[5, 30]")
    warnings = [str(one) for one in read_text(text, name="f").warnings]
    assert warnings == [
        "f:11:35: base.B1.crank: the point lies on the axis of its crank, which does not move it",
        "f:12:65: base.B2.slide.range: the stated point, at -200/101, is outside the range from 5 "
        "to 30",
    ]


MASSES = """\
dynamics:
  platform: {mass: 1, centre: [0, 0, 0], inertia: [1, 1, 1, 0, 0, 0]}
  arms: [{mass: 0.05, centre: 8, inertia: 2}, {mass: 0.04, centre: -3}]
  carriages: {mass: 0.4}
  drives: {inertia: 30, stiffness: [4e3, 1e5, 4e3, 1e5]}
"""


def test_masses_of_arms_and_carriages_are_read_and_written():
    instance = loads(TEXT + MASSES)
    dynamics = instance.dynamics
    assert [arm.centre.value for arm in dynamics.arms] == [8, -3]
    assert dynamics.arms[1].inertia.value == 0
    assert dynamics.carriages[0].mass.value == 0.4
    assert loads(dumps(instance)) == instance


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (", {mass: 0.04, centre: -3}]", "]*", ""),
        (
            "[{mass: 0.05",
            "[{mass: 0.05, centre: 1}, {mass: 0.05",
            "arms: found 3, expected one for all, or 2",
        ),
        ("mass: 0.04", "mass: 0", r"arms\[2\].mass: found 0, expected a mass above 0"),
        ("inertia: 2}", "inertia: -2}", r"arms\[1\].inertia: found -2, expected an inertia of at"),
        ("{mass: 0.4}", "{mass: -1}", "carriages.mass: found -1, expected a mass above 0"),
        (
            "[4e3, 1e5, 4e3, 1e5]",
            "[4e3, 1e5, 4e3, 1e5, 1, 1]",
            "found 6 numbers, expected one for all, or 4",
        ),
    ],
)
def test_mistakes_in_masses_of_drives(old, new, message):
    text = (TEXT + MASSES).replace(old, new.rstrip("*"), 1)
    if not message:
        assert len(loads(text).dynamics.arms) == 1
        return
    with pytest.raises(SpecError, match=message):
        loads(text)


def test_arms_on_the_platform_have_no_mass_of_their_own():
    text = TEXT.replace(
        "P4: {point: [-60, 10, 0]}",
        "P4: {point: [-60, 10, 0], crank: {centre: [0, 0, 0], axis: [0, 0, 1]}}",
    )
    text = text.replace(
        "B4: {point: [-100, 0, 0], crank: {centre: [-80, 0, 0], axis: [0, -1, 0]}}",
        "B4: {point: [-100, 0, 0]}",
    ).replace(", with: B4", "")
    assert loads(text)
    masses = MASSES.replace(", {mass: 0.04, centre: -3}]", "]").replace(
        "[4e3, 1e5, 4e3, 1e5]", "4e3"
    )
    with pytest.raises(SpecError, match=r"found masses, but crank.P4 is on the platform: add"):
        loads(text + masses)


# Frames in instance files: read, written, and every mistake in its place.


FRAMES_GOOD = gspcli.dumps(gspcli.example("workspace-study"))
STATED = (
    "frames: {tool: {point: [0, 0, 1/3], rx: 1, ry: 0, rz: sqrt(2), euler: ZYX}, "
    "work: {point: [1, 2, 3], quaternion: [1, 0, 0, 1]}}"
)


def test_frames_are_written_as_they_are_read():
    found = gspcli.loads(FRAMES_GOOD + STATED)
    assert str(found.frames.tool.position[2]) == "1/3"
    assert found.frames.tool.euler == "ZYX"
    assert gspcli.dumps(found).splitlines()[-1] == STATED
    assert gspcli.loads(gspcli.dumps(found)) == found


@pytest.mark.parametrize(
    "text", ["frames: {tool: {point: [0, 0, 5]}}", "frames: {work: {point: [0, 0, 5]}}"]
)
def test_one_frame_alone(text):
    found = gspcli.loads(FRAMES_GOOD + text)
    assert None in (found.frames.tool, found.frames.work)
    assert gspcli.dumps(found).splitlines()[-1] == text.replace(
        "]}", "], quaternion: [1, 0, 0, 0]}"
    )
    assert gspcli.loads(gspcli.dumps(found)) == found
    assert gspcli.loads(FRAMES_GOOD + "frames: {}").frames is None


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("frames: {tol: {point: [0, 0, 0]}}", "10", "found the unknown key 'tol'"),
        ("frames: {tool: {pont: [0, 0, 0]}}", "17", "did you mean point?"),
        ("frames: {tool: {quaternion: [1, 0, 0, 0]}}", "16", "the key point is missing"),
        ("frames: {tool: {point: [0, 0]}}", "24", "expected three numbers"),
        ("frames: {work: {point: [0, 0, 0], rx: 3}}", "39", "found rx without euler"),
        ("frames: {work: {point: [0, 0, 0], rx: 3, euler: XZX}}", "49", "three different axes"),
        ("frames: {work: {point: [0, 0, 0], quaternion: [0, 0, 0, 0]}}", "47", "any but zero"),
        ("frames: 3", "9", "expected a mapping with tool and work"),
    ],
)
def test_mistakes_have_line_and_column(text, place, message):
    with pytest.raises(gspcli.SpecError) as error:
        gspcli.loads(FRAMES_GOOD + text, name="f")
    line = FRAMES_GOOD.count("\n") + 1
    assert f"f:{line}:{place}: frames" in str(error.value)
    assert message in str(error.value)


# Machines with arms or rails from the numbers of a drawing.


RADII = "base=80,12 platform=55,10"
MACHINES = {
    "level arms": ("rotary", f"{RADII} horn=24 rod=130", 6),
    "rods from height": ("rotary", f"{RADII} horn=24 height=120 axis-angle=7.5", 6),
    "raised arms": ("rotary", f"{RADII} horn=24 rod=130 height=110 axis-angle=-20 horns=in", 6),
    "rails": ("linear", f"{RADII} rod=200 tilt=25 range=-40:70 unit=cm", 6),
    "rails, height": ("linear", f"{RADII} height=-150", 6),
    "delta": ("linear", "base=200,0 platform=50,30 rod=250 rails=3", 3),
}


@pytest.mark.parametrize("name", MACHINES)
def test_machines_are_at_home_with_all_drives_at_zero(name):
    sort, words, count = MACHINES[name]
    reading = read_text(motor_file(sort, words.split()))
    assert not reading.warnings
    instance = reading.instance
    drives = Machine.of(instance)
    assert drives.count == count
    R, T = instance.home.R(1.0), instance.home.T
    q = drives.inverse(R, T)
    np.testing.assert_allclose(q, 0, atol=1e-10 * drives.rods[0])
    # All motors are alike: the platform rises without turning when all move by the same.
    rise = drives.inverse(R, T + np.array([0, 0, 1e-3]))
    np.testing.assert_allclose(rise, rise[0], rtol=1e-6)
    assert rise[0] > 0
    gains = drives.gains(R, T, q)
    np.testing.assert_allclose(gains, gains[0], rtol=1e-9)


def test_the_numbers_are_those_of_the_drawing():
    instance = read_text(motor_file("rotary", MACHINES["raised arms"][1].split())).instance
    drives = Machine.of(instance)
    points = drives.points(np.zeros(6))
    np.testing.assert_allclose(drives.arms, 24)
    np.testing.assert_allclose(drives.rods, 130)
    for row in instance.constraints:
        np.testing.assert_allclose(
            np.linalg.norm(row.base.crank.centre[0].value + 1j * row.base.crank.centre[1].value), 80
        )
        np.testing.assert_allclose(np.linalg.norm(row.platform.point), 55)
    lengths = np.linalg.norm(
        instance.home.T + [row.platform.point for row in instance.constraints] - points, axis=1
    )
    np.testing.assert_allclose(lengths, 130, rtol=1e-12)
    assert np.degrees(drives.high).tolist() == pytest.approx([60] * 6)


def test_rods_of_a_pair_of_a_delta_are_parallel_and_share_a_carriage():
    instance = read_text(motor_file("linear", MACHINES["delta"][1].split())).instance
    drives = Machine.of(instance)
    _, _, r = drives.ends(np.eye(3), instance.home.T, np.zeros(3))
    for k in range(3):
        first, second = drives.users(k)
        np.testing.assert_allclose(r[first], r[second], atol=1e-12)
    assert instance.home.T[2] < 0


@pytest.mark.parametrize(
    ("sort", "words", "message"),
    [
        ("rotary", "base=80 horn", "found 'horn', expected KEY=NUMBER with base, "),
        ("rotary", "base=80,12 radius=3", "found 'radius=3'"),
        ("rotary", "base=80 base=81", "found base twice"),
        ("rotary", "base=80,12", "platform and horn missing"),
        ("rotary", "base=80 platform=5,5 horn=24 rod=9", "base: found '80', expected RADIUS,HALF_"),
        ("rotary", f"{RADII} horn=24", "found neither rod nor height"),
        ("rotary", f"{RADII} horn=24 rod=x", "rod: found 'x'"),
        ("rotary", f"{RADII} horn=-24 rod=130", "horn: found -24, expected a length above 0"),
        ("rotary", f"{RADII} horn=24 rod=20", "rod: found 20, expected more than 42.9247"),
        ("rotary", f"{RADII} horn=24 rod=130 height=300", "rod 130 does not join arm and platform"),
        ("rotary", f"{RADII} horn=24 rod=130 range=60", "range: found '60', expected LOW:HIGH"),
        ("rotary", f"{RADII} horn=24 rod=130 range=60:-60", "range: found '60:-60'"),
        ("rotary", f"{RADII} horn=24 rod=130 horns=up", "horns: found 'up', expected out or in"),
        ("linear", f"{RADII} rod=130 height=3", "found rod and height, expected one of them"),
        ("linear", "base=8,60 platform=5,0 rod=30", "expected a half angle"),
    ],
)
def test_mistakes_of_a_drawing(sort, words, message):
    with pytest.raises(GspError, match=message):
        motor_file(sort, words.split())


def test_angles_of_a_drawing_are_exact():
    """The file had the fraction 11111000000000000001/…, and the machine was not symmetric."""
    text = motor_file("rotary", ["base=80,11.111", "platform=55,10", "horn=24", "rod=130"])
    assert "80*cosd(11.111)" in text
    assert "80*cosd(108.889)" in text
    result = solve(read_text(text).instance)
    assert result.verdict == "complete"
    words = ["base=80,5*sqrt(2)", "platform=55,10", "horn=24", "rod=130", "axis-angle=sqrt(3)"]
    text = motor_file("rotary", words)
    assert "cosd(120 - (5*sqrt(2)))" in text
    assert "cosd(30 - (sqrt(3)))" in text


# Other values for the constraints of an instance: texts, and numbers of all kinds.


@pytest.fixture(scope="module")
def platform() -> Instance:
    axes = [Line([k, 0, 1], [1, k, 2]) for k in range(3)]
    rows = [distance(Point([k, k * k, 1]), Point([1, k, k]), k + 1) for k in range(5)]
    return instance([*rows, angle(axes[1], axes[2], 60)])


def values(made: Instance) -> list[str]:
    return [str(row.value) for row in made.constraints]


@pytest.mark.parametrize(
    ("given", "exact"),
    [
        (5, "5"),
        (0.1, "0.1"),
        (np.float32(0.5), "0.5"),
        (np.int64(7), "7"),
        (Fraction(1, 3), "1/3"),
        (Decimal("0.25"), "0.25"),
        ("sqrt(2)", "sqrt(2)"),
    ],
)
def test_any_number_is_taken_exactly(platform: Instance, given: Any, exact: str) -> None:
    assert values(set_values(platform, {2: given})) == ["1", exact, "3", "4", "5", "60"]
    all_six = set_values(platform, [given, 2, 3, 4, 5, 60])
    assert values(all_six)[0] == exact
    assert all_six == set_values(platform, {1: given})


def test_texts_arrays_and_mappings_agree(platform: Instance) -> None:
    one = set_values(platform, ["1=2", "6 = 45"])
    assert (
        one
        == set_values(platform, {1: 2, 6: "45"})
        == set_values(platform, {np.int64(6): 45, 1: 2})
    )
    assert one == set_values(platform, np.array([2, 2, 3, 4, 5, 45]))
    assert set_values(platform, "1=2") == set_values(platform, {1: 2})
    assert set_values(platform, {}) == set_values(platform, []) == platform


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({7: 1}, r"settings\[7\]: found constraint 7, expected a number from 1 to 6"),
        ({0: 1}, r"settings\[0\]: found constraint 0, expected a number from 1 to 6"),
        ({True: 1}, r"settings\[True\]: found constraint True, expected a number from 1 to 6"),
        ({"1": 1}, r"settings\['1'\]: found constraint '1', expected a number from 1 to 6"),
        ({1.5: 1}, r"settings\[1.5\]: found constraint 1.5, expected a number from 1 to 6"),
        ({2: float("nan")}, r"settings\[2\]: found nan, expected a finite number"),
        ({2: None}, r"settings\[2\]: found a NoneType, expected a finite number"),
        ({2: "1/0"}, r"settings\[2\]: found a division by zero"),
        ({2: -1}, r"settings\[2\]: found -1, expected a distance of at least 0"),
        ({6: 181}, r"settings\[6\]: found 181, expected an angle of LL from 0 to 180"),
        ([1, 2, 3, 4, -5, 60], r"settings\[4\]: found -5, expected a distance of at least 0"),
        ([1, 2, 3], r"settings: found 3 values, expected 6, or \{1: 5.2\} for some"),
        (5.2, r"settings: found a float, expected values by number, as \{1: 5.2\}"),
        (np.ones((6, 6)), r"settings\[0\]: found a ndarray, expected a finite number"),
    ],
)
def test_mistakes_name_the_argument_and_the_number(
    platform: Instance, settings: Any, message: str
) -> None:
    with pytest.raises(ArgumentError, match=f"^{message}"):
        set_values(platform, settings)


# Diameters of legs and hulls of bodies in files: read, written, and their mistakes.


SHAPES_TEXT = instance_files()["workspace-study"].read_text(encoding="utf-8").rstrip() + "\n"
PLATE = "[[100, 0, 0], [-50, 50*sqrt(3), 0], [-50, -50*sqrt(3), 1/3]]"


def test_what_is_stated_is_read_and_written_exactly():
    read = loads(f"{SHAPES_TEXT}shapes: {{diameter: 20}}\n")
    assert read.shapes == Shapes(20)
    assert read.shapes.diameters == (Number.of(20),)
    assert loads(dumps(read)) == read
    text = f"{SHAPES_TEXT}shapes:\n  diameter: [1, 2, 3, 4, 0.1, 1/3]\n  platform: {PLATE}\n"
    text += "  base: [[0, 0, -0.1]]\n  near_joint: sqrt(2)\n"
    read = loads(text)
    assert [x.value for x in read.shapes.diameters] == [1, 2, 3, 4, 0.1, 1 / 3]
    assert (len(read.shapes.platform), len(read.shapes.base)) == (3, 1)
    assert loads(dumps(read)) == read
    assert replace(read, shapes=None) == example("workspace-study")


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("{}", "46:9: shapes: the key diameter is missing"),
        (
            "20",
            "shapes: found '20', expected a mapping with diameter, platform, base and near_joint",
        ),
        ("{diameter: -1}", "46:20: shapes.diameter: found -1, expected a diameter of at least 0"),
        ("{diameter: []}", "found 0 diameters, expected 6, one for each leg, or one for all"),
        ("{diameter: [1, 2]}", "found 2 diameters, expected 6, one for each leg, or one for all"),
        (
            "{diameter: [1, 2, 3, -4, 5, 6]}",
            "46:30: shapes.diameter[4]: found -4, expected a diameter of at least 0",
        ),
        ("{diameter: wide}", "46:20: shapes.diameter: found 'wide', expected a number"),
        ("{diameter: nan}", "shapes.diameter: found 'nan'"),
        ("{diameter: 1e300}", "found '1e300'"),
        ("{diameter: 1, near_joint: -2}", "shapes.near_joint: found -2, expected a length"),
        ("{diameter: 1, platform: []}", "found no point, expected a list of points"),
        ("{diameter: 1, platform: [1, 2, 3]}", "expected three numbers [x, y, z]"),
        ("{diameter: 1, base: [[1, 2]]}", "46:30: shapes.base[1]: found 2 entries, expected three"),
        (
            "{diameter: 1, base: [[1, 2, 3]]}",
            "46:29: shapes.base: found the hull of the base without near_joint, expected both",
        ),
        ("{diametre: 1}", "found the unknown key 'diametre', expected diameter, platform, base or"),
    ],
)
def test_mistakes_are_told_with_their_places(section, message):
    lines = len(SHAPES_TEXT.splitlines()) + 1
    with pytest.raises(SpecError) as error:
        loads(f"{SHAPES_TEXT}shapes: {section}\n")
    assert message.replace("46:", f"{lines}:") in str(error.value)
    assert len(str(error.value).splitlines()) <= 3


def test_shapes_of_a_platform_without_legs():
    planes = instance_files()["six-planes"].read_text(encoding="utf-8").rstrip()
    with pytest.raises(SpecError, match="no distance of two points: only legs have a diameter"):
        loads(f"{planes}\nshapes: {{diameter: 1}}\n")


def test_gaps_do_not_depend_on_the_frames_in_which_poses_are_expressed():
    shapes = Shapes(20, [[150, 0, 10], [-80, 120, 5]], [[0, 0, -20], [300, 0, -5]], 30)
    frames = Frames(Frame([10, 20, 30], euler="ZYX", angles=[90, 0, 90]), Frame([1, 2, 3]))
    given = replace(example("workspace-study"), shapes=shapes, frames=frames)
    R, T = rotation_from_euler("ZYX", np.array([0.3, -0.2, 0.1])), np.array([5.0, 3.0, 390.0])
    frame = PoseFrame.of(given, pivot=(7, 8, 9))
    moved = gaps(expressed_instance(given, pivot=(7, 8, 9)), *frame.from_platform(R, T))
    assert moved.pairs == gaps(given, R, T).pairs
    assert moved.values == pytest.approx(gaps(given, R, T).values, abs=1e-8)
