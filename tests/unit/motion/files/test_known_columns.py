"""A column that nothing is read from is an error: it was meant to be read."""

from __future__ import annotations

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.calibration.data_files import read_measurements
from gspcli.dynamics.motion_files import read_rows
from gspcli.errors import SpecError
from gspcli.motion import PoseFormat, read_poses, read_values
from gspcli.pictures.tracks import read_tracks
from gspcli.resources import data_path

PLAIN = PoseFormat(length="mm")
POSE = "x,y,z,qw,qx,qy,qz"
HINT = "(--ignore leaves it out)"


@pytest.fixture(scope="module")
def hexapod():
    return gspcli.load(data_path("platforms", "simscape-hexapod.yaml"))


def mistakes(read, *arguments):
    with pytest.raises(SpecError) as caught:
        read(*arguments)
    return str(caught.value).splitlines()


def test_a_misspelt_leg_does_not_keep_the_value_of_the_file(hexapod):
    text = "Länge 1;L2\n40;40\n"
    assert mistakes(read_values, text, "v", hexapod, PLAIN) == [
        f"v:1:1: found the unknown column 'Länge 1': did you mean length 1? {HINT}"
    ]
    ignoring = dataclasses.replace(PLAIN, ignore=("Länge 1",))
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
    (line,) = mistakes(read_poses, f"{heading},{POSE}\n1,0,0,1,1,0,0,0\n", "p", PLAIN)
    assert near in line


def test_every_reader_refuses_them(hexapod):
    pose = f"{POSE},speeed\n0,0,1,1,0,0,0,3\n"
    values = "1,speeed\n50,3\n"
    for lines in (
        mistakes(read_poses, pose, "f", PLAIN),
        mistakes(read_tracks, pose, "f", PLAIN),
        mistakes(read_rows, pose, "f", hexapod, PLAIN),
        mistakes(read_rows, values, "f", hexapod, PLAIN),
        mistakes(read_values, values, "f", hexapod, PLAIN),
        mistakes(read_values, pose, "f", hexapod, PLAIN),
        mistakes(read_measurements, values, "f", hexapod, PLAIN),
    ):
        assert "found the unknown column 'speeed'" in "\n".join(lines)


def test_columns_are_left_out_by_name_and_by_pattern(hexapod):
    def read(*ignore):
        form = dataclasses.replace(PLAIN, ignore=ignore)
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
        return read_values(text, "v", hexapod, PLAIN).values[:, 0].tolist()

    # What pandas writes of an index, and a separator at the end of each line.
    assert values(",1\n0,50\n1,51\n") == values(",1\n1,50\n2,51\n") == values("1,\n50,\n51,\n")
    for text in (",1\n1,50\n3,51\n", "1,\n50,0\n51,1\n", "t,,2\n0,50,50\n"):
        assert "found a column without a name" in mistakes(values, text)[0]


@pytest.mark.parametrize("first", ["0,0.5,3", "0 12 13 14", "1,1,2", "-1;2;3"])
def test_a_file_that_begins_with_numbers_has_no_heading(hexapod, first):
    (line,) = mistakes(read_values, f"{first}\n{first}\n", "log", hexapod, PLAIN)
    assert line == "log:1:1: the first line has numbers: give names with --columns x,y,z,..."
    assert read_values("2,1\n50,51\n", "v", hexapod, PLAIN).values[0, :2].tolist() == [51, 50]


@pytest.mark.parametrize("mark", [",", " ", ";", "\t"])
def test_names_stand_for_the_heading(hexapod, mark):
    named = replace(PLAIN, columns=("t", "2", "-", "1"))
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
    named = replace(PLAIN, columns=("Time [ms]", "Leg 1", "", "2"))
    table = read_values("0;50,25;0,1;51\n2000;50;0,1;51,5\n", "log", hexapod, named)
    assert table.values[:, :2].tolist() == [[50.25, 51], [50, 51.5]]
    assert table.t.tolist() == [0, 2]
    # Numbers from 1 to 6 alone could be a heading; with names they are a row.
    six = replace(PLAIN, columns=tuple("123456"))
    assert read_values("1 2 3 4 5 6\n", "log", hexapod, six).values.tolist() == [[1, 2, 3, 4, 5, 6]]


def test_mistakes_of_names(hexapod):
    few = replace(PLAIN, columns=("1", "2"))
    assert mistakes(read_values, "50,51,52\n", "log", hexapod, few) == [
        "log:1:1: found 3 cells, expected 2 as in --columns"
    ]
    twice = replace(PLAIN, columns=("1", "1"))
    assert "found the column '1' twice" in mistakes(read_values, "5,6\n", "log", hexapod, twice)[0]
    wrong = replace(PLAIN, columns=("1", "pitch"))
    assert "unknown column 'pitch'" in mistakes(read_values, "5,6\n", "log", hexapod, wrong)[0]


def test_poses_beside_values_say_two_things(hexapod):
    text = f"{POSE},3\n0,0,1,1,0,0,0,50\n"
    assert mistakes(read_values, text, "v", hexapod, PLAIN) == [
        "v:2:15: found 50 beside a pose that measures 0.972814 (see --ignore)"
    ]
    # What measures poses does not need it: a plan of `gsp calibrate` has both.
    assert np.array_equal(read_poses(text, "v", PLAIN).T, [[0, 0, 1]])
