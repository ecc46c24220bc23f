"""`gsp track` as a check of files of poses: straight ways, and requirements between the rows."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.geometry.numbers import Number
from gspcli.motion.singularities.clearances import drive_clearances

POSES = """t,x,y,z,rx,ry,rz
0,0,0,400,0,0,0
1,30,0,410,5,0,0
2,30,30,400,5,5,10
3,0,0,400,0,0,0
"""
REQUIRE = "range, condition<=12, clearance>=0.04"


@pytest.fixture
def poses(tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text(POSES, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("along", ["values", "poses"])
def test_a_safe_file(gsp, poses, along):
    words = ("track", "@workspace-study", poses, "--euler", "ZYX", "--along", along)
    run = gsp(*words, "--require", REQUIRE)
    assert run.code == 0
    assert run.out.count("met, between rows too; worst") == 3
    document = json.loads(gsp(*words, "--require", REQUIRE, "--format", "json").out)
    assert [one["between"] for one in document["requirements"]] == [True] * 3
    assert document["modes"] == [16]


@pytest.mark.parametrize("along", ["values", "poses"])
def test_a_file_that_is_safe_at_its_rows_only(gsp, tmp_path, along):
    """Half a turn about z: both rows are home, and between them no leg is as long."""
    text = "t,x,y,z,rx,ry,rz\n0,-60,0,400,0,0,0\n1,60,0,400,0,0,0\n"
    path = tmp_path / "poses.csv"
    path.write_text(text, encoding="utf-8")
    words = ("track", "@workspace-study", str(path), "--euler", "ZYX", "--along", along)
    at_rows = json.loads(gsp(*words, "--require", "clearance>=0", "--format", "json").out)
    worst = at_rows["requirements"][0]["worst"]
    # A clearance that the rows just have is not proved between them.
    run = gsp(*words, "--require", f"clearance>={worst * (1 - 1e-9)}", "--format", "json")
    (judged,) = json.loads(run.out)["requirements"]
    if judged["met"]:
        pytest.skip("the clearance is larger between the rows")
    assert run.code == 1
    assert "is proved" in judged["part"]


def test_a_range_that_is_left_between_rows(gsp, tmp_path):
    """A leg is shorter in the middle of the way than at both rows."""
    platform = gspcli.example("workspace-study")
    T = np.array([[-100, 0, 401], [0, 0, 401], [100, 0, 401.0]])
    lengths = np.asarray(gspcli.measure(platform, np.tile(np.eye(3), (3, 1, 1)), T))
    leg = int((lengths[[0, 2]].min(axis=0) - lengths[1]).argmax())
    least = (lengths[[0, 2], leg].min() + lengths[1, leg]) / 2
    assert lengths[1, leg] < least < lengths[[0, 2], leg].min()
    rows = list(platform.constraints)
    rows[leg] = replace(rows[leg], limits=(Number.of(least), Number.of(520)))
    spec, path = tmp_path / "narrow.yaml", tmp_path / "poses.csv"
    text = gspcli.dumps(replace(platform, constraints=tuple(rows)))
    spec.write_text(text, encoding="utf-8")
    path.write_text(
        "t,x,y,z,qw,qx,qy,qz\n0,-100,0,401,1,0,0,0\n1,100,0,401,1,0,0,0\n", encoding="utf-8"
    )
    run = gsp("track", str(spec), str(path), "--along", "poses", "--require", "range")
    assert run.code == 1
    assert f"the value of constraint {leg + 1} may leave its range" in run.err
    assert f"constraint {leg + 1} perhaps left between rows" in run.out
    wide = gsp("track", "@workspace-study", str(path), "--along", "poses", "--require", "range")
    assert wide.code == 0


def test_a_path_of_a_machine_with_slides_is_a_safe_file(gsp, tmp_path):
    path = tmp_path / "path.csv"
    ends = ("--from", "home", "--to", "0,0,4.2,1,0,0,0")
    run = gsp("path", "@three-prs", *ends, "--along", "poses", "-o", path)
    assert run.code == 0, run.err
    require = "range, transmission>=0.75, condition<=4.5, clearance>=0.08"
    words = ("track", "@three-prs", path, "--along", "poses", "--require")
    run = gsp(*words, require, "--format", "json")
    assert (run.code, run.err) == (0, "")
    document = json.loads(run.out)
    assert [one["between"] for one in document["requirements"]] == [True] * 4
    assert document["coordinates"]["slide.B1"] == pytest.approx([0, 0.05, 0.1, 0.15, 0.2])
    # The clearance is that of the slides, as gsp measure has it.
    poses = document["poses"]
    T = np.array([[row[key] for key in "xyz"] for row in poses])
    clear = drive_clearances(gspcli.example("three-prs"), np.tile(np.eye(3), (len(T), 1, 1)), T)[0]
    assert [row["clearance"] for row in poses] == pytest.approx(clear, rel=1e-9)


def test_a_range_of_a_slide_that_is_left_is_named(gsp, tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text("x,y,z,rx,ry,rz\n0,0,4.8,0,0,0\n0,0,5.2,0,0,0\n", encoding="utf-8")
    run = gsp(
        "track", "@three-prs", path, "--euler", "ZYX", "--along", "poses", "--require", "range"
    )
    assert run.code == 1
    assert "slide.B1 may leave its range from -1 to 1 between t = " in run.err
    assert "range <= 1: NOT met; worst 1.2 in row 2 (t = 2), mode 8" in run.out


def test_a_way_through_a_singular_pose_is_no_safe_file(gsp, tmp_path):
    solved = json.loads(gsp("solve", "@rubin-m2", "--format", "json").out)
    rows = [one for one in solved["solutions"] if one["real"]]
    lines = ["t,x,y,z,qw,qx,qy,qz"]
    for k, one in enumerate(rows):
        lines.append(",".join(map(str, (k, *one["T"], *one["quaternion"]))))
    path = tmp_path / "poses.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    run = gsp("track", "@rubin-m2", str(path), "--along", "poses")
    assert run.code == 4
    assert "a pose on the straight way may be singular (undecided)" in run.err


def test_steps_are_on_the_straight_way(gsp, poses):
    words = ("track", "@workspace-study", poses, "--euler", "ZYX", "--along", "poses")
    run = gsp(*words, "--steps", "2", "--format", "json")
    rows = json.loads(run.out)["poses"]
    assert [row["t"] for row in rows] == [0, 0.5, 1, 1.5, 2, 2.5, 3]
    assert [rows[1][key] for key in "xyz"] == pytest.approx([15, 0, 405])


def test_poses_relative_to_home(gsp, tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text(POSES.replace(",400,", ",0,").replace(",410,", ",10,"), encoding="utf-8")
    words = ("--euler", "ZYX", "--along", "poses", "--relative-to", "home", "--require", "range")
    run = gsp("track", "@workspace-study", str(path), *words)
    if "states no home" in run.err:
        assert run.code == 2
    else:
        assert run.code == 0


@pytest.mark.parametrize(
    ("text", "words", "message"),
    [
        ("1,2\n424,424\n", (), "--along poses is about a file of poses: found values"),
        (POSES, ("--mode", "16"), "leave out --mode, --near, --all-modes"),
        (POSES, ("--complete",), "leave out --mode, --near, --all-modes"),
        (POSES, ("--no-certify",), "leave out --mode, --near, --all-modes"),
    ],
)
def test_what_does_not_go_with_straight_ways(gsp, tmp_path, text, words, message):
    path = tmp_path / "file.csv"
    path.write_text(text, encoding="utf-8")
    more = ("--euler", "ZYX", "--along", "poses", *words)
    run = gsp("track", "@workspace-study", str(path), *more)
    assert (run.code, run.out) == (2, "")
    assert message in run.err
