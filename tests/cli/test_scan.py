from __future__ import annotations

import json
from pathlib import Path

import pytest

HEXAPOD = str(Path(__file__).parents[2] / "data" / "examples" / "platform-6-6.yaml")


def test_nodes(gsp):
    run = gsp("scan", HEXAPOD, "--vary", "1=2.5:2.6:3", "--format", "csv")
    assert (run.code, run.err) == (0, "")
    head, *rows = run.out.splitlines()
    assert head == "1,modes,condition"
    assert [row.split(",")[0] for row in rows] == ["2.5", "2.55", "2.6"]
    assert all(int(row.split(",")[1]) % 2 == 0 for row in rows)


def test_folds(gsp):
    run = gsp("scan", HEXAPOD, "--vary", "1=2.3:2.8:6", "--folds", "--format", "json")
    document = json.loads(run.out)
    assert document["schema"] == "gsp.scan/1"
    assert document["vary"] == {"1": pytest.approx([2.3, 2.4, 2.5, 2.6, 2.7, 2.8])}
    assert document["folds"]
    assert document["curves"] == []
    assert all(abs(fold["change"]) == 2 for fold in document["folds"])


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        (
            "7=1:2:3",
            "error: --vary: found '7=1:2:3', expected NAME=LOW:HIGH:COUNT with 1, 2, 3, 4, 5 or 6, "
            "such as 1=5:7:200",
        ),
        ("1=2:1:3", "expected LOW below HIGH and at least two values"),
        ("1=1:x:3", "expected NAME=LOW:HIGH:COUNT"),
        ("1=1:2:9999999", "expected at most 1000000"),
    ],
)
def test_mistakes(gsp, vary, message):
    run = gsp("scan", HEXAPOD, "--vary", vary)
    assert run.code == 2
    assert run.out == ""
    assert message in run.err


def test_pictures(gsp, tmp_path):
    for arguments in (("--vary", "1=2.4:2.6:4"), ("--vary", "1=2.4:2.6:4", "--vary", "4=1.9:2:3")):
        path = tmp_path / "map.svg"
        assert gsp("scan", HEXAPOD, *arguments, "--folds", "-o", path).code == 0
        assert path.read_bytes().startswith(b"<?xml")


def test_a_picture_of_values_without_a_pose(gsp, tmp_path):
    grid = ("--vary", "1=90:91:2", "--vary", "4=1:2:2", "--quantity", "condition")
    assert gsp("scan", HEXAPOD, *grid, "-o", tmp_path / "map.svg").code == 0


def test_curves_and_clearances(gsp):
    grid = ("--vary", "1=2.2:2.4:3", "--vary", "4=1.6:1.8:3", "--jobs", "1")
    run = gsp("scan", HEXAPOD, *grid, "--folds", "--format", "json")
    assert run.code == 0
    document = json.loads(run.out)
    assert document["curves"]
    assert all(len(point) == 2 for curve in document["curves"] for point in curve["values"])
    run = gsp("scan", HEXAPOD, *grid, "--quantity", "clearance", "--format", "json")
    nodes = json.loads(run.out)["nodes"]
    assert all((node["clearance"] is None) == (node["modes"] == 0) for node in nodes)


def test_work_is_kept_and_taken_up(gsp, tmp_path, monkeypatch):
    from gspcli.motion.singularities import scans as scanning

    monkeypatch.setattr(scanning, "_PIECE", 2)
    done, journal = [], tmp_path / "work.jsonl"
    scanned = scanning.scanned

    def counted(found, seed, number):
        if len(done) == 2:
            raise KeyboardInterrupt
        done.append(number)
        return scanned(found, seed, number)

    monkeypatch.setattr(scanning, "scanned", counted)
    call = ("scan", HEXAPOD, "--vary", "1=2.4:2.6:7", "--jobs", "1", "--resume", journal)
    run = gsp(*call, "--format", "csv")
    assert run.code == 130
    assert run.err == "interrupted after 4 of 7 nodes\n"
    assert len(run.out.splitlines()) == 1 + 4
    done.clear()
    # A file appears whole or not at all.
    path = tmp_path / "modes.csv"
    words = ("scan", HEXAPOD, "--vary", "1=2.4:2.6:7", "--jobs", "1", "-o", path)
    run = gsp(*words)
    assert (run.code, run.out, path.exists()) == (130, "", False)
    assert f"{path}: not written; --resume keeps what is done" in run.err
    done.clear()
    run = gsp(*call, "--format", "csv")
    assert (run.code, done) == (0, [2, 3])
    assert len(run.out.splitlines()) == 1 + 7
    # Another scan does not take that for its own.
    done.clear()
    other = ("scan", HEXAPOD, "--vary", "2=2.0:2.1:3", "--jobs", "1", "--resume", journal)
    assert gsp(*other).code == 0
    assert done == [0, 1]


def test_poses(gsp, tmp_path):
    over = ("--vary", "x=-2:2:9", "--vary", "y=-2:2:9", "--pose", "0,0,0.5,1,0.2,0.1,0")
    run = gsp("scan", HEXAPOD, *over, "--format", "csv")
    assert run.code == 0
    assert run.out.splitlines()[0] == "x,y,determinant,condition"
    assert len(run.out.splitlines()) == 1 + 81
    document = json.loads(gsp("scan", HEXAPOD, *over, "--folds", "--format", "json").out)
    assert len(document["singular"]) > 8
    assert document["curves"]
    assert document["over"]["x"][0] == -2
    for arguments in (over, ("--vary", "x=-2:2:9", *over[4:])):
        path = tmp_path / "map.svg"
        assert gsp("scan", HEXAPOD, *arguments, "-o", path).code == 0
        assert path.read_bytes().startswith(b"<?xml")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "Missing option '--vary'"),
        (("--vary", "x=0:1:2"), "give --pose, too, for the coordinates that stay"),
        (("--vary", "1=1:2:3", "--pivot", "0,0,1"), "say how --pose is read"),
        (("--pose", "0,0,0,1,0,0,0", "--vary", "1=1:2:3"), "NAME=LOW:HIGH:COUNT with x, y, z"),
        (("--pose", "0,0,0,0,0,0,0", "--vary", "x=1:2:3"), "a quaternion of length zero"),
        (("--pose", "0,0,0,0,0,0", "--vary", "rx=1:2:3"), "say it with --euler"),
    ],
)
def test_either_values_or_poses(gsp, arguments, message):
    run = gsp("scan", HEXAPOD, *arguments)
    assert (run.code, run.out) == (2, "")
    assert message in run.err


def test_the_pose_may_be_in_a_file(gsp, tmp_path):
    path = tmp_path / "pose.csv"
    path.write_text("x,y,z,qw,qx,qy,qz\n0,0,0.5,1,0.2,0.1,0\n")
    grid = ("scan", HEXAPOD, "--vary", "x=-2:2:5", "--format", "csv", "--pose")
    one, other = (
        [float(cell) for row in run.out.splitlines()[1:] for cell in row.split(",")]
        for run in (gsp(*grid, "0,0,0.5,1,0.2,0.1,0"), gsp(*grid, f"@{path}"))
    )
    assert one == pytest.approx(other, rel=1e-12)


def test_clearances_of_poses(gsp, tmp_path):
    grid = ("scan", HEXAPOD, "--vary", "x=-2:2:5", "--pose", "0,0,0.5,1,0.2,0.1,0")
    run = gsp(*grid, "--quantity", "clearance", "--format", "csv")
    head, *rows = run.out.splitlines()
    assert head == "x,determinant,condition,clearance"
    alone = gsp(
        "clearance", HEXAPOD, "--of", "pose", "--pose", "2,0,0.5,1,0.2,0.1,0", "--format", "json"
    )
    lower = json.loads(alone.out)["modes"][0]["lower"]
    assert float(rows[-1].split(",")[-1]) == pytest.approx(lower, rel=0.02)
    assert "clearance" not in gsp(*grid, "--format", "csv").out
    picture = tmp_path / "clearance.svg"
    assert gsp(*grid, "--quantity", "clearance", "-o", picture).code == 0
    assert "<svg" in picture.read_text(encoding="utf-8")


def test_values_that_are_none_are_told_before_the_work(gsp):
    run = gsp("scan", "@platform-6-6", "--vary", "1=-2:3:3")
    assert (run.code, run.out) == (2, "")
    assert "--vary: found -2 for constraint 1, expected a distance of at least 0" in run.err
    run = gsp("scan", "@figure-2", "--vary", "2=10:190:3")
    assert "--vary: found 190 for constraint 2, expected an angle of LL from 0 to 180" in run.err


@pytest.mark.parametrize(
    ("spec", "vary", "modes"),
    [
        ("@nano-hexapod", "1=0.078:0.083:3", [4, 8, 8]),
        ("@planar-6-6", "1=1.45:1.75:3", [4, 8, 4]),
        ("@octahedral-3-3", "1=2.25:2.55:3", [8, 4, 0]),
        ("@workspace-study", "1=340:400:3", [4, 8, 12]),
    ],
)
def test_mirror_images_have_a_fold_each(gsp, spec, vary, modes):
    run = gsp("scan", spec, "--vary", vary, "--format", "csv")
    assert [int(line.split(",")[1]) for line in run.out.splitlines()[1:]] == modes
    run = gsp("scan", spec, "--vary", vary, "--folds", "--format", "json")
    assert (run.code, run.err) == (0, "")
    folds = json.loads(run.out)["folds"]
    assert sum(fold["change"] for fold in folds) == modes[-1] - modes[0]
    assert {abs(fold["change"]) for fold in folds} == {2}
    # Two at each value, at different poses, which have that value; between the nodes some modes end
    # and others begin.
    for one, other in zip(folds[::2], folds[1::2], strict=True):
        assert one["1"] == pytest.approx(other["1"], rel=1e-12)
        poses = [[fold[key] for key in ("Tx", "Ty", "Tz", "qw", "qx", "qy", "qz")]
                 for fold in (one, other)]  # fmt: skip
        assert poses[0] != pytest.approx(poses[1], rel=1e-3)
        for pose in poses:
            found = gsp("measure", spec, "--pose", ",".join(map(repr, pose)), "--format", "json")
            value = json.loads(found.out)["poses"][0]["values"][0]
            assert value == pytest.approx(one["1"], rel=1e-9)


def test_curves_of_mirror_images(gsp):
    grid = ("--vary", "1=2.3:2.6:3", "--vary", "2=1:1.3:3")
    run = gsp("scan", "@octahedral-3-3", *grid, "--folds", "--jobs", "1", "--format", "json")
    assert (run.code, run.err) == (0, "")
    document = json.loads(run.out)
    assert len(document["curves"]) % 2 == 0
    places = [(fold["1"], fold["2"]) for fold in document["folds"]]
    assert len(places) == 2 * len({(round(a, 9), round(b, 9)) for a, b in places}) > 0
