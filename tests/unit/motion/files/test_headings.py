"""Tables of other programs mean what ours mean, or the error says what to write."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import gspcli
from gspcli.calibration.data_files import read_measurements
from gspcli.dynamics.motion_files import read_rows
from gspcli.errors import SpecError
from gspcli.geometry.euler import rotation_from_euler
from gspcli.motion import PoseFormat, read_poses, read_values
from gspcli.motion.files.column_units import FileUnits
from gspcli.motion.files.headings import Heading
from gspcli.resources import data_path

MILLIMETRES = PoseFormat(in_radians=np.pi / 180, length="mm")
NUMBERS = np.array([[1.5, -2.25, 300.0, 10.0, 20.0, 30.0], [0.5, 0.0, 310.0, 0.0, -5.0, 2.5]])
TURNED = rotation_from_euler("ZYX", NUMBERS[:, 3:] * np.pi / 180)


def table(heading, rows=NUMBERS, delimiter=",", comma="."):
    lines = [delimiter.join(repr(float(cell)).replace(".", comma) for cell in row) for row in rows]
    return "\n".join([heading, *lines]) + "\n"


@pytest.mark.parametrize(
    "text",
    [
        table("X,Y,Z,Roll,Pitch,Yaw"),
        table("X [mm],Y [mm],Z [mm],Roll [deg],Pitch [deg],Yaw [deg]"),
        table("x(mm),y(mm),z(mm),roll(°),pitch(°),yaw(°)"),
        table("Pos_X;Pos_Y;Pos_Z;ROLL;PITCH;YAW", delimiter=";", comma=","),
        "sep=;\n" + table("X [mm];Y [mm];Z [mm];Roll;Pitch;Yaw", delimiter=";", comma=","),
        table("position x\ty-position\tpz\troll\tpitch\tyaw", delimiter="\t", comma=","),
        table("x [m],y [cm],z [metres],roll,pitch,yaw", NUMBERS * [1e-3, 0.1, 1e-3, 1, 1, 1]),
        table(
            "x,y,z,Roll [rad],Pitch [mrad],Yaw [radians]",
            NUMBERS * [1, 1, 1, np.pi / 180, np.pi / 0.18, np.pi / 180],
        ),
    ],
)
def test_poses_of_other_programs(text):
    poses = read_poses(text, "p.csv", MILLIMETRES)
    assert np.allclose(poses.T, NUMBERS[:, :3], rtol=1e-14)
    assert np.allclose(poses.R, TURNED, atol=1e-14)


def test_the_order_that_is_said_counts_for_roll_pitch_yaw_too():
    form = PoseFormat("xzy", in_radians=np.pi / 180)
    poses = read_poses(table("x,y,z,roll,pitch,yaw"), "p.csv", form)
    expected = rotation_from_euler("xzy", NUMBERS[:, 3:] * np.pi / 180)
    assert np.allclose(poses.R, expected, atol=1e-14)


@pytest.mark.parametrize(
    "heading",
    ["L1,L2,L3,L4,L5,L6", "Leg 1,leg_2,Leg-3,leg4,LEG 5,leg 6", "Length 1 [mm],length2,3,4,5,6"],
)
def test_legs(heading):
    hexapod = gspcli.load(data_path("platforms", "simscape-hexapod.yaml"))
    rows = np.arange(12.0).reshape(2, 6) + 40
    values = read_values(table(heading, rows), "v.csv", hexapod, PoseFormat(length="mm")).values
    expected = read_values(table("1,2,3,4,5,6", rows), "v.csv", hexapod, PoseFormat()).values
    assert np.array_equal(values, expected)


def test_legs_in_another_unit_and_times():
    hexapod = gspcli.load(data_path("platforms", "simscape-hexapod.yaml"))
    form = PoseFormat(length=hexapod.units.length)
    factor = FileUnits(hexapod.units.length).factor("3", "in")
    found = read_values("Time [ms],L3 [in]\n0,2\n500,3\n", "v.csv", hexapod, form)
    assert found.t.tolist() == [0, 0.5]
    assert found.values[:, 2] == pytest.approx([2 * factor, 3 * factor], rel=1e-14)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,y,z,A,B,C,U,V,W\n0,0,0,0,0,0,0,0,0\n", "A B C and U V W may both be turns"),
        ("x,y,z,q0,q1,q2,q3\n0,0,0,1,0,0,0\n", "do not say which is the scalar: write qw qx qy qz"),
        (table("x,y,z,alpha,beta,gamma"), "do not say about which axes: write rx ry rz"),
        (table("x,y,z,rx,ry,rz"), "found rx ry rz without the order of the axes"),
        (table("x,y,z,roll,rx,yaw"), "found the column 'rx' twice"),
        (
            table("x [kg],y,z,roll,pitch,yaw"),
            "p.csv:1:1: found the unit 'kg' of the column x, a length",
        ),
        ("x;y;z;roll;pitch;yaw\n1,5;0;0;0;0;2.5\n", "decimals are written with a point"),
        ("x;y;z;roll;pitch;yaw\n1,234,5;0;0;0;0;2\n", "found '1,234,5', expected a finite number"),
        ("x,y,z,roll,pitch,yaw\n1,5,0,0,0,0,0\n", "found 7 cells, expected 6 as in the heading"),
    ],
)
def test_what_has_no_one_meaning_is_refused(text, message):
    with pytest.raises(SpecError) as caught:
        read_poses(text, "p.csv", MILLIMETRES)
    assert message in str(caught.value)


def test_a_leg_that_is_no_leg():
    example = gspcli.load(data_path("examples", "example-6.8.yaml"))
    number = next(k for k, row in enumerate(example.constraints, 1) if not row.kind.is_distance)
    with pytest.raises(SpecError) as caught:
        read_values(f"L{number}\n1\n", "v.csv", example, PoseFormat())
    assert f"v.csv:1:1: constraint {number} is A" in str(caught.value)
    assert f"not the length of a leg: write {number}" in str(caught.value)


def test_units_that_are_not_known_are_those_of_the_file():
    assert FileUnits("spans").factor("x", "spans") == 1
    assert "expected spans" in str(FileUnits("spans").factor("x", "mm"))
    assert FileUnits("mm").factor("ax", "m/s^2") == pytest.approx(1000)
    assert FileUnits("mm", np.pi / 180).factor("wx", "rad/s") == pytest.approx(180 / np.pi)


#: Columns of each kind, and a unit of each kind.
COLUMNS = {
    "mm": ("x", "ty", "base.B1.z", "P1.x"),
    "mrad": ("rx", "incl.x", "crank.B1"),
    "ms": ("t",),
    "": ("qw", "r12", "platform.L1.direction.z", "base.H2.normal.x", "row", "condition"),
    "m/s": ("vx", "vz"),
    "m/s^2": ("ax",),
    "deg/s": ("wy",),
    "rad/s²": ("alphaz",),
    "N": ("f1",),
    "N m": ("f6",),
}


@pytest.mark.parametrize("unit", [one for one in COLUMNS if one])
def test_a_column_takes_units_of_its_kind_only(unit):
    units = FileUnits("mm", np.pi / 180)
    for own, columns in COLUMNS.items():
        for column in columns:
            found = units.factor(column, unit)
            if own == unit or (own[:1] == unit[:1] == "N"):
                assert isinstance(found, float)
                continue
            what = {"m": "a length", "d": "an angle", "r": "an angle", "N": "a force"}[
                own[:1] or "m"
            ]
            what = {"mrad": "an angle", "ms": "a time", "": "a number"}.get(own, what)
            assert str(found).startswith(f"found the unit '{unit}' of the column {column}, {what}")


def test_values_are_lengths_or_angles_by_their_kinds():
    example = gspcli.load(data_path("examples", "example-6.8.yaml"))
    units = FileUnits("mm", 1.0).of(example)
    for k, row in enumerate(example.constraints, 1):
        for unit, of_distance in (("cm", True), ("deg", False), ("ms", None)):
            for prefix, per in (("", ""), ("v", "/s"), ("a", "/s^2")):
                found = units.factor(f"{prefix}{k}", unit + per)
                assert isinstance(found, float) is (row.kind.is_distance is of_distance)
        assert isinstance(units.factor(f"v{k}", "mm"), str)
    # Without an instance a value may be either.
    assert isinstance(FileUnits("mm").factor("1", "deg"), float)
    assert isinstance(FileUnits("mm").factor("1", "mm"), float)


POSES = "x{x},y,z,qw{q},qx,qy,qz,t{t},L1{v}\n1,2,3,1,0,0,0,1,9\n1,2,4,1,0,0,0,2,9\n"


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        *product("x", ("rad", "deg", "s", "ms", "N", "mm/s", "nm")),
        *product("t", ("mm", "deg")),
        *(("q", "mm"), ("v", "deg")),
    ],
)
def test_every_reader_refuses_a_unit_of_another_kind(key, unit):
    hexapod = gspcli.load(data_path("platforms", "simscape-hexapod.yaml"))
    units = dict.fromkeys("xqtv", "") | {key: f" [{unit}]"}
    text, form = POSES.format(**units), PoseFormat(in_radians=np.pi / 180, length="m")
    readers = {
        "poses": lambda: read_poses(text, "d.csv", form),
        "values": lambda: read_values(text, "d.csv", hexapod, form),
        "rows": lambda: read_rows(text, "d.csv", hexapod, form),
        "measurements": lambda: read_measurements(text, "d.csv", hexapod, form),
    }
    if key == "v":
        # Beside poses values are read by one reader only.
        readers = {"measurements": readers["measurements"]}
    if key == "t":
        # There t is the name of a row.
        del readers["measurements"]
    for reader in readers.values():
        with pytest.raises(SpecError, match=f"d.csv:1:.*found the unit '{unit}' of the column"):
            reader()


def test_columns_of_drives_may_have_units():
    head = gspcli.load(data_path("platforms", "t-top-head.yaml"))
    found = read_values("1,crank.B1 [deg]\n1,2\n1,3\n", "v.csv", head, PoseFormat())
    assert np.allclose(found.coordinates["crank.B1"], np.radians([2, 3]))


@pytest.mark.parametrize(
    ("text", "name"),
    [("base.B1.x [mm]", "base.B1.x"), ("Condition", "condition"), ("Tx", "tx"), ("q_w", "qw")],
)
def test_names(text, name):
    assert Heading.of(text).name == name
