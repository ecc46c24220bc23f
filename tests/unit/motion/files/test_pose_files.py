from __future__ import annotations

import json

import numpy as np
import pytest

from gspcli.errors import SpecError
from gspcli.geometry.euler import rotation_from_euler
from gspcli.motion import PoseFormat, read_pose, read_poses

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
