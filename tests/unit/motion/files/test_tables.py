"""."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import gspcli
from gspcli.calibration.logs import read_measurements
from gspcli.dynamics.motion_files import read_rows
from gspcli.errors import SpecError
from gspcli.geometry.euler import rotation_from_euler
from gspcli.motion import PoseFormat, measure, read_pose, read_poses, read_values
from gspcli.motion.files.number_tables import FileUnits, Heading
from gspcli.pictures.whole_views import read_tracks
from gspcli.resources import data_path

PLAIN = PoseFormat()


def mistakes(text: str, form: PoseFormat = PLAIN) -> list[str]:
    with pytest.raises(SpecError) as caught:
        read_poses(text, "p.csv", form)
    return str(caught.value).splitlines()


def test_quaternions_of_any_length_and_columns_of_our_own():
    table = read_poses("number,t,x,y,z,qw,qx,qy,qz\n1,0.5,1,2,3,0,0,0,-4\n", "p", PLAIN)
    assert table.t == [0.5]
    assert np.array_equal(table.T, [[1, 2, 3]])
    assert np.allclose(table.R, [np.diag([-1, -1, 1])])


@pytest.mark.parametrize("size", [1e-200, 1e200])
def test_tiny_and_huge_quaternions(size):
    table = read_poses(f"x,y,z,qw,qx,qy,qz\n0,0,0,{size},{size},0,0", "p", PLAIN)
    assert np.allclose(table.R[0] @ [0, 1, 0], [0, 0, 1])


def test_euler_angles_are_in_the_unit_and_a_pivot_moves_the_origin():
    form = PoseFormat("ZYX", (0.0, 0.0, 2.0), np.pi / 180)
    table = read_poses("x y z rx ry rz\n0 0 5 90 0 0\n", "p", form)
    assert table.t is None
    assert np.allclose(table.R[0], rotation_from_euler("ZYX", [np.pi / 2, 0, 0]))
    # The pivot, two above the origin of the platform, is turned to -y.
    assert np.allclose(table.T, [[0, 2, 5]])


def test_rounded_entries_of_R_become_a_rotation():
    head = "x;y;z;" + ";".join(f"r{i}{j}" for i in "123" for j in "123")
    table = read_poses(head + "\n0;0;0;0.866;-0.5;0;0.5;0.866;0;0;0;1", "p", PLAIN)
    assert np.allclose(table.R[0] @ table.R[0].T, np.eye(3), atol=1e-15)
    assert np.allclose(table.R[0, 0, 0], np.sqrt(3) / 2, atol=1e-4)


def test_comments_blank_lines_and_a_byte_order_mark_of_quotes():
    text = '# from a drawing\n\n"x","y","z",qw,qx,qy,qz\n"1",2, 3 ,1,0,0,0\n'
    assert np.array_equal(read_poses(text, "p", PLAIN).T, [[1, 2, 3]])


def test_all_mistakes_at_once_with_line_and_column():
    text = "x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,0\n1,two,3,1,0,0,nan\n1,2,3\n,1e999,0,1,0,0,0\n"
    assert mistakes(text) == [
        "p.csv:3:3: y: found 'two', expected a finite number",
        "p.csv:3:15: qz: found 'nan', expected a finite number",
        "p.csv:4:1: found 3 cells, expected 7 as in the heading",
        "p.csv:5:1: x: found nothing, expected a finite number",
        "p.csv:5:2: y: found '1e999', expected a finite number",
    ]


def test_numbers_whose_products_are_no_doubles_are_mistakes():
    text = "x,y,z,qw,qx,qy,qz\n1,2,1e60,1,0,0,0\n1,2,-1e160,1,0,0,0\n"
    assert mistakes(text) == ["p.csv:3:5: found -1e+160, expected a magnitude up to 1e+60"]


def test_decimal_commas_are_explained():
    (line,) = mistakes("x;y;z;qw;qx;qy;qz\n1,5;0.5;0;1;0;0;0")
    assert line.endswith(
        "found '1,5', expected a finite number (decimals are written with a point)"
    )


def test_a_misspelt_heading():
    # This one means z.
    assert mistakes("x,y,z,qw,qx,qy,pz\n0,0,0,1,0,0,0")[1:] == [
        "p.csv:1:16: pz: found the column 'pz' twice"
    ]
    assert mistakes("x,y,z,qw,qx,qy,q.z\n0,0,0,1,0,0,0") == [
        "p.csv:1:1: found the columns 'x y z qw qx qy q.z', expected qw qx qy qz, rx ry rz or "
        "r11 r12 r13 r21 r22 r23 r31 r32 r33: qz is missing: did you mean q.z?"
    ]


def test_two_rotations_are_one_too_many():
    (line,) = mistakes("x,y,z,qw,qx,qy,qz,rx,ry,rz\n0,0,0,1,0,0,0,0,0,0")
    assert "found qw qx qy qz and rx ry rz, expected only one of" in line


def test_a_column_twice():
    lines = mistakes("x,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0")
    assert lines == ["p.csv:1:3: x: found the column 'x' twice"]


def test_what_is_no_rotation():
    assert mistakes("x,y,z,qw,qx,qy,qz\n0,0,0,1,0,0,0\n0,0,0,0,0,0,0") == [
        "p.csv:3:7: found a quaternion of length zero, expected that of a rotation"
    ]
    head = "x,y,z," + ",".join(f"r{i}{j}" for i in "123" for j in "123")
    lines = mistakes(head + "\n0,0,0,1,0,0,0,1,0,0,0,-1\n0,0,0,1,0,0,0,1,0,0,0,2\n")
    assert lines == [
        "p.csv:2:7: found a matrix with determinant -1, expected a rotation",
        "p.csv:3:7: found a matrix 1 away from the nearest orthogonal one, expected a rotation",
    ]


def test_rotations_are_judged_with_the_mistakes_of_other_rows():
    text = "x,y,z,qw,qx,qy,qz\n1,two,3,1,0,0,0\n1,2,3,0,0,0,0\n1,2,3\nnan,2,3, 0,0,0,0\n"
    assert mistakes(text) == [
        "p.csv:2:3: y: found 'two', expected a finite number",
        "p.csv:3:7: found a quaternion of length zero, expected that of a rotation",
        "p.csv:4:1: found 3 cells, expected 7 as in the heading",
        "p.csv:5:1: x: found 'nan', expected a finite number",
        "p.csv:5:10: found a quaternion of length zero, expected that of a rotation",
    ]


def test_angles_and_their_order_belong_together():
    (line,) = mistakes("x,y,z,rx,ry,rz\n0,0,0,0,0,0")
    assert "say it with --euler" in line
    (line,) = mistakes("x,y,z,qw,qx,qy,qz\n0,0,0,1,0,0,0", PoseFormat("ZYX"))
    assert "expected rx ry rz with an Euler sequence" in line


def test_many_mistakes_are_counted():
    lines = mistakes("x,y,z,qw,qx,qy,qz\n" + "a,0,0,1,0,0,0\n" * 50)
    assert len(lines) == 5
    assert lines[-1] == "… and 46 more mistakes"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "p.csv:1:1: found nothing, expected a heading and rows"),
        ("x,y,z,qw,qx,qy,qz\n", "p.csv:1:1: found a heading and no rows"),
        ("{", "p.csv:1:2: not JSON: Expecting property name enclosed in double quotes"),
        ("[]", "p.csv:1:1: found no list of solutions, expected CSV or what gsp solve"),
    ],
)
def test_what_is_no_list_of_poses(text, message):
    assert mistakes(text)[0].startswith(message)


def test_json_of_solve():
    pose = {"real": True, "R": np.eye(3).tolist(), "T": [1, 2, 3]}
    table = read_poses(json.dumps({"solutions": [pose, pose]}), "p", PLAIN)
    assert table.R.shape == (2, 3, 3)
    wrong = [pose, {**pose, "real": False}, {**pose, "T": [1, 2]}, "x"]
    assert mistakes(json.dumps({"solutions": wrong})) == [
        "p.csv: solutions[2]: found a pose that is not real, expected a real one: leave out --all",
        "p.csv: solutions[3]: found no T of 3 finite numbers",
        "p.csv: solutions[4]: found 'x', expected a pose with R and T",
    ]


def test_one_pose():
    assert np.array_equal(read_pose("1,2,3,1,0,0,0", PLAIN).T, [[1, 2, 3]])
    assert read_pose("1 2 3 0 0 0", PoseFormat("xyz")).R.shape == (1, 3, 3)
    with pytest.raises(SpecError, match=r"^--pose: found 5 numbers"):
        read_pose("1,2,3,4,5", PLAIN)
    with pytest.raises(SpecError, match=r"^--pose: qz: found 'q', expected a finite number$"):
        read_pose("1,2,3,4,5,6,q", PLAIN)


# Tables of other programs mean what ours mean, or the error says what to write.


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


# A column that nothing is read from is an error: it was meant to be read.


KNOWN_COLUMNS_PLAIN = PoseFormat(length="mm")
POSE = "x,y,z,qw,qx,qy,qz"
HINT = "(--ignore leaves it out)"


@pytest.fixture(scope="module")
def hexapod():
    return gspcli.load(data_path("platforms", "simscape-hexapod.yaml"))


def known_columns_mistakes(read, *arguments):
    with pytest.raises(SpecError) as caught:
        read(*arguments)
    return str(caught.value).splitlines()


def test_a_misspelt_leg_does_not_keep_the_value_of_the_file(hexapod):
    text = "Länge 1;L2\n40;40\n"
    assert known_columns_mistakes(read_values, text, "v", hexapod, KNOWN_COLUMNS_PLAIN) == [
        f"v:1:1: found the unknown column 'Länge 1': did you mean length 1? {HINT}"
    ]
    ignoring = dataclasses.replace(KNOWN_COLUMNS_PLAIN, ignore=("Länge 1",))
    values = read_values(text, "v", hexapod, ignoring).values
    assert values[0, 0] == float(hexapod.constraints[0].value)
    assert values[0, 1] == 40


@pytest.mark.parametrize(
    ("heading", "near"),
    [
        ("Zeit [s]", "expected t, x y z, and qw qx qy qz or rx ry rz"),
        ("tme", "did you mean time?"),
        ("Quat", "expected t, x y z, and qw qx qy qz or rx ry rz"),
        ("base.B1.x", "expected t, x y z, and qw qx qy qz or rx ry rz"),
    ],
)
def test_poses(heading, near):
    (line,) = known_columns_mistakes(
        read_poses, f"{heading},{POSE}\n1,0,0,1,1,0,0,0\n", "p", KNOWN_COLUMNS_PLAIN
    )
    assert near in line


def test_every_reader_refuses_them(hexapod):
    pose = f"{POSE},speeed\n0,0,1,1,0,0,0,3\n"
    values = "1,speeed\n50,3\n"
    for lines in (
        known_columns_mistakes(read_poses, pose, "f", KNOWN_COLUMNS_PLAIN),
        known_columns_mistakes(read_tracks, pose, "f", KNOWN_COLUMNS_PLAIN),
        known_columns_mistakes(read_rows, pose, "f", hexapod, KNOWN_COLUMNS_PLAIN),
        known_columns_mistakes(read_rows, values, "f", hexapod, KNOWN_COLUMNS_PLAIN),
        known_columns_mistakes(read_values, values, "f", hexapod, KNOWN_COLUMNS_PLAIN),
        known_columns_mistakes(read_values, pose, "f", hexapod, KNOWN_COLUMNS_PLAIN),
        known_columns_mistakes(read_measurements, values, "f", hexapod, KNOWN_COLUMNS_PLAIN),
    ):
        assert "found the unknown column 'speeed'" in "\n".join(lines)


def test_columns_are_left_out_by_name_and_by_pattern(hexapod):
    def read(*ignore):
        form = dataclasses.replace(KNOWN_COLUMNS_PLAIN, ignore=ignore)
        text = "t,L1 [mm],L2,motor 1,Motor 2\n0,50,50,7,7\n"
        return read_values(text, "v", hexapod, form).values[0, 0]

    stated = float(hexapod.constraints[0].value)
    assert read("motor *") == read("motor 1", "Motor 2") == 50
    # A pattern leaves no known column out; a name does, however it is spelt.
    assert read("*") == 50
    assert read("leg 1", "*") == read("L1 [mm]", "*") == read("1", "*") == stated
    with pytest.raises(
        SpecError, match=r"^--ignore: v has no column 'motr 1': did you mean (m|M)otor"
    ):
        read("motr 1")


def test_columns_without_a_name(hexapod):
    def values(text):
        return read_values(text, "v", hexapod, KNOWN_COLUMNS_PLAIN).values[:, 0].tolist()

    # What pandas writes of an index, and a separator at the end of each line.
    assert values(",1\n0,50\n1,51\n") == values(",1\n1,50\n2,51\n") == values("1,\n50,\n51,\n")
    for text in (",1\n1,50\n3,51\n", "1,\n50,0\n51,1\n", "t,,2\n0,50,50\n"):
        assert "found a column without a name" in known_columns_mistakes(values, text)[0]


@pytest.mark.parametrize("first", ["0,0.5,3", "0 12 13 14", "1,1,2", "-1;2;3"])
def test_a_file_that_begins_with_numbers_has_no_heading(hexapod, first):
    (line,) = known_columns_mistakes(
        read_values, f"{first}\n{first}\n", "log", hexapod, KNOWN_COLUMNS_PLAIN
    )
    assert line == "log:1:1: the first line has numbers: give names with --columns x,y,z,..."
    assert read_values("2,1\n50,51\n", "v", hexapod, KNOWN_COLUMNS_PLAIN).values[
        0, :2
    ].tolist() == [51, 50]


@pytest.mark.parametrize("mark", [",", " ", ";", "\t"])
def test_names_stand_for_the_heading(hexapod, mark):
    named = replace(KNOWN_COLUMNS_PLAIN, columns=("t", "2", "-", "1"))
    rows = [["0", "51.5", "seven", "50"], ["1", "52", "8", "49.5"]]
    text = "\n".join(mark.join(row) for row in rows)
    if mark == ",":
        # A heading is replaced: here the first line is one, since it is not of numbers.
        table = read_values(text, "log", hexapod, named)
        assert table.values[:, :2].tolist() == [[49.5, 52]]
    text = text.replace("seven", "7")
    table = read_values(text, "log", hexapod, named)
    assert table.values[:, :2].tolist() == [[50, 51.5], [49.5, 52]]
    assert table.t.tolist() == [0, 1]


def test_names_with_decimal_commas_units_and_numbers_of_constraints(hexapod):
    named = replace(KNOWN_COLUMNS_PLAIN, columns=("Time [ms]", "Leg 1", "", "2"))
    table = read_values("0;50,25;0,1;51\n2000;50;0,1;51,5\n", "log", hexapod, named)
    assert table.values[:, :2].tolist() == [[50.25, 51], [50, 51.5]]
    assert table.t.tolist() == [0, 2]
    # Numbers from 1 to 6 alone could be a heading; with names they are a row.
    six = replace(KNOWN_COLUMNS_PLAIN, columns=tuple("123456"))
    assert read_values("1 2 3 4 5 6\n", "log", hexapod, six).values.tolist() == [[1, 2, 3, 4, 5, 6]]


def test_mistakes_of_names(hexapod):
    few = replace(KNOWN_COLUMNS_PLAIN, columns=("1", "2"))
    assert known_columns_mistakes(read_values, "50,51,52\n", "log", hexapod, few) == [
        "log:1:1: found 3 cells, expected 2 as in --columns"
    ]
    twice = replace(KNOWN_COLUMNS_PLAIN, columns=("1", "1"))
    assert (
        "found the column '1' twice"
        in known_columns_mistakes(read_values, "5,6\n", "log", hexapod, twice)[0]
    )
    wrong = replace(KNOWN_COLUMNS_PLAIN, columns=("1", "pitch"))
    assert (
        "unknown column 'pitch'"
        in known_columns_mistakes(read_values, "5,6\n", "log", hexapod, wrong)[0]
    )


def test_poses_beside_values_say_two_things(hexapod):
    text = f"{POSE},3\n0,0,1,1,0,0,0,50\n"
    assert known_columns_mistakes(read_values, text, "v", hexapod, KNOWN_COLUMNS_PLAIN) == [
        "v:2:15: found 50 beside a pose that measures 0.972814 (see --ignore)"
    ]
    # What measures poses does not need it: a plan of `gsp calibrate` has both.
    assert np.array_equal(read_poses(text, "v", KNOWN_COLUMNS_PLAIN).T, [[0, 0, 1]])


STATED = [2.53, 2.08, 0.93, 1.97, 1.46, 1.73]


@pytest.fixture(scope="module")
def value_files_hexapod():
    return gspcli.load(data_path("examples", "platform-6-6.yaml"))


@pytest.fixture(scope="module")
def example():
    return gspcli.load(data_path("examples", "example-6.8.yaml"))


def test_columns_that_are_nearly_ones_are_mistakes():
    instance = gspcli.load(data_path("platforms", "t-top-head.yaml"))
    with pytest.raises(SpecError) as caught:
        read_values("t,crnk.B1,7,no.,1\n0,1,2,3,0.1\n", "v", instance, PoseFormat())
    assert str(caught.value).splitlines() == [
        "v:1:3: found the unknown column 'crnk.B1': did you mean crank.B1? (--ignore leaves it "
        "out)",
        "v:1:11: found 7, expected a constraint from 1 to 6",
        "v:1:13: found the unknown column 'no.', expected t, 1 ... 6, crank.NAME or "
        "slide.NAME (--ignore leaves it out)",
    ]


def test_columns_left_out_keep_their_value(value_files_hexapod):
    table = read_values("t,3,1\n0.5,1,2\n0.75,1.5,3\n", "v", value_files_hexapod, PLAIN)
    assert table.t.tolist() == [0.5, 0.75]
    assert table.values.tolist() == [
        [2, 2.08, 1, 1.97, 1.46, 1.73],
        [3, 2.08, 1.5, 1.97, 1.46, 1.73],
    ]


def test_differences(value_files_hexapod):
    table = read_values(
        "1,2,3,4,5,6\n0,0,0,0,0,0\n1,1,1,1,1,1\n", "v", value_files_hexapod, PLAIN, delta=True
    )
    assert table.t.tolist() == [1, 2]
    assert np.allclose(table.values, [STATED, np.array(STATED) + 1])


def test_rows_in_between(value_files_hexapod):
    table = read_values("t,1\n0,1\n1,3\n4,2\n", "v", value_files_hexapod, PLAIN).subdivided(2)
    assert table.t.tolist() == [0, 0.5, 1, 2.5, 4]
    assert table.values[:, 0].tolist() == [1, 2, 3, 2.5, 2]
    assert table.subdivided(1) is table
    one = read_values("t,1\n0,1\n", "v", value_files_hexapod, PLAIN).subdivided(5)
    assert one.values.shape == (1, 6)


def test_poses_are_measured(value_files_hexapod):
    table = read_values("t,x,y,z,qw,qx,qy,qz\n3,1,2,3,1,0,0,0\n", "v", value_files_hexapod, PLAIN)
    assert table.t.tolist() == [3]
    assert np.array_equal(table.values, measure(value_files_hexapod, np.eye(3)[None], [[1, 2, 3]]))


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("t,1\n0,1\n0,2\n", ["v:3:1: found t = 0 after 0: t must increase"]),
        ("time,legs\n0,1\n", ["v:1:1: found the columns 'time legs', expected 1 2 3 4 5 6"]),
        (
            "t,crank.B1\n0,0\n",
            [
                "v:1:1: found the columns 't crank.B1', expected 1 2 3 4 5 6",
                "v:1:3: found 'crank.B1', expected a drive such as crank.NAME",
            ],
        ),
        (
            "1,2\n-1,1\n1,x\n0,1\n",
            [
                "v:2:1: found -1 for constraint 1, expected a distance of at least 0",
                "v:3:3: 2: found 'x', expected a finite number",
                "v:4:1: found 0 for constraint 1, expected more: DPP with value 0 is more than "
                "one equation",
            ],
        ),
    ],
)
def test_mistakes(value_files_hexapod, text, lines):
    with pytest.raises(SpecError) as caught:
        read_values(text, "v", value_files_hexapod, PLAIN)
    assert str(caught.value).splitlines() == lines


def test_angles_have_their_range(example):
    with pytest.raises(SpecError, match="found 190 for constraint 1, expected an angle of LL"):
        read_values("1\n190\n", "v", example, PLAIN)


def test_poses_are_no_differences(value_files_hexapod):
    with pytest.raises(SpecError, match="found poses, expected values with --relative"):
        read_values(
            "x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,0\n", "v", value_files_hexapod, PLAIN, delta=True
        )


def test_mistakes_of_poses_and_of_t_are_told_in_order(value_files_hexapod):
    text = "t,x,y,z,qw,qx,qy,qz\n2,0,0,1,1,0,0,0\n1,0,0,1,0,0,0,0\n1,a,0,1,1,0,0,0\n"
    with pytest.raises(SpecError) as caught:
        read_values(text, "v", value_files_hexapod, PLAIN)
    assert str(caught.value).splitlines() == [
        "v:3:1: found t = 1 after 2: t must increase",
        "v:3:9: found a quaternion of length zero, expected that of a rotation",
        "v:4:1: found t = 1 after 1: t must increase",
        "v:4:3: x: found 'a', expected a finite number",
    ]


def test_drives_that_move():
    head = gspcli.load(data_path("platforms", "t-top-head.yaml"))
    table = read_values("t,CRANK.B1,2\n0,1,2\n1,2,3\n", "v", head, PLAIN)
    assert {name: column.tolist() for name, column in table.coordinates.items()} == {
        "crank.B1": [1, 2]
    }
    assert table.values[:, 1].tolist() == [2, 3]
    assert table.subdivided(2).coordinates["crank.B1"].tolist() == [1, 1.5, 2]
    shifted = read_values("crank.B1\n1\n2\n", "v", head, PLAIN, delta=True)
    assert shifted.coordinates["crank.B1"].tolist() == [1, 2]


def test_joints_do_not_move():
    head = gspcli.load(data_path("platforms", "t-top-head.yaml"))
    with pytest.raises(SpecError, match=r"found the unknown column 'base\.B1\.x'"):
        read_values("crank.B1,base.B1.x\n0,0\n", "v", head, PLAIN)
