"""`gsp workspace` and `gsp clearance` of machines whose motors turn arms or move carriages."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from gspcli import Point, example
from gspcli.geometry.drives import Drives
from gspcli.motion.singularities.clearances import clearance
from tests.support.independent_machines import machines

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


def test_knees_are_those_of_home_wherever_one_starts(gsp, head):
    """Another start on the same part has the same ends in z."""
    words = ("workspace", head, "--all-parts", "--format", "json")
    one = travel(gsp(*words, "--pose", "0,0,0.177,1,0,0,0"))["z"]
    other = travel(gsp(*words, "--pose", "0,0,0.17,1,0,0,0"))["z"]
    assert one["up"] - other["up"] == pytest.approx(-0.007, abs=1e-9)
    assert one["down"] - other["down"] == pytest.approx(-0.007, abs=1e-9)


def test_clearance_is_about_drives(gsp, head):
    (row,) = json.loads(gsp("clearance", head, "--format", "json").out)["modes"]
    assert 0 < row["knees"] <= row["lower"] < row["upper"]
    assert row["knees"] < row["dead_point"]
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
    drives = Drives.of(machine)
    there = drives.instance_at(drives.inverse(R, T))
    alone = clearance(there, R[None], T[None], of="values").lower[0]
    assert values["modes"][0]["lower"] == pytest.approx(alone, rel=1e-6)
    stated = clearance(replace(machine, constraints=tuple(
        replace(row, base=Point(row.base.position)) for row in machine.constraints
    )), R[None], T[None], of="values").lower[0]  # fmt: skip
    assert abs(stated / alone - 1) > 1e-3
    run = gsp("clearance", head, "--pose", "0,0,0.5,1,0,0,0", "--of", "values")
    assert "the drives do not reach pose 1" in run.err
