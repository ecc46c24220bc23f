"""Offsets and scales of constraints are honoured by all that takes or tells values.

Each test compares a platform with some with the same one whose values and ranges are corrected by
hand, and has at least one offset or scale that would be seen.
"""

from __future__ import annotations

import json
import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import gspcli
from gspcli.cli.main import run
from gspcli.errors import ArgumentError, SpecError
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.machine import Machine
from gspcli.geometry.numbers import Number
from gspcli.geometry.readings import factors, offsets, readings_of, values_of
from gspcli.motion.paths.between import limit_events
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.resources import data_path

#: A leg that reads 0.02 too little, one that reads from a switch at 0.4, one without an offset.
SHIFTS = {0: "0.02", 1: "0.4", 3: "-sqrt(2)/100"}
#: One that reads 0.4 in units of 0.8, and one that reads one per cent too little.
SCALES = {1: "-0.2", 4: "0.01", 5: "sqrt(2)/1000"}


def _added() -> Instance:
    return gspcli.load(data_path("platforms", "rubin-m2.yaml"))


def _offset() -> Instance:
    """The same platform by its readings."""
    rows = list(_added().constraints)
    for k, text in SHIFTS.items():
        rows[k] = replace(rows[k], offset=Number.of(text))
    for k, text in SCALES.items():
        rows[k] = replace(rows[k], scale=Number.of(text))
    return replace(_added(), constraints=tuple(rows))


def test_a_file_reads_back_and_states_readings():
    text = gspcli.dumps(_offset())
    assert "value: 0.473, range: [0.4589, 0.4871], offset: 0.02" in text
    again = gspcli.loads(text)
    assert again.constraints[0].value.fraction == Fraction("0.493")
    assert again == gspcli.loads(gspcli.dumps(again))
    assert again.constraints[1].value.fraction == Fraction("0.493")
    assert "offset: 0.4, scale: -0.2" in text
    for one, other in zip(again.constraints, _added().constraints, strict=True):
        assert one.value.value == pytest.approx(other.value.value, abs=1e-15)
        assert [x.value for x in one.limits] == pytest.approx([x.value for x in other.limits])


def test_solve_and_certify():
    one, other = gspcli.solve(_offset()), gspcli.solve(_added())
    assert len(one.solutions) == len(other.solutions)
    assert np.abs(one.T - other.T).max() < 1e-9
    assert gspcli.certify(_offset(), one.R, one.T).certified == len(one.R)
    assert gspcli.certify(_misread(), one.R, one.T).certified == 0


def _misread() -> Instance:
    """The readings taken for values."""
    given = _offset()
    rows = tuple(
        replace(row, value=row.reading_of(row.value), offset=None, scale=None)
        for row in given.constraints
    )
    return replace(given, constraints=rows)


def test_measure_is_the_inverse_of_solve():
    given = _offset()
    result = gspcli.solve(given)
    at = result.real
    measured = gspcli.measure(given, result.R[at].real, result.T[at].real)
    stated = [row.reading_of(row.value).value for row in given.constraints]
    assert measured == pytest.approx(np.tile(stated, (at.sum(), 1)), abs=1e-9)
    plain = values_at(given, result.R[at].real, result.T[at].real)
    assert np.abs(plain - measured * factors(given) - offsets(given)).max() < 1e-14
    assert factors(given) == pytest.approx([1, 0.8, 1, 1, 1.01, 1 + 2**0.5 / 1000])


def test_values_of_batches_and_settings_are_readings():
    given, added = _offset(), _added()
    readings = np.array([row.reading_of(row.value).value for row in given.constraints])
    rows = readings + np.linspace(0, 0.005, 3)[:, None]
    one = gspcli.solve_batch(given, rows)
    other = gspcli.solve_batch(added, values_of(given, rows))
    assert np.array_equal(np.nan_to_num(one.T), np.nan_to_num(other.T))
    assert np.abs(readings_of(given, values_of(given, rows)) - rows).max() < 1e-15
    for settings in ({1: "0.48"}, ["1=0.48"]):
        changed = gspcli.set_values(given, settings)
        assert changed.constraints[0].value.fraction == Fraction("0.5")
    # A reading may be negative where the distance is not.
    assert gspcli.set_values(given, {2: -0.01}).constraints[1].value.value == pytest.approx(0.392)
    with pytest.raises(ArgumentError, match="at least 0"):
        gspcli.set_values(given, {1: -0.03})


def test_track_follows_readings_and_its_ranges():
    given, added = _offset(), _added()
    readings = np.array([row.reading_of(row.value).value for row in given.constraints])
    rows = np.stack((readings, readings + 0.02))
    one = gspcli.track(given, rows, modes=[1], certify=False)
    other = gspcli.track(added, values_of(given, rows), modes=[1], certify=False)
    assert np.abs(one.T - other.T).max() < 1e-12
    events = [(e.constraint, e.leaves, e.low) for e in limit_events(one)]
    assert events == [(e.constraint, e.leaves, e.low) for e in limit_events(other)]
    assert {k for k, _, _ in events} == set(range(6))
    machine = Machine.of(given)
    assert not machine.outside(machine.read(readings, {})).any()


@pytest.mark.parametrize(
    "arguments",
    [
        ("count", "{}"),
        ("analyze", "{}", "--mode", "1", "--format", "csv", "--part", "jacobian"),
        ("export", "{}", "--to", "mjcf"),
        ("workspace", "{}", "--format", "json"),
    ],
    ids=lambda arguments: arguments[0],
)
def test_commands_agree(arguments, tmp_path, capsys):
    shown = []
    for instance in (_offset(), _added()):
        # The same decimal numbers, so that what is written is the same, too.
        rows = tuple(
            replace(row, value=Number.of(round(row.value.value, 9)), limits=None)
            if row.limits is None or arguments[0] != "workspace"
            else row
            for row in instance.constraints
        )
        path = tmp_path / "platform.yaml"
        path.write_text(gspcli.dumps(replace(instance, constraints=rows)))
        code = run([part.format(path) for part in arguments])
        # A model stores the instance itself, whose offsets differ.
        shown.append((code, re.sub(r'<text name="gsp.*', "", capsys.readouterr().out)))
    assert shown[0][0] == 0
    assert shown[0] == shown[1]


def test_clearance_tells_readings(tmp_path, capsys):
    path = tmp_path / "platform.yaml"
    path.write_text(gspcli.dumps(_offset()))
    assert run(["clearance", str(path), "--mode", "1", "--format", "json"]) == 0
    (mode,) = json.loads(capsys.readouterr().out)["modes"]
    there = gspcli.measure(_offset(), mode["R"], mode["T"])
    assert mode["values"] == pytest.approx(there, abs=1e-6)


@pytest.mark.parametrize(
    ("number", "as_read", "as_added"),
    [(1, (0.46, 0.48), (0.48, 0.5)), (5, (0.3, 0.6), (0.303, 0.606))],
)
def test_scan_tells_readings(number, as_read, as_added, tmp_path, capsys):
    outputs = []
    for instance, ends in ((_offset(), as_read), (_added(), as_added)):
        path = tmp_path / "platform.yaml"
        path.write_text(gspcli.dumps(instance))
        asked = f"{number}={ends[0]}:{ends[1]}:3"
        for more in ([], ["--folds"]):
            assert run(["scan", str(path), "--vary", asked, "--format", "csv", *more]) == 0
            outputs.append(capsys.readouterr().out.splitlines()[1:])
    nodes, folds, same_nodes, same_folds = ([row.split(",") for row in out] for out in outputs)
    assert [row[1] for row in nodes] == [row[1] for row in same_nodes]
    assert [float(row[0]) for row in nodes] == pytest.approx(np.linspace(*as_read, 3))
    assert len(folds) == len(same_folds)
    meant = np.interp([float(row[0]) for row in folds], as_read, as_added)
    assert meant == pytest.approx([float(row[0]) for row in same_folds], abs=1e-8)


def test_rates_of_readings_are_scaled():
    from gspcli.dynamics.motion_files import motion_of_values

    given = replace(gspcli.load(data_path("platforms", "rubin-m2.yaml")), dynamics=MASSES)
    scaled = replace(
        given, constraints=tuple(replace(row, scale=Number.of("0.25")) for row in given.constraints)
    )
    R, T, rates = np.eye(3)[None], np.zeros((1, 3)), np.arange(6.0)[None]
    one = motion_of_values(scaled, R, T, (rates, 2 * rates))
    other = motion_of_values(given, R, T, (1.25 * rates, 2.5 * rates))
    assert np.abs(one.twists - other.twists).max() < 1e-12
    assert np.abs(one.accelerations - other.accelerations).max() < 1e-9
    assert np.abs(other.twists).max() > 1


MASSES = gspcli.Dynamics(gspcli.RigidBody(12, [0, 0, 0], [1, 1, 1, 0, 0, 0]))

PLANE = """\
gsp: 1
units: {length: mm, angle: deg}
platform: {P: {point: [0, 0, 0]}, Q: {point: [1, 0, 0]}, R: {point: [0, 1, 0]}}
base:
  H: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
  I: {plane: {point: [0, 0, 0], normal: [0, 1, 0]}}
  J: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}
constraints:
  - {distance: [P, H], value: 5, offset: 0.1, side: negative}
  - {distance: [Q, H], value: -0.02, offset: 0.1, side: positive}
  - {distance: [R, H], value: 1}
  - {distance: [P, I], value: 1}
  - {distance: [Q, I], value: 1}
  - {distance: [P, J], value: 1}
"""


def test_an_offset_of_a_plane_is_added_to_the_signed_distance():
    given = gspcli.loads(PLANE)
    assert given.constraints[0].value.fraction == Fraction("4.9")
    assert given.constraints[0].side is Side.NEGATIVE
    assert given.constraints[1].value.fraction == Fraction("0.08")
    assert gspcli.loads(gspcli.dumps(given)) == given
    assert gspcli.measure(given, np.eye(3), [0, 0, -4.9])[0] == pytest.approx(-5)
    signed, unsigned = offsets(given), offsets(given, signed=False)
    assert signed[:2].tolist() == [0.1, 0.1]
    assert unsigned[:2].tolist() == [-0.1, 0.1]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("offset: 0.1, side: positive", "offset: 0.1", "expected one only with a side"),
        (
            "value: 1}\n  - {distance: [P, I]",
            "value: 1, scale: 1.002}\n  - {distance: [P, I]",
            r"11:41: constraints\[3\].scale: found '1.002', expected a number between -1 and 1",
        ),
        ("value: -0.02", "value: -0.2, scale: 0.5", "'-0.2' with offset 0.1 and scale 0.5, exp"),
        ("value: -0.02", "value: -0.2", "found '-0.2' with offset 0.1, expected a distance"),
        ("offset: 0.1, side: neg", "offset: x, side: neg", "x"),
    ],
)
def test_wrong_offsets_are_refused(old, new, message):
    with pytest.raises(SpecError, match=message):
        gspcli.loads(PLANE.replace(old, new))


def test_offsets_of_python_objects():
    point = gspcli.Point([0, 0, 0])
    row = gspcli.distance(point, gspcli.Point([1, 0, 0]), 0.1, range=(0, 1), offset="0.2")
    assert (row.value.fraction, row.offset.fraction) == (Fraction(3, 10), Fraction(1, 5))
    assert [x.fraction for x in row.limits] == [Fraction(1, 5), Fraction(6, 5)]
    row = gspcli.distance(point, gspcli.Point([1, 0, 0]), 2, range=(0, 1), offset=1, scale="0.5")
    assert (row.value.fraction, row.limits[0].fraction) == (4, 1)
    for wrong in ({"offset": "nothing"}, {"scale": "nothing"}, {"scale": -1}):
        with pytest.raises(ArgumentError, match=next(iter(wrong))):
            gspcli.distance(point, point, 1, **wrong)
