"""`gsp dynamics`: rows in all their forms, what is refused, exit codes."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import gspcli
from gspcli.resources import data_path

PAGE = (Path(__file__).parents[2] / "docs" / "dynamics.md").read_text(encoding="utf-8")
SPEC = re.search(r"```yaml\n(.*?)```", PAGE, re.DOTALL)[1]
POSE = "5,10,190,1,0.02,0,0"


@pytest.fixture
def spec(tmp_path):
    path = tmp_path / "spec.yaml"
    path.write_text(SPEC, encoding="utf-8")
    return path


@pytest.fixture
def rows(tmp_path):
    """Write rows of a file and return its path."""

    def write(text, name="rows.csv"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def numbers(text):
    """Return the columns of CSV by their names."""
    table = list(csv.DictReader(io.StringIO(text)))
    return {key: [float(row[key]) if row[key] else None for row in table] for key in table[0]}


PATH = "t,x,y,z,qw,qx,qy,qz\n" + "".join(
    f"{0.02 * k!r},{5 * math.sin(k / 3)!r},{k / 9!r},{190 + math.cos(k / 4)!r},1,{0.01 * k!r},0,0\n"
    for k in range(12)
)


def test_values_give_the_forces_of_their_poses(gsp, spec, rows):
    path = rows(PATH)
    values = gsp("measure", spec, path, "--format", "csv").out
    expected = numbers(gsp("dynamics", spec, path, "--format", "csv").out)
    near = "0,0,191,1,0,0,0"
    found = gsp("dynamics", spec, rows(values, "v.csv"), "--near", near, "--format", "csv")
    assert (found.code, found.err) == (0, "")
    for key, column in numbers(found.out).items():
        assert column == pytest.approx(expected[key], rel=1e-8, abs=1e-8)
    run = gsp("dynamics", spec, tmp := rows(values, "v.csv"), "--format", "csv")
    assert (run.code, run.out) == (0, found.out)
    assert run.err.startswith("home is mode ")
    assert gsp("dynamics", spec, tmp, "--mode", "99").code == 2


def test_given_velocities_of_poses_and_values(gsp, spec, rows):
    """A pose turning steadily about z, seen as poses with a pivot, and as values."""
    motion = rows(
        "x,y,z,qw,qx,qy,qz,wx,wy,wz,vx,vy,vz,alphax,alphay,alphaz,ax,ay,az\n"
        "5,0,190,1,0,0,0,0,0,90,10,0,0,0,0,0,1,2,3\n"
    )
    plain = numbers(gsp("dynamics", spec, motion, "--format", "csv").out)
    turn = math.pi / 2
    # The same about the point (7, 0, 0) of the platform.
    pivot = rows(
        "x,y,z,qw,qx,qy,qz,wx,wy,wz,vx,vy,vz,alphax,alphay,alphaz,ax,ay,az\n"
        f"12,0,190,1,0,0,0,0,0,90,10,{7 * turn!r},0,0,0,0,{1 - 7 * turn**2!r},2,3\n",
        "pivot.csv",
    )
    moved = numbers(gsp("dynamics", spec, pivot, "--pivot", "7,0,0", "--format", "csv").out)
    assert moved == {key: pytest.approx(column) for key, column in plain.items()}
    # As values: differences along the motion.
    from gspcli import load
    from gspcli.geometry.quaternions import rotation_from_vector
    from gspcli.motion import measure

    def at(s):
        R = rotation_from_vector(np.array([0, 0, turn * s]))
        return measure(load(spec), R, np.array([5 + 10 * s + s * s / 2, s * s, 190 + 1.5 * s * s]))

    step = 1e-4
    low, middle, high = at(-step), at(0), at(step)
    rates, bends = (high - low) / (2 * step), (high - 2 * middle + low) / step**2
    heading = ",".join([*"123456", *(f"{c}{k}" for c in "va" for k in range(1, 7))])
    row = ",".join(map(repr, np.concatenate((middle, rates, bends)).tolist()))
    values = rows(f"{heading}\n{row}\n", "values.csv")
    run = gsp("dynamics", spec, values, "--near", "5,0,190,1,0,0,0", "--format", "csv")
    found = numbers(run.out)
    assert found == {
        key: pytest.approx(column, rel=1e-4, abs=1e-4) for key, column in plain.items()
    }
    assert found["power"][0] != 0


def test_rows_without_times_are_at_rest(gsp, spec, rows):
    path = rows("\n".join(line.partition(",")[2] for line in PATH.splitlines()))
    run = gsp("dynamics", spec, path)
    assert "no column t: at rest at each row" in run.out
    assert set(numbers(gsp("dynamics", spec, path, "--format", "csv").out)["power"]) == {0.0}


def test_json_names_the_worst_row(gsp, spec, rows):
    document = json.loads(gsp("dynamics", spec, rows(PATH), "--format", "json").out)
    assert document["schema"] == "gsp.dynamics/1"
    assert document["force_units"] == ["N"] * 6
    forces = np.array([row["forces"] for row in document["rows"]])
    worst = document["worst"]
    assert abs(worst["force"]) == np.abs(forces).max()
    assert forces[worst["row"] - 1, worst["drive"] - 1] == worst["force"]
    table = gsp("dynamics", spec, rows(PATH)).out
    assert f"by drive {worst['drive']} in row {worst['row']} (t = " in table


def test_requirements_decide_the_exit_code(gsp, spec, rows):
    path = rows(PATH)
    met = gsp("dynamics", spec, path, "--require", "force<=5000, power<=1e6, range")
    assert met.code == 0
    assert "force <= 5000: met; worst " in met.out
    broken = gsp("dynamics", spec, path, "--require", "force<=1, power<=1e6")
    assert broken.code == 1
    assert re.search(
        r"force <= 1: NOT met; worst [\d.]+ in row \d+ \(t = .*\), drive \d", broken.out
    )
    assert broken.err == "error: not met: force <= 1\n"
    assert gsp("dynamics", spec, "--modes", "--pose", POSE, "--require", "frequency>=50").code == 0
    assert gsp("dynamics", spec, "--modes", "--pose", POSE, "--require", "frequency>=60").code == 1


def test_forces_of_a_rotary_machine_are_those_of_rods(gsp, tmp_path):
    text = gspcli.dumps(gspcli.load(data_path("platforms", "t-top-head.yaml")))
    path = tmp_path / "rotary.yaml"
    path.write_text(
        text + "dynamics:\n  platform: {mass: 1, centre: [0, 0, 0], inertia: [1, 1, 1, 0, 0, 0]}\n",
        encoding="utf-8",
    )
    run = gsp("dynamics", path, "--mode", "home")
    assert run.code == 0
    assert "F1 ... F6 act along the rods" in run.out
    assert "crank.B6 [N m]" in run.out


def test_values_beside_poses_are_those_that_gsp_measure_writes(gsp, spec, rows):
    path = rows("x,y,z,qw,qx,qy,qz\n0,0,190,1,0,0,0\n")
    alone = gsp("dynamics", spec, path)
    measured = gsp("measure", spec, path, "--format", "csv").out.splitlines()
    heading, row = (line.partition(",")[2] for line in measured)
    both = rows(f"x,y,z,qw,qx,qy,qz,{heading}\n0,0,190,1,0,0,0,{row}\n")
    assert gsp("dynamics", spec, both).out == alone.out


def test_singular_rows_are_named(gsp, spec, rows):
    path = rows("x,y,z,qw,qx,qy,qz\n0,0,190,1,0,0,0\n0,0,0,1,0,0,0\n0,0,1e-7,1,0,0,0\n")
    run = gsp("dynamics", spec, path, "--format", "csv")
    assert run.code == 4
    assert run.out.splitlines()[2] == "2,,,,,,,"
    warning, error = run.err.splitlines()
    assert warning.startswith("warning: in row 3 the pose is nearly singular (condition 2.6e+09)")
    assert error == "error: in row 2 the pose is singular: no forces hold every load there"
    modes = gsp("dynamics", spec, path, "--modes", "--format", "csv")
    assert (modes.code, modes.out.splitlines()[2]) == (4, "2,,,,,,")
    assert gsp("dynamics", spec, path, "--require", "force<=1").code == 1
    # Where all other rows keep what is required, it is not known of this one.
    alone = rows("x,y,z,qw,qx,qy,qz\n0,0,190,1,0,0,0\n0,0,0,1,0,0,0\n")
    unknown = gsp("dynamics", spec, alone, "--require", "force<=1e6")
    assert unknown.code == 4
    assert "force <= 1e+06: NOT met; not known in row 2" in unknown.out
    assert "the pose is singular: no forces hold every load there" in unknown.err


def test_modes_of_one_pose_and_of_all(gsp, spec):
    one = gsp("dynamics", spec, "--pose", POSE, "--modes")
    assert one.out.splitlines()[2].split()[:3] == ["mode", "f", "[Hz]"]
    stiff = json.loads(gsp("dynamics", spec, "--mode", "15", "--modes", "--format", "json").out)
    soft = gsp("dynamics", spec, "--modes", "--stiffness", "1e5", "--format", "json").out
    rows = json.loads(soft)["rows"]
    assert len(rows) == 16
    assert rows[14]["mode"] == 15
    assert rows[14]["frequencies"][0] < stiff["rows"][0]["frequencies"][0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--stiffness", "1"), "--stiffness is for --modes only"),
        (("--near", POSE), "--near is for ROWS: give it, too"),
        (("--mode", "1", "--pose", POSE), "give either "),
        (("ROWS", "--pose", POSE), "give either ROWS or --pose"),
        (("ROWS", "--mode", "1"), "expected a file of values to follow"),
        (("--modes", "--stiffness", "1,2"), "--stiffness: found 2 numbers, expected 1 or 6"),
        (("--require", "forc<=1"), "did you mean force?"),
        (("--require", "moment<=1"), "--require moment: not known here"),
    ],
)
def test_options_that_do_not_go_together(gsp, spec, rows, arguments, message):
    words = [str(rows(PATH)) if word == "ROWS" else word for word in arguments]
    run = gsp("dynamics", spec, *words)
    assert (run.code, run.out) == (2, "")
    assert message in run.err
    assert len(run.err.splitlines()) <= 5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (PATH.replace("\n0.02,", "\n-0.02,"), "rows.csv:3:1: found t = -0.02 after 0: t must"),
        ("\n".join(PATH.splitlines()[:4]), "found 3 rows with times, expected at least 6"),
        ("x,y,z,qw,qx,qy,qz,wx\n0,0,0,1,0,0,0,0\n", "without wy wz vx vy vz alphax alphay alphaz"),
        ("x,y,z,qw,qx,qy,qz\n", "found a heading and no rows"),
        ("1,base.B1.x\n225,3\n", "found the unknown column 'base.B1.x'"),
        ("x,y,z,qw,qx,qy,qz\n-5,105,0,1,0,0,0\n", "has no derivative"),
    ],
)
def test_mistakes_of_rows(gsp, spec, rows, text, message):
    run = gsp("dynamics", spec, rows(text))
    assert (run.code, run.out) == (2, "")
    assert message in run.err


def test_what_the_file_does_not_say(gsp, rows):
    run = gsp("dynamics", "@rubin-m2", "--mode", "1")
    assert (run.code, run.out) == (2, "")
    assert "found no masses: add `dynamics:` to the instance file" in run.err
    soft = rows(SPEC.replace(", stiffness: 2.0e6", ""), "soft.yaml")
    assert "found no stiffness: state drives" in gsp("dynamics", soft, "--mode", "1", "--modes").err
    wrong = rows(SPEC.replace("length: mm", "length: furlong"), "wrong.yaml")
    run = gsp("dynamics", wrong)
    assert run.code == 2
    assert "wrong.yaml:3:17: units.length: found 'furlong', expected m, dm, cm, mm" in run.err


def test_analyze_adds_the_weights(gsp, spec):
    held = json.loads(gsp("dynamics", spec, "--pose", POSE, "--format", "json").out)
    analyzed = json.loads(gsp("analyze", spec, "--pose", POSE, "--format", "json").out)
    forces = held["rows"][0]["forces"]
    assert analyzed["poses"][0]["reactions"] == pytest.approx(forces, rel=1e-12)
    loaded = gsp("analyze", spec, "--pose", POSE, "--load", "0,0,-100", "--format", "json").out
    more = np.array(json.loads(loaded)["poses"][0]["reactions"]) - forces
    exerted = more @ np.array(analyzed["poses"][0]["forces"])
    assert exerted == pytest.approx([0, 0, 100], abs=1e-9)
    assert "reactions hold the weights under dynamics" in gsp("analyze", spec).out
    assert gsp("analyze", spec, "--pose", POSE, "--require", "force<=1").code == 1


ROTARY = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)[1]


def test_torques_of_a_rotary_machine(gsp, rows):
    """Rows of poses and rows of angles have the same torques; a limit on them is judged."""
    spec = rows(ROTARY, "rotary.yaml")
    poses = rows(
        "t,x,y,z,qw,qx,qy,qz\n"
        + "".join(f"{0.1 * k!r},{0.5 * k!r},0,{120 + k!r},1,{0.004 * k!r},0,0\n" for k in range(7)),
        "poses.csv",
    )
    found = numbers(gsp("dynamics", spec, poses, "--format", "csv").out)
    assert list(found)[:2] == ["t", "torque.crank.B1"]
    angles = gsp("measure", spec, poses, "--drives", "--format", "csv").out
    again = numbers(gsp("dynamics", spec, rows(angles, "a.csv"), "--format", "csv").out)
    for key, column in found.items():
        assert again[key] == pytest.approx(column, rel=1e-6, abs=1e-8)
    # Angles in files are readings.
    corrected = ROTARY.replace("axis: [1, 0, 0], ", "axis: [1, 0, 0], offset: 2, scale: 0.01, ")
    other = rows(corrected, "corrected.yaml")
    read = gsp("measure", other, poses, "--drives", "--format", "csv").out
    assert read != angles
    again = numbers(gsp("dynamics", other, rows(read, "b.csv"), "--format", "csv").out)
    for key, column in found.items():
        assert again[key] == pytest.approx(column, rel=1e-6, abs=1e-8)
    at_home = gsp("dynamics", other, "--mode", "home", "--format", "csv").out
    assert at_home == gsp("dynamics", spec, "--mode", "home", "--format", "csv").out
    most = max(abs(x) for key, column in found.items() if "torque" in key for x in column)
    assert gsp("dynamics", spec, poses, "--require", f"torque<={1.01 * most}").code == 0
    refused = gsp("dynamics", spec, poses, "--require", f"torque<={0.99 * most}")
    assert (refused.code, "not met: torque" in refused.err) == (1, True)


def test_rates_of_rods_beside_drives_are_refused(gsp, rows):
    spec = rows(ROTARY, "rotary.yaml")
    rates = rows("t,crank.B1,v1,v2,v3,v4,v5,v6,a1,a2,a3,a4,a5,a6\n0," + ",".join("0" * 13), "r.csv")
    assert "expected a column t: splines" in gsp("dynamics", spec, rates).err
