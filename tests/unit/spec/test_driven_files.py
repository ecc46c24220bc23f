"""Cranks, slides, shared carriages and values at home in files: read, written, warned of."""

import math

import numpy as np
import pytest

from gspcli.errors import SpecError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import measured
from gspcli.spec import dumps, loads, read_text

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
