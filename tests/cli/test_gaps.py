"""Gaps between legs in the commands that know them."""

from __future__ import annotations

import csv
import io
import json
import re

import pytest

from gspcli.resources import instance_files


@pytest.fixture
def thick(tmp_path):
    """A machine whose legs are 20 mm thick."""
    text = instance_files()["workspace-study"].read_text(encoding="utf-8")
    path = tmp_path / "thick.yaml"
    path.write_text(f"{text}\nshapes: {{diameter: 20}}\n", encoding="utf-8")
    return path


def table(text):
    return [*csv.DictReader(io.StringIO(text))]


def test_measure_names_the_two_legs_that_are_nearest(gsp, thick):
    run = gsp("measure", thick, "--pose", "0,0,400,1,0,0,0", "--format", "csv")
    assert (run.code, run.err) == (0, "")
    (row,) = table(run.out)
    assert float(row["gap"]) == pytest.approx(23.412044, abs=1e-5)
    assert row["gap_between"] == "legs 1 and 6"
    run = gsp("measure", thick, "--pose", "0,0,400,1,0,0,0", "--format", "json")
    (pose,) = json.loads(run.out)["poses"]
    assert (pose["gap"], pose["gap_between"]) == (float(row["gap"]), "legs 1 and 6")
    run = gsp("measure", thick, "--pose", "0,0,400,1,0,0,0")
    assert "gap  between" in run.out


def test_nothing_changes_without_shapes(gsp):
    run = gsp("measure", "@workspace-study", "--pose", "0,0,400,1,0,0,0", "--format", "csv")
    assert run.out.splitlines()[0] == "t,1,2,3,4,5,6"


def test_a_gap_can_be_required(gsp, thick):
    pose = ("measure", thick, "--pose", "0,0,400,1,0,0,0")
    run = gsp(*pose, "--require", "gap>=23.4")
    assert run.code == 0
    assert "gap >= 23.4: met; worst 23.412 in row 1 (t = 1), legs 1 and 6" in run.out
    run = gsp(*pose, "--require", "gap>=23.5", "--format", "json")
    assert run.code == 1
    assert run.err == "error: not met: gap >= 23.5\n"
    (judged,) = json.loads(run.out)["requirements"]
    assert (judged["met"], judged["part"]) == (False, "legs 1 and 6")
    for wrong in ("gap", "gap<=2", "gap>=wide"):
        assert gsp(*pose, "--require", wrong).code == 2
    run = gsp("measure", "@workspace-study", "--pose", "0,0,400,1,0,0,0", "--require", "gap>=2")
    assert run.code == 2
    assert run.err == (
        "error: --require gap: SPEC states no shapes of its legs (shapes: {diameter: ...})\n"
    )


def test_rods_of_cranks_begin_at_their_arms(gsp, tmp_path):
    text = instance_files()["t-top-head"].read_text(encoding="utf-8").rstrip()
    path = tmp_path / "thick.yaml"
    path.write_text(f"{text}\nshapes: {{diameter: 0}}\n", encoding="utf-8")
    pose = ("--pose", "0,0,0.17,1,0,0,0")
    plain = gsp("measure", path, *pose, "--format", "csv")
    driven = gsp("measure", path, *pose, "--drives", "--format", "csv")
    assert (plain.code, driven.code) == (0, 0), plain.err + driven.err
    first, second = (table(run.out)[0] for run in (plain, driven))
    assert first["gap"] == second["gap"]
    assert first["gap_between"] == second["gap_between"]


MOVES = """t,x,y,z,rx,ry,rz
0,0,0,400,0,0,0
1,30,0,410,5,0,0
2,30,30,400,5,5,10
"""


@pytest.mark.parametrize("along", ["poses", "values"])
def test_a_track_keeps_a_gap_between_its_rows(gsp, thick, tmp_path, along):
    moves = tmp_path / "moves.csv"
    moves.write_text(MOVES, encoding="utf-8")
    words = ("track", thick, moves, "--euler", "ZYX", "--along", along, "--require")
    run = gsp(*words, "gap>=22")
    assert run.code == 0
    assert "gap >= 22: met, between rows too; worst 23.412 in row 1 (t = 0)" in run.out
    run = gsp(*words, "gap>=23.412044", "--format", "json")
    assert run.code == 1
    (judged,) = json.loads(run.out)["requirements"]
    assert judged["between"]
    assert not judged["met"]
    assert judged["part"].startswith("between t = ")
    run = gsp(*words, "gap>=22", "--pivot", "10,20,30")
    assert (run.code, "met, between rows too" in run.out) == (0, True), run.err


@pytest.mark.parametrize("along", ["poses", "values"])
def test_a_track_of_a_machine_with_arms_keeps_a_gap_between_its_rows(gsp, tmp_path, along):
    text = instance_files()["t-top-head"].read_text(encoding="utf-8").rstrip()
    path, poses = tmp_path / "thick.yaml", tmp_path / "poses.csv"
    path.write_text(f"{text}\nshapes: {{diameter: 0}}\n", encoding="utf-8")
    poses.write_text("x,y,z,rx,ry,rz\n0,0,0.17,0,0,0\n0,0,0.171,0,0,1\n", encoding="utf-8")
    words = ("track", path, poses, "--euler", "ZYX", "--along", along, "--require")
    run = gsp(*words, "gap>=0.001")
    assert run.code == 0, run.err
    assert "gap >= 0.001: met, between rows too; worst 0.03" in run.out
    run = gsp(*words, "gap>=0.03")
    assert run.code == 1
    assert "gap >= 0.03: NOT met" in run.out


@pytest.fixture
def armed(tmp_path):
    """A machine with cranks whose arms are thicker than its rods."""
    text = instance_files()["t-top-head"].read_text(encoding="utf-8").rstrip()
    text = re.sub(r"(axis: \[[^\]]*\])\}", r"\1, diameter: 0.06}", text)
    path = tmp_path / "armed.yaml"
    path.write_text(f"{text}\nshapes: {{diameter: 0.006, near_joint: 0.01}}\n", encoding="utf-8")
    return path


def test_arms_are_compared_where_their_diameter_is_stated(gsp, armed, tmp_path):
    run = gsp("measure", armed, "--pose", "0,0,0.17,1,0,0,0", "--format", "csv")
    (row,) = table(run.out)
    assert "arm of B" in row["gap_between"]
    gap = float(row["gap"])
    poses = tmp_path / "poses.csv"
    poses.write_text("x,y,z,rx,ry,rz\n0,0,0.17,0,0,0\n0,0,0.171,0,0,1\n", encoding="utf-8")
    words = ("track", armed, poses, "--euler", "ZYX", "--along", "poses", "--require")
    run = gsp(*words, f"gap>={gap - 0.001}")
    assert run.code == 0
    assert "met, between rows too" in run.out
    assert "arm of B" in run.out
    assert gsp(*words, f"gap>={gap + 0.001}").code == 1


def test_documents_of_workspaces_say_which_gap_was_asked_for(gsp, thick):
    for over in ((), ("--over", "z", "--within", "z=0:100")):
        for asked, said in (((), None), (("--leg-gap", "5"), 5.0)):
            run = gsp("workspace", thick, *over, *asked, "--format", "json")
            assert (run.code, json.loads(run.out)["leg_gap"]) == (0, said)
