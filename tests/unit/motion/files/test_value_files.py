from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.errors import SpecError
from gspcli.motion import PoseFormat, measure, read_values
from gspcli.resources import data_path

PLAIN = PoseFormat()
STATED = [2.53, 2.08, 0.93, 1.97, 1.46, 1.73]


@pytest.fixture(scope="module")
def hexapod():
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


def test_columns_left_out_keep_their_value(hexapod):
    table = read_values("t,3,1\n0.5,1,2\n0.75,1.5,3\n", "v", hexapod, PLAIN)
    assert table.t.tolist() == [0.5, 0.75]
    assert table.values.tolist() == [
        [2, 2.08, 1, 1.97, 1.46, 1.73],
        [3, 2.08, 1.5, 1.97, 1.46, 1.73],
    ]


def test_differences(hexapod):
    table = read_values("1,2,3,4,5,6\n0,0,0,0,0,0\n1,1,1,1,1,1\n", "v", hexapod, PLAIN, delta=True)
    assert table.t.tolist() == [1, 2]
    assert np.allclose(table.values, [STATED, np.array(STATED) + 1])


def test_rows_in_between(hexapod):
    table = read_values("t,1\n0,1\n1,3\n4,2\n", "v", hexapod, PLAIN).subdivided(2)
    assert table.t.tolist() == [0, 0.5, 1, 2.5, 4]
    assert table.values[:, 0].tolist() == [1, 2, 3, 2.5, 2]
    assert table.subdivided(1) is table
    one = read_values("t,1\n0,1\n", "v", hexapod, PLAIN).subdivided(5)
    assert one.values.shape == (1, 6)


def test_poses_are_measured(hexapod):
    table = read_values("t,x,y,z,qw,qx,qy,qz\n3,1,2,3,1,0,0,0\n", "v", hexapod, PLAIN)
    assert table.t.tolist() == [3]
    assert np.array_equal(table.values, measure(hexapod, np.eye(3)[None], [[1, 2, 3]]))


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        (
            "t,1\n0,1\n0,2\n",
            ["v:3:1: found t = 0 after 0: t must increase"],
        ),
        (
            "time,legs\n0,1\n",
            ["v:1:1: found the columns 'time legs', expected 1 2 3 4 5 6"],
        ),
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
def test_mistakes(hexapod, text, lines):
    with pytest.raises(SpecError) as caught:
        read_values(text, "v", hexapod, PLAIN)
    assert str(caught.value).splitlines() == lines


def test_angles_have_their_range(example):
    with pytest.raises(SpecError, match="found 190 for constraint 1, expected an angle of LL"):
        read_values("1\n190\n", "v", example, PLAIN)


def test_poses_are_no_differences(hexapod):
    with pytest.raises(SpecError, match="found poses, expected values with --relative"):
        read_values("x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,0\n", "v", hexapod, PLAIN, delta=True)


def test_mistakes_of_poses_and_of_t_are_told_in_order(hexapod):
    text = "t,x,y,z,qw,qx,qy,qz\n2,0,0,1,1,0,0,0\n1,0,0,1,0,0,0,0\n1,a,0,1,1,0,0,0\n"
    with pytest.raises(SpecError) as caught:
        read_values(text, "v", hexapod, PLAIN)
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
