"""`gsp workspace`."""

from __future__ import annotations

import csv
import io
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from gspcli import Point, example
from gspcli.geometry.machine import Machine
from gspcli.motion.singularities.clearances import clearance
from gspcli.resources import instance_files
from tests.support.independent_machines import machines

# `gsp workspace`: travels, volumes, boxes, pictures, mistakes.


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
        (("--boxes",), "--boxes is for --over, --orientation or --position"),
        (("--over", "x", "--shift", "z=1"), "--over: not with --shift"),
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


def test_values_that_stay_are_named(gsp):
    said = "fixed values, kept by all: 4, 5 and 6"
    assert said in gsp("workspace", "@three-prs").out
    assert "fixed value" not in gsp("workspace", "@reachy-mini-head").out


# `gsp workspace` and `gsp clearance` of machines whose motors turn arms or move carriages.


#: Two rods each on three carriages, vertical rails; positions only.
DELTA = """\
gsp: 1
units: {length: mm, angle: deg}
platform:
  P1: {point: [30, 50, 0]}
  P2: {point: [-30, 50, 0]}
  P3: {point: [-58.30127018922193, 0.9807621135331594, 0]}
  P4: {point: [-28.30127018922193, -50.98076211353316, 0]}
  P5: {point: [28.30127018922193, -50.98076211353316, 0]}
  P6: {point: [58.30127018922193, 0.9807621135331594, 0]}
base:
  B1: {point: [30, 200, 250], slide: {direction: [0, 0, 1], range: [-100, 100]}}
  B2: {point: [-30, 200, 250], with: B1}
  B3: {point: [-188.20508075688775, -74.01923788646684, 250],
       slide: {direction: [0, 0, 1], range: [-100, 100]}}
  B4: {point: [-158.20508075688775, -125.98076211353316, 250], with: B3}
  B5: {point: [158.20508075688775, -125.98076211353316, 250],
       slide: {direction: [0, 0, 1], range: [-100, 100]}}
  B6: {point: [188.20508075688775, -74.01923788646684, 250], with: B5}
home: {position: [0, 0, 0], quaternion: [1, 0, 0, 0]}
constraints:
  - {distance: [P1, B1], value: home}
  - {distance: [P2, B2], value: home}
  - {distance: [P3, B3], value: home}
  - {distance: [P4, B4], value: home}
  - {distance: [P5, B5], value: home}
  - {distance: [P6, B6], value: home}
"""


@pytest.fixture
def delta(tmp_path):
    path = tmp_path / "delta.yaml"
    path.write_text(DELTA)
    return str(path)


@pytest.fixture
def head(tmp_path):
    """Reachy's head with ranges of 45 degrees."""
    from gspcli.spec import dumps

    path = tmp_path / "head.yaml"
    path.write_text(dumps(machines()["reachy 45"]().instance))
    return str(path)


def travel(run):
    assert run.code == 0, run.err
    return {row["axis"]: row for row in json.loads(run.out)["travel"]}


def test_a_head_moves_and_what_ends_its_travel_is_named(gsp, head):
    rows = travel(gsp("workspace", head, "--all-parts", "--format", "json"))
    assert all(row["up"] > 0 > row["down"] for row in rows.values())
    named = " ".join(row["up_stops"] + " " + row["down_stops"] for row in rows.values())
    assert "range crank B" in named
    # Motors without ranges end where their rods are stretched or folded.
    free = travel(gsp("workspace", "@t-top-head", "--format", "json"))
    assert all(row["up_stops"].startswith("reach B") for row in free.values())


def test_travel_ends_where_a_motor_does(gsp, head):
    """At the end of z a crank is at 45 degrees, by its own inverse kinematics."""
    rows = travel(gsp("workspace", head, "--all-parts", "--format", "json"))
    run = gsp(
        "measure", head, "--pose", f"0,0,{0.177 + rows['z']['up']},1,0,0,0", "--drives",
        "--format", "json",
    )  # fmt: skip
    assert run.code == 0, run.err
    text = json.dumps(json.loads(run.out))
    assert "44.99999" in text or "45.0" in text


def test_both_bounds_enclose_a_sum_of_poses(gsp, head):
    from tests.support.independent_machines import PlaneGeometry

    run = gsp(
        "workspace", head, "--over", "x,z", "--within", "x=-0.08:0.08", "--within", "z=0.1:0.25",
        "--all-parts", "--gap", "0.02", "--format", "json",
    )  # fmt: skip
    assert run.code == 0, run.err
    volume = json.loads(run.out)["volume"]
    x, z = np.meshgrid(np.linspace(-0.08, 0.08, 401), np.linspace(0.1, 0.25, 401))
    T = np.stack((x.ravel(), np.zeros(x.size), z.ravel()), axis=1)
    machine = machines()["reachy 45"]()
    T[:, 1] = machine.T[1]
    share = PlaneGeometry(machine).reached(np.repeat(np.eye(3)[None], len(T), 0), T).mean()
    area = 0.16 * 0.15 * share
    assert volume["lower"] * 0.995 < area < volume["upper"] * 1.005


def test_connected_is_no_more_than_all_parts(gsp, head):
    words = ("workspace", head, "--over", "z,rx", "--gap", "0.05", "--format", "json")
    part, whole = (json.loads(gsp(*words, *more).out) for more in ((), ("--all-parts",)))
    assert part["connected"]
    assert part["volume"]["gap"] <= 0.05
    assert 0 < part["volume"]["lower"] <= whole["volume"]["upper"]


def test_a_delta_is_judged_where_its_rods_are_parallel(gsp, delta):
    run = gsp("workspace", delta, "--format", "json")
    rows = travel(run)
    assert list(rows) == ["x", "y", "z"]
    # Straight up all carriages move alike, by their range.
    assert rows["z"]["up"] == pytest.approx(100, rel=1e-9)
    assert rows["z"]["down"] == pytest.approx(-100, rel=1e-9)
    assert rows["z"]["up_stops"].startswith("range slide B")


def test_a_delta_that_turns_is_refused_with_advice(gsp, delta):
    run = gsp("workspace", delta, "--over", "z,rz")
    assert (run.code, run.out) == (2, "")
    assert "rods 1 and 2 share slide B1" in run.err
    assert "three distances (DPP) and three angles" in run.err
    run = gsp("workspace", delta, "--orientation", "0.99,0.1,0,0")
    assert (run.code, run.out) == (2, "")
    assert "are not parallel at this orientation" in run.err


def test_home_out_of_reach_says_so(gsp, head):
    run = gsp("workspace", head, "--pose", "0,0,0.5,1,0,0,0")
    assert (run.code, run.out) == (2, "")
    assert "rod 1 does not reach crank B1" in run.err


def test_working_modes_are_those_of_home_wherever_one_starts(gsp, head):
    """Another start on the same part has the same ends in z."""
    words = ("workspace", head, "--all-parts", "--format", "json")
    one = travel(gsp(*words, "--pose", "0,0,0.177,1,0,0,0"))["z"]
    other = travel(gsp(*words, "--pose", "0,0,0.17,1,0,0,0"))["z"]
    assert one["up"] - other["up"] == pytest.approx(-0.007, abs=1e-9)
    assert one["down"] - other["down"] == pytest.approx(-0.007, abs=1e-9)


def test_clearance_is_about_drives(gsp, head):
    (row,) = json.loads(gsp("clearance", head, "--format", "json").out)["modes"]
    assert 0 < row["working_modes"] <= row["lower"] < row["upper"]
    assert row["working_modes"] < row["dead_point"]
    assert row["drive"].startswith("crank.B")
    # In half the range of 45 degrees; the nearest fold is 15.56 degrees away.
    assert row["upper"] * 45 == pytest.approx(15.56, rel=1e-3)


def test_clearance_of_values_keeps_its_keys(gsp, head):
    document = json.loads(gsp("clearance", head, "--of", "values", "--format", "json").out)
    assert document["of"] == "values"
    assert {"by", "constraint", "values"} <= set(document["modes"][0])


def test_clearances_have_the_joints_where_the_motors_have_them(gsp):
    """What is required of rows is the clearance of the drives; that of a pose is refused."""
    pose = ("--pose", "0,0,0.165,1,0,0,0")
    head = "@t-top-head"
    row = json.loads(gsp("clearance", head, *pose, "--format", "json").out)["modes"][0]
    run = gsp("measure", head, *pose, "--require", "clearance>=0.5", "--format", "json")
    assert json.loads(run.out)["requirements"][0]["worst"] == pytest.approx(row["lower"])
    run = gsp("measure", head, *pose, "--require", "pose-clearance>=0")
    assert run.code == 2
    assert "pose-clearance: not known of machines with cranks or slides" in run.err
    run = gsp("clearance", head, *pose, "--of", "pose")
    assert run.code == 2
    assert "not known of the pose of a machine with cranks or slides" in run.err
    # With the drives still where they are at the pose, the values are those of the rods.
    values = json.loads(gsp("clearance", head, *pose, "--of", "values", "--format", "json").out)
    machine, R, T = example("t-top-head"), np.eye(3), np.array([0, 0, 0.165])
    drives = Machine.of(machine)
    there = drives.instance_at(drives.inverse(R, T))
    alone = clearance(there, R[None], T[None], of="values").lower[0]
    assert values["modes"][0]["lower"] == pytest.approx(alone, rel=1e-6)
    stated = clearance(replace(machine, constraints=tuple(
        replace(row, base=Point(row.base.position)) for row in machine.constraints
    )), R[None], T[None], of="values").lower[0]  # fmt: skip
    assert abs(stated / alone - 1) > 1e-3
    run = gsp("clearance", head, "--pose", "0,0,0.5,1,0,0,0", "--of", "values")
    assert "the drives do not reach pose 1" in run.err


# Gaps between legs in the commands that know them.


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
