"""`gsp workspace`: travels, volumes, boxes, pictures, mistakes."""

from __future__ import annotations

import csv
import json

import pytest

STUDY = "@workspace-study"
SPEC = """\
gsp: 1
units: {length: mm, angle: deg}
platform:
  P1: {point: [0, 0, 0]}
  P2: {point: [0, 1, 0]}
base:
  B1: {point: [0, 0, 0], cone: {axis: [0, 0, 1], half_angle: 60}}
  B2: {point: [9, 3, 0]}
  B3: {point: [0, 9, 4]}
  B4: {point: [1, 1, 1]}
constraints:
  - {distance: [P1, B1], value: 2, range: [1, 3]}
  - {distance: [P1, B2], value: 9}
  - {distance: [P1, B3], value: 9}
  - {distance: [P2, B4], value: 2}
  - {distance: [P2, B2], value: 9}
  - {distance: [P2, B3], value: 9}
"""
HOME = ("--pose", "0,0,2,1,0,0,0")


@pytest.fixture
def spec(tmp_path):
    path = tmp_path / "limited.yaml"
    path.write_text(SPEC)
    return str(path)


def test_travels(gsp, spec):
    run = gsp("workspace", spec, *HOME, "--format", "csv")
    assert run.code == 0
    rows = {row["axis"]: row for row in csv.DictReader(run.out.splitlines())}
    assert list(rows) == ["x", "y", "z", "rx", "ry", "rz"]
    assert (float(rows["z"]["down"]), float(rows["z"]["up"])) == pytest.approx((-1, 1), abs=1e-9)
    assert rows["z"]["up_stops"] == "range 1"
    # The cone ends at the height of two where x is 2 tan 60, the range before that.
    assert float(rows["x"]["up"]) == pytest.approx(5**0.5)
    # About the pivot the first leg does not move; the joint of the others is not limited at P.
    assert rows["rz"]["up_end"] == ""
    assert float(rows["rz"]["up"]) == 180


def test_an_axis_travels_while_another_is_held(gsp, spec):
    held = ("--shift", "z=-2", "--shift", "z=-0.8", "--shift", "z=0:1:2")
    run = gsp("workspace", spec, *HOME, *held, "--format", "json")
    document = json.loads(run.out)
    assert document["schema"] == "gsp.workspace/1"
    ups = {row["held"]["z"]: row["up"] for row in document["travel"] if row["axis"] == "x"}
    # At height zero the leg has no direction and length zero; then the cone, then the range.
    assert ups[-2] is None
    assert ups[-0.8] == pytest.approx(1.2 * 3**0.5)
    assert ups[0] == pytest.approx(5**0.5)
    assert ups[1] == pytest.approx(0, abs=1e-6)


def test_volumes(gsp, spec):
    run = gsp("workspace", spec, "--orientation", "1,0,0,0", "--gap", "0.1", "--format", "json")
    document = json.loads(run.out)
    volume = document["volume"]
    sector = 3.141592653589793 * 26 * (1 - 0.5) * 2 / 3
    assert volume["lower"] <= sector <= volume["upper"]
    assert volume["gap"] <= 0.1
    assert document["travel"] is None
    run = gsp("workspace", spec, *HOME, "--position", "0,0,1.5", "--gap", "0.1")
    assert run.code == 0
    assert "between 1 and 1 of all rotations can be reached" in run.out


def test_boxes_are_poses_to_look_at(gsp, spec, tmp_path):
    path = tmp_path / "boxes.csv"
    run = gsp("workspace", spec, *HOME, "--over", "x,z", "--boxes", "--gap", "0.5", "-o", path)
    assert run.code == 0
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert {row["status"] for row in rows} == {"inside", "open"}
    for row in rows:
        middle = (float(row["x_low"]) + float(row["x_high"])) / 2
        assert float(row["x"]) == pytest.approx(middle)
    page = tmp_path / "page.html"
    assert gsp("view", STUDY, "--track", path, "-o", page).code == 0
    assert "inside" in page.read_text()


def test_bounds_that_stay_apart_are_told(gsp):
    run = gsp("workspace", STUDY, "--over", "x,y,z", "--most-boxes", "5000")
    assert run.code == 4
    assert "can be reached" in run.out
    assert "more than --gap 0.01" in run.err


@pytest.mark.parametrize("over", ["x,z", "x,y,z", "rx,z"])
def test_pictures(gsp, tmp_path, over):
    path = tmp_path / "slices.svg"
    run = gsp("workspace", STUDY, "--over", over, "--gap", "0.4", "-o", path)
    assert run.code == 0, run.err
    assert path.read_bytes().startswith(b"<?xml")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--mode", "1", *HOME), "give either --mode or --pose"),
        (("--mode", "99"), "found mode 99, expected one of the"),
        (("--over", "x,q"), "--over: found 'x,q', expected one or more of"),
        (("--boxes",), "boxes and pictures need --orientation, --position or --over"),
        (("--over", "x", "--shift", "z=1"), "--shift is for the travel of axes"),
        (("--over", "x", "--within", "x=1"), "--within: found 'x=1', expected NAME=LOW:HIGH"),
        (("--over", "x", "--within", "x=1:2:3"), "--within: found 'x=1:2:3'"),
        (("--over", "x", "--within", "y=1:2"), "within: found y, expected a parameter that varies"),
        (("--shift", "q=1"), "--shift: found 'q=1', expected NAME=LOW:HIGH:COUNT"),
        (("--shift", "z=1:2:99999"), "--shift: found 99999 values, expected at most 1000"),
        (
            ("--orientation", "1,0,0"),
            "--orientation: found '1,0,0', expected qw,qx,qy,qz, or rx,ry,rz",
        ),
        (("--orientation", "1,0,0,x"), "--orientation: qz: found 'x'"),
        (("--position", "1,2"), "--position"),
        (("--pose", "0,0,9999,1,0,0,0"), "home does not keep the limits: the value 9999.98"),
        (("--orientation", "1,0,0,0", "--position", "0,0,1"), "give --over, too"),
    ],
)
def test_mistakes(gsp, arguments, message):
    run = gsp("workspace", STUDY, *arguments)
    assert run.code == 2
    assert run.out == ""
    assert message in run.err


def test_home_is_the_mode_that_keeps_the_limits(gsp):
    run = gsp("workspace", STUDY)
    assert run.code == 0
    assert "position (0, 0, 400)" in run.out
    run = gsp("workspace", "@platform-6-6")
    assert run.code == 2
    assert "no constraint has a range and no joint a cone" in run.err


CAMERA = ("workspace", "@rubin-camera", "--orientation", "1,0,0,0", "--gap", "0.5")


def test_only_what_is_connected_with_a_stated_home_is_counted(gsp):
    run = gsp(*CAMERA, "--format", "json")
    whole = gsp(*CAMERA, "--all-parts", "--format", "json")
    document, every = json.loads(run.out), json.loads(whole.out)
    assert (document["connected"], every["connected"]) == (True, False)
    # 3.2e-5 and 6.4e-5 m^3, the mirror image as large as the half at home.
    assert document["volume"]["lower"] < 3.2e-5 < document["volume"]["upper"]
    assert every["volume"]["lower"] < 6.4e-5 < every["volume"]["upper"]
    assert every["volume"]["lower"] > 1.3 * document["volume"]["lower"]
    assert (document["modes_inside"], every["modes_inside"]) == ([], [7, 8])
    assert run.err == "home is mode 8: nearest to the stated home\n"


def test_values_that_no_motor_drives_and_no_range_holds_are_named(gsp):
    said = "values that may change on the way, without a range: 4, 5 and 6"
    assert said in gsp("workspace", "@three-prs").out
    assert "without a range" not in gsp("workspace", "@reachy-mini-head").out
