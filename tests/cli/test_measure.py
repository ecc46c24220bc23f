from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "data" / "examples"
HEXAPOD = str(EXAMPLES / "platform-6-6.yaml")
PLANES = str(EXAMPLES / "six-planes.yaml")


def test_solve_and_measure_give_the_values_of_the_file(gsp, tmp_path):
    for form in ("json", "csv"):
        path = tmp_path / f"poses.{form}"
        path.write_text(gsp("solve", HEXAPOD, "--format", form).out, encoding="utf-8")
        run = gsp("measure", HEXAPOD, path, "--format", "csv")
        assert (run.code, run.err) == (0, "")
        head, *rows = run.out.splitlines()
        assert head == "t,1,2,3,4,5,6"
        assert len(rows) == 2
        for number, row in enumerate(rows, 1):
            t, *values = map(float, row.split(","))
            assert t == number
            assert values == pytest.approx([2.53, 2.08, 0.93, 1.97, 1.46, 1.73], abs=1e-12)


def test_table_of_signed_distances(gsp):
    run = gsp("measure", PLANES, "--pose", "1,2,3,2,0,0,0")
    assert run.code == 0
    assert run.out == (
        "Six points on six planes: DPH DPH DPH DPH DPH DPH\n"
        "\n"
        "t     1 DPH      2 DPH     3 DPH     4 DPH      5 DPH    6 DPH\n"
        "──────────────────────────────────────────────────────────────\n"
        "1  -1.49610  -0.803623  -1.61942  -1.25493  -0.337960  3.29220\n"
        "\n"
        "distances in unit, angles in deg; DPH and DHP signed, positive where the normal points\n"
    )


def test_json_has_values_and_sides(gsp):
    run = gsp("measure", PLANES, "--pose", "1,2,3,1,0,0,0", "--format", "json")
    document = json.loads(run.out)
    assert document["schema"] == "gsp.measure/1"
    (pose,) = document["poses"]
    assert pose["t"] == 1
    assert pose["values"][5] == pytest.approx(3.2922, abs=1e-4)
    assert pose["sides"] == {str(k): "positive" if k == 6 else "negative" for k in range(1, 7)}


def test_standard_input_times_angles_and_pivot(gsp, monkeypatch):
    stdin = io.TextIOWrapper(io.BytesIO(b"t,x,y,z,rx,ry,rz\n0.5,1,1,1,0,0,90\n"))
    monkeypatch.setattr("sys.stdin", stdin)
    run = gsp("measure", HEXAPOD, "-", "--euler", "xyz", "--pivot", "1,0,0", "--format", "csv")
    assert (run.code, run.err) == (0, "")
    direct = gsp("measure", HEXAPOD, "--pose", "1,0,1,1,0,0,1", "--format", "csv")
    rows = [[float(x) for x in r.out.splitlines()[1].split(",")] for r in (run, direct)]
    assert rows[0][0] == 0.5
    assert rows[0][1:] == pytest.approx(rows[1][1:])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((HEXAPOD,), "give either POSES or --pose"),
        ((HEXAPOD, "p.csv", "--pose", "1"), "give either POSES or --pose"),
        (("-", "-"), "SPEC and POSES cannot both be standard input"),
        ((HEXAPOD, "no.csv"), "error: no.csv: cannot be read: No such file or directory\n"),
        (
            (HEXAPOD, "--pose", "1,2,3,0,0,0"),
            "error: --pose: found rx ry rz without the order of the axes: say it with "
            "--euler, such as ZYX or xyz\n",
        ),
        (
            (HEXAPOD, "--pose", "1,2,3,0,0,0", "--euler", "XYx"),
            "error: found the Euler sequence 'XYx', expected three different axes: such as ZYX "
            "(about the axes of the platform, one after the other) or xyz (about those of the "
            "base)\n",
        ),
        (
            (HEXAPOD, "--pose", "1,2,3,0,0,0,1", "--pivot", "0,0"),
            "error: --pivot: found '0,0', expected the three coordinates of a point: x,y,z\n",
        ),
    ],
)
def test_mistakes(gsp, arguments, message):
    run = gsp("measure", *arguments)
    assert run.code == 2
    assert run.out == ""
    assert message in run.err


def test_values_outside_their_range_are_told(gsp, tmp_path):
    text = Path(HEXAPOD).read_text(encoding="utf-8")
    path = tmp_path / "spec.yaml"
    path.write_text(text.replace("value: 2.53", "value: 2.53, range: [2, 3]"), encoding="utf-8")
    poses = gsp("solve", HEXAPOD, "--format", "csv").out
    (tmp_path / "poses.csv").write_text(poses, encoding="utf-8")
    assert gsp("measure", path, tmp_path / "poses.csv").err == ""
    run = gsp("measure", path, "--pose", "9,0,0,1,0,0,0")
    assert run.code == 0
    assert run.err.startswith("t = 1: the value ")
    assert run.err.endswith(" of constraint 1 is outside its range from 2 to 3\n")
    values = tmp_path / "values.csv"
    values.write_text("1\n2.53\n1.99\n1.98\n", encoding="utf-8")
    told = gsp("track", path, values).err
    assert "the value of constraint 1 leaves its range from 2 to 3 at t = 1.98148" in told


def test_angles_of_cranks(gsp):
    run = gsp("measure", "@t-top-head", "--pose", "0,0,0.17,1,0,0,0", "--drives", "--format", "csv")
    assert (run.code, run.err) == (0, "")
    head, row = run.out.splitlines()
    assert head == "t,crank.B1,crank.B2,crank.B3,crank.B4,crank.B5,crank.B6,transmission"
    angles = [float(x) for x in row.split(",")[1:7]]
    assert angles == pytest.approx([angles[0]] * 6, abs=1e-6)
    run = gsp("measure", "@t-top-head", "--pose", "0,0,0.5,1,0,0,0", "--drives")
    assert run.code == 0
    assert "1 of 1 pose cannot be taken, first at t = 1: the leg of crank.B1 does not" in run.err


def test_numbers_of_drives(gsp, tmp_path):
    pose = "--pose", "0,0,0.17,1,0,0,0"
    run = gsp("measure", "@t-top-head", *pose, "--drives", "--format", "json")
    found = json.loads(run.out)
    assert found["drives"] == [f"crank.B{k}" for k in range(1, 7)]
    assert len(found["poses"][0]["numbers"]) == 6
    assert 0.8 < found["poses"][0]["transmission"] < 1
    # Without cranks and slides the drives are the values.
    run = gsp("measure", HEXAPOD, "--pose", "0,0,1.5,1,0,0,0", "--drives", "--format", "csv")
    same = gsp("measure", HEXAPOD, "--pose", "0,0,1.5,1,0,0,0", "--format", "csv")
    assert run.out == same.out


DELTA = ("base=200,0", "platform=50,30", "rod=250", "rails=3", "range=-50:50")


def test_drives_of_shared_carriages_and_what_they_must_keep(gsp, tmp_path):
    path = tmp_path / "delta.yaml"
    path.write_text(gsp("new", "--linear", *DELTA).out, encoding="utf-8")
    pose = "--pose", "10,0,-200,1,0,0,0"
    require = "range, transmission>=0.5, condition<=100"
    run = gsp("measure", path, *pose, "--drives", "--require", require, "--format", "csv")
    assert run.code == 0
    head, row = run.out.splitlines()
    assert head == "t,slide.B1,slide.B2,slide.B4,transmission,range,condition"
    numbers = [float(x) for x in row.split(",")]
    assert numbers[2] == pytest.approx(numbers[3])
    assert numbers[5] == pytest.approx(max(map(abs, numbers[1:4])) / 50)
    low = "--pose", "0,0,-260,1,0,0,0", "--drives"
    run = gsp("measure", path, *low, "--require", "range, transmission>=0.9")
    assert run.code == 1
    assert "range <= 1: NOT met; worst 1.3" in run.out
    assert "slide.B" in run.out
    assert "transmission >= 0.9: NOT met; worst 0.779" in run.out
    run = gsp("measure", path, "--pose", "10,0,-200,1,0.02,0,0", "--drives")
    assert run.code == 0
    assert "rods 1 and 6 ask for 3.4335 and 1.4343 of slide.B1" in run.out


def test_ranges_of_values_of_rods_are_not_those_of_the_drives(gsp):
    pose = "--pose", "0,0,0.17,1,0,0,0"
    run = gsp(
        "measure",
        "@reachy-mini-head",
        "--pose",
        "0,0,0.18,1,0,0,0",
        "--require",
        "transmission>=0.5",
    )
    assert (run.code, run.err) == (0, "")
    run = gsp("measure", HEXAPOD, *pose, "--require", "transmission>=0.5")
    assert "--require transmission: SPEC states no cranks and slides" in run.err


def test_mistakes_of_a_pose_on_the_command_line_have_no_line(gsp):
    run = gsp("measure", HEXAPOD, "--pose", "0,0,0,0,0,0,0")
    assert (
        run.err == "error: --pose: found a quaternion of length zero, expected that of a rotation\n"
    )


def test_requirements(gsp, tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n2,0,0,0.02,1,0,0,0\n", "utf-8")
    run = gsp("measure", "@rubin-m2", path, "--require", "range, condition<=50, clearance>=1",
              "--format", "csv")  # fmt: skip
    assert run.code == 1
    head, *rows = run.out.splitlines()
    assert head == "t,1,2,3,4,5,6,range,condition,clearance"
    assert float(rows[0].split(",")[7]) < 1e-9
    lines = run.err.splitlines()
    # Leg 1 is as long as the platform is high: 20 mm are more than its 14.1.
    first = f"range <= 1: NOT met; worst {20 / 14.1:.6g} in row 2 (t = 2), constraint "
    assert lines[0].startswith(first)
    assert lines[1].startswith("condition <= 50: met; worst 1.6")
    assert lines[-1] == "error: not met: range <= 1"
    run = gsp("measure", "@rubin-m2", path, "--require", "pose-clearance>=0", "--format", "json")
    assert run.code == 0
    document = json.loads(run.out)
    assert document["requirements"][0]["met"] is True
    assert document["poses"][0]["pose_clearance"] > 0
    for what, message in (
        ("force<=1", "--require force: not known here, use gsp analyze with --load"),
        ("cone", "--require cone: SPEC states no cone"),
    ):
        run = gsp("measure", "@rubin-m2", path, "--require", what)
        assert (run.code, run.out) == (2, "")
        assert message in run.err
    run = gsp("measure", "@t-top-head", path, "--nearest", "--require", "range")
    assert "--require needs the values or --drives, not --nearest" in run.err


def test_an_unknown_column_is_an_error_unless_it_is_left_out(gsp, tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text("Zeit [s],x,y,z,qw,qx,qy,qz\n4,1,2,3,1,0,0,0\n", encoding="utf-8")
    run = gsp("measure", HEXAPOD, path)
    assert (run.code, run.out) == (2, "")
    assert "poses.csv:1:1: found the unknown column 'Zeit [s]'" in run.err
    assert gsp("measure", HEXAPOD, path, "--ignore", "Zeit [s]").code == 0
    for command in ("analyze", "clearance", "track", "dynamics", "sensors", "calibrate"):
        assert "--ignore" in gsp(command, "--help").out
    # Of one pose all numbers are needed, and no other is dropped unseen.
    assert gsp("measure", HEXAPOD, "--pose", f"@{path}").code == 0


def test_what_gsp_writes_it_reads(gsp, tmp_path):
    path = tmp_path / "rows.csv"
    machine, near = "@workspace-study-cones", ["--near", "0,0,110,1,0,0,0"]
    pose = "--pose", "0,0,110,1,0,0,0"
    required = ["--require", "range, cone, condition<=1e9, clearance>=0, pose-clearance>=0"]
    for written in (
        ["solve", machine, "--all", *near],
        ["measure", machine, *pose, *required],
        ["track", machine, path, *required],
        ["calibrate", machine, "--plan", "2", "--mode", "home"],
        ["workspace", machine, "--over", "x", "--boxes", "--gap", "0.5"],
    ):
        text = gsp(*written, "--format", "csv").out
        assert text
        path.write_text(text, encoding="utf-8")
        read = "track" if "t,1" in text else "measure"
        assert gsp(read, machine, path, "--format", "csv").err.count("unknown column") == 0


def test_the_nearest_poses_are_a_file_that_track_proves(gsp, tmp_path):
    wanted, file = tmp_path / "wanted.csv", tmp_path / "reachable.csv"
    wanted.write_text("t,x,y,z,rx,ry,rz\n0,0,0,400,0,0,0\n1,50,0,700,40,0,0\n", encoding="utf-8")
    words = ("@workspace-study", str(wanted), "--euler", "xyz", "--nearest", "-o", str(file))
    run = gsp("measure", *words)
    assert run.code == 0
    assert "1 pose of 2 moved to the nearest one within the limits" in run.err
    heading, first, _ = file.read_text(encoding="utf-8").splitlines()
    assert heading == "t,1,2,3,4,5,6,x,y,z,qw,qx,qy,qz,shift,turn,limits"
    assert first.endswith(",0.0,0.0,")
    again = gsp("track", "@workspace-study", str(file), "--require", "range")
    assert again.code == 0


def test_the_nearest_pose_needs_no_requirements(gsp):
    run = gsp("measure", "@rubin-m2", "--pose", "0,0,0,1,0,0,0", "--nearest", "--require", "range")
    assert run.code == 2
    assert "--require needs the values or --drives" in run.err


def test_a_pose_out_of_reach_has_a_blank_row(gsp, tmp_path):
    poses = tmp_path / "poses.csv"
    rows = "t,x,y,z,qw,qx,qy,qz\n0,0,0,0.17,1,0,0,0\n1,0,0,0.5,1,0,0,0\n2,0,0,0.171,1,0,0,0\n"
    poses.write_text(rows, encoding="utf-8")
    words = "measure", "@t-top-head", str(poses), "--format", "csv"
    run = gsp(*words, "--drives")
    assert run.code == 0
    head, first, blank, last = run.out.splitlines()
    assert head.endswith(",transmission,refused")
    assert blank.startswith("1.0,,,,,,,,the leg of crank.B1 does not reach; the leg of crank.B2")
    assert first.endswith(",")
    assert last.endswith(",")
    assert "1 of 3 poses cannot be taken, first at t = 1: " in run.err
    assert gsp(*words, "--drives", "--require", "transmission>=0").code == 1
    run = gsp("track", "@t-top-head", str(poses))
    assert (run.code, "the pose at t = 1: the leg of crank.B1 does not reach" in run.err) == (
        2,
        True,
    )
    run = gsp(*words, "--nearest", "--drives")
    assert (run.code, run.out.count("reach of crank B1")) == (0, 1)


def test_a_pose_in_a_file_without_a_heading(gsp, tmp_path, monkeypatch):
    """Its columns have names, or it is one line of numbers as the option takes them."""
    monkeypatch.chdir(tmp_path)
    Path("named.txt").write_text("# log\n7 0.01 0 0 0 0 0 1\n", encoding="utf-8")
    Path("plain.txt").write_text("0.01;0;0;1;0;0;0\n", encoding="utf-8")
    Path("headed.csv").write_text("x,y,z,qw,qx,qy,qz\n0.01,0,0,1,0,0,0\n", encoding="utf-8")
    Path("two.txt").write_text("0,0,0,1,0,0,0\n0,0,1,1,0,0,0\n", encoding="utf-8")
    wanted = gsp("measure", "@rubin-m2", "--pose", "0.01,0,0,1,0,0,0", "--format", "csv").out
    columns = ("--columns", "t,x,y,z,qx,qy,qz,qw", "--format", "csv")
    for words in (
        ("--pose", "@named.txt", *columns),
        ("--pose", "@plain.txt", "--format", "csv"),
        ("--pose", "@headed.csv", *columns),
        ("--pose", "0.01,0,0,1,0,0,0", *columns),
    ):
        run = gsp("measure", "@rubin-m2", *words)
        assert run.code == 0, words
        assert (
            run.out.split(",", 1)[1].split("\n")[1].split(",")[1:]
            == (wanted.split(",", 1)[1].split("\n")[1].split(",")[1:])
        )
    run = gsp("solve", "@rubin-m2", "--near", "@plain.txt", "--format", "csv")
    assert run.code == 0
    run = gsp("measure", "@rubin-m2", "--pose", "@two.txt")
    assert "give names with --columns" in run.err
    run = gsp("measure", "@rubin-m2", "--pose", "@two.txt", "--columns", "x,y,z,qw,qx,qy,qz")
    assert "--pose @two.txt: found 2 poses, expected one" in run.err
    run = gsp("measure", "@rubin-m2", "--pose", "@named.txt")
    assert "--pose @named.txt: found 8 numbers" in run.err
