"""`gsp track`."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gspcli
from gspcli.geometry.machine import Machine
from gspcli.geometry.numbers import Number
from gspcli.motion.singularities.clearances import clearances

EXAMPLES = Path(__file__).parents[2] / "data" / "examples"
HEXAPOD = str(EXAMPLES / "platform-6-6.yaml")
#: The two modes of the example meet and vanish between the first rows.
LOSS = "t,1,2,3,4\n0,2.53,2.08,0.93,1.97\n1,2.6,2.0,1.0,1.9\n"
SAFE = "t,1,2\n0,2.53,2.08\n1,2.54,2.07\n2,2.53,2.08\n"
FOLD = (
    "mode 1 meets mode 2 in a fold at t = 0.718860610004 and ends, proved\n"
    "mode 2 meets mode 1 in a fold at t = 0.718860610004 and ends, proved\n"
)


@pytest.fixture
def values(tmp_path):
    def write(text):
        path = tmp_path / "values.csv"
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


def test_rows_of_all_modes(gsp, values):
    run = gsp("track", HEXAPOD, values(SAFE), "--format", "csv")
    assert (run.code, run.err) == (0, "")
    assert run.out.splitlines()[0] == "t,mode,x,y,z,qw,qx,qy,qz,condition"
    rows = list(csv.DictReader(io.StringIO(run.out)))
    assert [(row["t"], row["mode"]) for row in rows] == [
        (t, mode) for t in ("0.0", "1.0", "2.0") for mode in "12"
    ]
    # The last row has the values of the first, and no mode has become another.
    for first, last in zip(rows[:2], rows[-2:], strict=True):
        for key in ("x", "y", "z", "qw", "qx", "qy", "qz"):
            assert float(first[key]) == pytest.approx(float(last[key]), abs=1e-12)


def test_what_track_writes_measure_reads(gsp, values, tmp_path):
    given = values(SAFE)
    path = tmp_path / "poses.csv"
    assert gsp("track", HEXAPOD, given, "--mode", "2", "-o", path).code == 0
    run = gsp("measure", HEXAPOD, path, "--format", "csv")
    rows = [[float(x) for x in line.split(",")] for line in run.out.splitlines()[1:]]
    assert [row[0] for row in rows] == [0, 1, 2]
    assert rows[1][1:] == pytest.approx([2.54, 2.07, 0.93, 1.97, 1.46, 1.73], abs=1e-12)
    # And what measure writes, track reads.
    back = tmp_path / "values.csv"
    assert gsp("measure", HEXAPOD, path, "-o", back).code == 0
    near = gsp("track", HEXAPOD, back, "--near", "0.5,0.9,0.46,0.19,0.25,-0.86,-0.4")
    assert near.code == 0
    assert [line.split()[1] for line in near.out.splitlines()[4:7]] == ["2", "2", "2"]


def test_a_loss_is_told_and_changes_the_exit_code(gsp, values):
    run = gsp("track", HEXAPOD, values(LOSS))
    assert run.code == 4
    assert run.err == (
        FOLD + "error: modes 1, 2 end before the last row\nuse --allow-loss if that is expected\n"
    )
    assert "2 modes, 0 of them from the first row to the last" in run.out
    allowed = gsp("track", HEXAPOD, values(LOSS), "--allow-loss")
    assert (allowed.code, allowed.err) == (0, FOLD)
    assert allowed.out == run.out


def test_json_has_the_events(gsp, values):
    run = gsp("track", HEXAPOD, values(LOSS), "--allow-loss", "--format", "json")
    assert (run.code, run.err) == (0, "")
    document = json.loads(run.out)
    assert document["schema"] == "gsp.track/1"
    assert document["certified"] is True
    assert document["modes"] == [1, 2]
    event = document["events"][0]
    low, high = event["t"]
    assert low <= high < low + 1e-14
    assert (event["kind"], event["partner"], event["begins"]) == ("fold", 2, False)


def test_born_modes(gsp, values):
    backwards = "t,1,2,3,4\n0,2.6,2.0,1.0,1.9\n1,2.53,2.08,0.93,1.97\n"
    run = gsp("track", HEXAPOD, values(backwards), "--complete")
    assert run.code == 0
    assert "mode 1 begins with mode 2 in a fold at t = 0.281139389996, proved" in run.err
    assert "every real pose at the last row is accounted for" in run.out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("-", "-"), "SPEC and VALUES cannot both be standard input"),
        ((HEXAPOD, "no.csv"), "error: no.csv: cannot be read: No such file or directory\n"),
        (
            (HEXAPOD, "VALUES", "--mode", "5"),
            "error: found mode 5, expected one of those at the first row: 1, 2\n",
        ),
        ((HEXAPOD, "VALUES", "--mode", "1", "--near", "1"), "give either --mode or --near"),
    ],
)
def test_mistakes(gsp, values, arguments, message):
    path = values(SAFE)
    run = gsp("track", *(path if word == "VALUES" else word for word in arguments))
    assert run.code == 2
    assert run.out == ""
    assert message in run.err


def test_cranks_of_a_rotary_platform(gsp, values):
    angles = values("t,crank.B1,crank.B4\n0,0,0\n1,20,-15\n")
    run = gsp("track", "@t-top-head", angles, "--complete", "--allow-loss", "--format", "json")
    assert run.code == 0
    document = json.loads(run.out)
    assert document["complete"] is document["certified"] is True
    assert document["coordinates"] == {"crank.B1": [0, 20], "crank.B4": [0, -15]}
    assert all(event["kind"] == "fold" for event in document["events"])


def test_without_a_real_pose_at_the_first_row_there_is_nothing_to_follow(gsp, tmp_path):
    path = tmp_path / "values.csv"
    path.write_text("1\n0.001\n2.53\n", encoding="utf-8")
    run = gsp("track", "@platform-6-6", path)
    assert (run.code, run.out) == (2, "")
    assert "error: there is no real pose at the first row\n" in run.err
    run = gsp("track", "@platform-6-6", path, "--complete", "--format", "csv")
    assert run.code == 0
    assert [line.split(",")[1] for line in run.out.splitlines()[1:]] == ["1", "2"]
    assert "mode 1 begins with another in a fold" in run.err


def test_drives_that_move_are_columns_for_the_view(gsp, tmp_path):
    path = tmp_path / "cranks.csv"
    path.write_text("crank.B1,crank.B2\n0,0.01\n4,0.02\n", encoding="utf-8")
    options = ("--mode", "1", "--relative", "--format", "csv", "-o", tmp_path / "track.csv")
    run = gsp("track", "@t-top-head", path, *options)
    assert run.code == 0
    head, *rows = (tmp_path / "track.csv").read_text(encoding="utf-8").splitlines()
    assert head.endswith("condition,crank.B1,crank.B2")
    assert [row.split(",")[-2] for row in rows] == ["0.0", "4.0"]
    run = gsp("view", "@t-top-head", "--track", tmp_path / "track.csv", "-o", tmp_path / "a.html")
    assert run.code == 0
    assert "2 poses (trajectory of mode 1)" in run.err


def test_cones_that_are_kept_and_left_between_rows(gsp, tmp_path):
    path = tmp_path / "path.csv"
    near = ("--near", "0,0,60,1,0,0,0")
    for far, kept in ((20, True), (45, False)):
        path.write_text(f"x,y,z,qw,qx,qy,qz\n0,0,60,1,0,0,0\n{far},5,62,1,0.02,0,0\n", "utf-8")
        run = gsp("track", "@workspace-study-cones", path, *near)
        assert run.code == 0
        note = "mode 8 keeps all cones from beginning to end, between rows too: proved"
        assert (note in run.out) == kept
        left = "mode 8: leg 2 leaves its cone at the base at t = 1.99462326, proved"
        assert (left in run.err) != kept
        document = json.loads(
            gsp("track", "@workspace-study-cones", path, *near, "--format", "json").out
        )
        assert [event["proved"] for event in document["limits"]] == ([] if kept else [True])


def test_requirements_hold_at_all_rows(gsp, tmp_path):
    path = tmp_path / "path.csv"
    near = ("--near", "0,0,60,1,0,0,0")
    path.write_text("t,x,y,z,qw,qx,qy,qz\n0,0,0,60,1,0,0,0\n3,20,5,62,1,0.02,0,0\n", "utf-8")
    require = ("--require", "range, cone, clearance>=0.01, condition<=100")
    run = gsp("track", "@workspace-study-cones", path, *near, *require)
    assert run.code == 0
    for name in ("range <= 1", "cone <= 1", "clearance >= 0.01", "condition <= 100"):
        assert f"\n{name}: met, between rows too; worst " in run.out
    assert "(t = 3), mode 8, leg " in run.out
    require = ("--require", "cone<=0.1, condition<=1")
    run = gsp("track", "@workspace-study-cones", path, *near, *require, "--format", "json")
    assert run.code == 1
    assert run.err == "error: not met: cone <= 0.1 and condition <= 1\n"
    cone, condition = json.loads(run.out)["requirements"]
    assert (cone["met"], cone["row"], cone["t"], cone["mode"]) == (False, 2, 3.0, 8)
    assert condition["worst"] > 1


def test_limits_are_required_between_the_rows_too(gsp, tmp_path):
    text = (Path(HEXAPOD).parent / "six-planes.yaml").read_text(encoding="utf-8")
    # The first point begins near its plane and crosses it.
    text = text.replace(
        "h1: {plane: {point: [0.85, -0.12, 0.91]", "h1: {plane: {point: [0.39, 0.21, 1.075]"
    )
    text = text.replace("value: 0.59, side: negative", "value: 0.01, side: both, range: [0.005, 1]")
    spec, path = tmp_path / "spec.yaml", tmp_path / "values.csv"
    spec.write_text(text, encoding="utf-8")
    path.write_text("1\n0.01\n-0.01\n", encoding="utf-8")
    run = gsp("track", spec, path, "--require", "range")
    assert run.code == 1
    assert "range <= 1: NOT met; worst 0.98" in run.out
    assert "constraint 1 left between rows at t = 1.25" in run.out


NANO = "1,2,3,4,5,6\n.118,.117,.118,.116,.118,.118\n.117,.117,.117,.117,.117,.117\n"


def test_modes_have_the_numbers_of_solve(gsp, values):
    """Home is the same mode in solve, and in a track that begins at other values."""
    given = values(NANO)
    listed = json.loads(gsp("solve", "@nano-hexapod", "--format", "json").out)
    home = listed["home"]["mode"]
    run = gsp("track", "@nano-hexapod", given, "--mode", "home", "--format", "json")
    document = json.loads(run.out)
    assert run.err == f"home is mode {home}: nearest to the stated home\n"
    assert (document["modes"], document["new"]) == ([home], [])
    assert document["poses"][0]["z"] > 0.1


def test_a_track_of_poses_follows_the_mode_of_these_poses(gsp, values):
    given = values("x,y,z,rx,ry,rz\n0,0,0.09,0,0,0\n0.001,0,0.091,1,0,0\n")
    run = gsp("track", "@nano-hexapod", given, "--euler", "ZYX", "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(run.out)))
    assert [(row["mode"], round(float(row["z"]), 9)) for row in rows] == [("8", 0.09), ("8", 0.091)]
    every = gsp(
        "track", "@nano-hexapod", given, "--euler", "ZYX", "--all-modes", "--allow-loss",
        "--format", "csv",
    )  # fmt: skip
    found = {row["mode"] for row in csv.DictReader(io.StringIO(every.out))}
    assert found == set("12345678")


def test_modes_that_are_new_are_named(gsp, values):
    given = values("1,2,3,4,5,6\n.6,.35,.55,.6,.35,.55\n.6,.35,.55,.6,.35,.55\n")
    run = gsp("track", "@rubin-m2", given, "--format", "json")
    new = json.loads(run.out)["new"]
    assert all(number > 2 for number in new)
    told = gsp("track", "@rubin-m2", given).err
    assert ("new, not reached from the 2 real poses of SPEC" in told) == bool(new)


FAR = "x,y,z,rx,ry,rz\n2,-2,-43,21,0,0\n{between}9,-12,-81,-21,0,0\n"


def test_a_mode_that_comes_to_another_pose_than_that_of_the_file_is_told(gsp, values):
    """Values that change linearly between far poses lead to another pose with the same values."""
    words = ["@apo-tertiary", values(FAR.format(between="")), "--euler", "xyz", "--mode", "1"]
    run = gsp("track", *words)
    assert run.code == 4
    assert run.err.splitlines()[-3:] == [
        "error: row 2 (t = 2): mode 1 is not at the pose of the file, but 39.2 mm and 42.7 deg "
        "away",
        "between rows the values change linearly, and another pose has these values, too",
        "give more poses before row 2",
    ]
    for more in (["--all-modes", "--allow-loss"], ["--steps", "3"]):
        again = gsp("track", *words[:-2], *more, "--format", "json")
        (entry,) = json.loads(again.out)["departures"]
        assert (again.code, entry["mode"], entry["row"], entry["t"]) == (4, 1, 2, 2)
        assert entry["distance"] == pytest.approx(39.2, abs=0.1)


def test_a_mode_that_keeps_to_the_poses_is_not_told(gsp, values):
    # The way of the poses, in steps.
    rows = "".join(
        f"{2 + 7 * s},{-2 - 10 * s},{-43 - 38 * s},{21 - 42 * s},0,0\n"
        for s in (k / 64 for k in range(1, 29))
    )
    text = FAR.format(between=rows).rsplit("\n", 2)[0] + "\n"
    run = gsp("track", "@apo-tertiary", values(text), "--euler", "xyz", "--format", "json")
    assert (run.code, json.loads(run.out)["departures"]) == (0, [])


ROTARY = ("base=80,12", "platform=55,10", "horn=24", "rod=130")


@pytest.fixture
def rotary(gsp, tmp_path):
    path = tmp_path / "rotary.yaml"
    path.write_text(gsp("new", "--rotary", *ROTARY).out, encoding="utf-8")
    return path


POSES = "x,y,z,qw,qx,qy,qz\n0,0,122.7088874892,1,0,0,0\n5,0,120,1,0.05,0,0\n0,0,125,1,0,0,0.1\n"


def test_drives_of_poses_lead_through_the_poses(gsp, rotary, tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text(POSES, encoding="utf-8")
    run = gsp("track", rotary, path, "--format", "json", "--require", "range, transmission>=0.5")
    assert run.code == 0
    found = json.loads(run.out)
    assert found["certified"]
    assert found["departures"] == []
    assert list(found["coordinates"]) == [f"crank.B{k}" for k in range(1, 7)]
    motors = tmp_path / "motors.csv"
    motors.write_text(gsp("measure", rotary, path, "--drives", "--format", "csv").out, "utf-8")
    again = json.loads(gsp("track", rotary, motors, "--mode", "home", "--format", "json").out)
    assert again["poses"][-1]["z"] == pytest.approx(125, abs=1e-9)
    assert again["coordinates"] == found["coordinates"]


def test_dead_points_and_ranges_of_drives_are_told(gsp, rotary, tmp_path):
    path = tmp_path / "angles.csv"
    path.write_text("crank.B1,crank.B2\n0,0\n70,-65\n", encoding="utf-8")
    run = gsp("track", rotary, path, "--mode", "home", "--steps", "4", "--require", "range")
    assert run.code == 1
    assert "rod 1 passes a dead point of crank.B1 between t = 1.75 and 2" in run.err
    # 60 of 70 and of 65 degrees.
    assert f"crank.B1 leaves its range from -60 to 60 at t = {1 + 60 / 70:.10g}" in run.err
    assert f"crank.B2 leaves its range from -60 to 60 at t = {1 + 60 / 65:.10g}" in run.err
    run = gsp("track", rotary, path, "--mode", "home", "--steps", "4", "--format", "json")
    kinds = [(one["kind"], one["drive"]) for one in json.loads(run.out)["limits"]]
    assert kinds == [("dead point", "crank.B1"), ("range", "crank.B1"), ("range", "crank.B2")]


def test_columns_of_drives_are_readings(gsp, rotary, tmp_path):
    """A gear of one half and an offset: other readings of the same motion."""
    text = rotary.read_text(encoding="utf-8")
    geared = tmp_path / "geared.yaml"
    geared.write_text(text.replace("range: [-60, 60]", "scale: -0.5, offset: 5"), encoding="utf-8")
    path, other = tmp_path / "a.csv", tmp_path / "b.csv"
    names = ",".join(f"crank.B{k}" for k in range(1, 7))
    path.write_text(f"{names}\n0,0,0,0,0,0\n20,10,-5,15,0,5\n", encoding="utf-8")
    other.write_text(f"{names}\n-10,-10,-10,-10,-10,-10\n30,10,-20,20,-10,0\n", encoding="utf-8")
    first, second = (
        json.loads(gsp("track", spec, table, "--mode", "home", "--format", "json").out)
        for spec, table in ((rotary, path), (geared, other))
    )
    assert second["coordinates"]["crank.B1"] == pytest.approx([-10, 30])
    for a, b in zip(first["poses"], second["poses"], strict=True):
        assert {k: pytest.approx(v, abs=1e-9) for k, v in a.items()} == b


def test_cones_turn_with_their_arms_also_between_rows(gsp, rotary, tmp_path):
    cone = "cone: {axis: [0, 0, 1], half_angle: 30}, crank"
    rotary.write_text(rotary.read_text("utf-8").replace("crank", cone), encoding="utf-8")
    path = tmp_path / "angles.csv"
    names = ",".join(f"crank.B{k}" for k in range(1, 7))
    path.write_text(f"{names}\n0,0,0,0,0,0\n45,45,45,45,45,45\n", encoding="utf-8")
    # The rods stay nearly upright, and the cones turn by 45 degrees.
    run = gsp("track", rotary, path, "--mode", "home", "--format", "json")
    events = [one for one in json.loads(run.out)["limits"] if one["kind"] == "cone"]
    assert len(events) == 6
    assert all(one["leaves"] and one["proved"] for one in events)


# `gsp track` as a check of files of poses: straight ways, and requirements between the rows.


TRACK_SAFETY_POSES = """t,x,y,z,rx,ry,rz
0,0,0,400,0,0,0
1,30,0,410,5,0,0
2,30,30,400,5,5,10
3,0,0,400,0,0,0
"""
REQUIRE = "range, condition<=12, clearance>=0.04"


@pytest.fixture
def poses(tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text(TRACK_SAFETY_POSES, encoding="utf-8")
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
    assert f"the value of constraint {leg + 1} leaves its range" in run.err
    assert f"constraint {leg + 1} left between rows" in run.out
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
    clear = clearances(
        Machine.of(gspcli.example("three-prs")), np.tile(np.eye(3), (len(T), 1, 1)), T
    )[0]
    assert [row["clearance"] for row in poses] == pytest.approx(clear, rel=1e-9)


def test_a_range_of_a_slide_that_is_left_is_named(gsp, tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text("x,y,z,rx,ry,rz\n0,0,4.8,0,0,0\n0,0,5.2,0,0,0\n", encoding="utf-8")
    run = gsp(
        "track", "@three-prs", path, "--euler", "ZYX", "--along", "poses", "--require", "range"
    )
    assert run.code == 1
    assert "slide.B1 leaves its range from -1 to 1 at t = 1.49999999" in run.err
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
    path.write_text(
        TRACK_SAFETY_POSES.replace(",400,", ",0,").replace(",410,", ",10,"), encoding="utf-8"
    )
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
        (TRACK_SAFETY_POSES, ("--mode", "16"), "leave out --mode, --near, --all-modes"),
        (TRACK_SAFETY_POSES, ("--complete",), "leave out --mode, --near, --all-modes"),
    ],
)
def test_what_does_not_go_with_straight_ways(gsp, tmp_path, text, words, message):
    path = tmp_path / "file.csv"
    path.write_text(text, encoding="utf-8")
    more = ("--euler", "ZYX", "--along", "poses", *words)
    run = gsp("track", "@workspace-study", str(path), *more)
    assert (run.code, run.out) == (2, "")
    assert message in run.err
