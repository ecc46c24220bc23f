"""Every mistake that a person can make in an instance file, at its place."""

import io
import json
from pathlib import Path

import pytest

from gspcli.errors import SpecError
from gspcli.geometry.instance import AngleUnit, Side
from gspcli.geometry.primitives import Line, Plane, Point
from gspcli.spec import dumps, load, loads, read, read_text, set_values, sharing
from gspcli.spec.document import MAX_BYTES

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
    assert sharing(instance) == (
        {"P1": [1, 2, 3], "L1": [4, 5]},
        {"L4": [2, 4], "H4": [3, 5, 6]},
    )


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
