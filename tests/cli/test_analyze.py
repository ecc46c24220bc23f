from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).parents[2] / "data" / "examples"
HEXAPOD = str(EXAMPLES / "platform-6-6.yaml")
POSE = "0,0,1.5,1,0,0,0"


def test_one_line_a_mode(gsp):
    run = gsp("analyze", HEXAPOD)
    assert (run.code, run.err) == (0, "")
    lines = run.out.splitlines()
    assert lines[2].split()[:3] == ["mode", "condition", "manipulability"]
    assert [line.split()[0] for line in lines[4:6]] == ["1", "2"]
    assert "lengths divided by 2.53 unit" in lines[-1]


def test_one_mode_in_detail(gsp):
    run = gsp("analyze", HEXAPOD, "--mode", "1", "--load", "0,0,-1", "--tolerance", "1e-4")
    assert run.code == 0
    for title in ("Derivatives of the values by the twist", "Twist by the values", "Errors of"):
        assert title in run.out
    assert "manipulability 0.00335094; condition 34.9255 (rows scaled to one)" in run.out


def test_condition_numbers_are_those_of_solve(gsp):
    analyzed = json.loads(gsp("analyze", HEXAPOD, "--format", "json").out)
    solved = json.loads(gsp("solve", HEXAPOD, "--format", "json").out)
    numbers = [pose["condition"] for pose in solved["solutions"] if pose["real"]]
    assert [pose["condition"] for pose in analyzed["poses"]] == pytest.approx(numbers, rel=1e-9)


def test_errors_from_the_geometry(gsp):
    run = gsp(
        "analyze", HEXAPOD, "--mode", "1", "--geometry-tolerance", "1e-4", "--part", "geometry"
    )
    assert run.code == 0
    assert run.out.splitlines()[0] == "Errors of the pose from the geometry"
    run = gsp("analyze", HEXAPOD, "--geometry-tolerance", "-1")
    assert (run.code, run.out) == (2, "")
    assert "--geometry-tolerance: found -1, expected numbers of at least 0" in run.err


def test_json_has_everything_in_full(gsp):
    run = gsp(
        "analyze", HEXAPOD, "--pose", POSE, "--load", "0,0,-10,1,2,3@0,0,2", "--format", "json",
        "--stiffness", "1,2,3,4,5,6", "--length", "2", "--point", "0,0,1", "--tolerance", "0.0001",
    )  # fmt: skip
    document = json.loads(run.out)
    assert document["schema"] == "gsp.analyze/1"
    assert document["length"] == 2
    (pose,) = document["poses"]
    assert pose["mode"] is None
    assert pose["point"] == [0, 0, 1]
    forces, reactions = pose["forces"], pose["reactions"]
    held = [sum(r * f[i] for r, f in zip(reactions, forces, strict=True)) for i in range(3)]
    assert held == pytest.approx([0, 0, 10])
    assert set(pose["accuracy"]) == {
        "worst", "bound", "rms", "worst_turn", "worst_shift", "bound_turn", "bound_shift",
    }  # fmt: skip


def test_tolerances_of_the_file(gsp, tmp_path):
    text = Path(HEXAPOD).read_text(encoding="utf-8")
    path = tmp_path / "spec.yaml"
    path.write_text(text.replace("value: 2.53", "value: 2.53, tolerance: 1/1000"), encoding="utf-8")
    run = gsp("analyze", path, "--mode", "1", "--format", "json")
    stated = json.loads(run.out)["poses"][0]["accuracy"]["worst"]
    given = gsp("analyze", HEXAPOD, "--mode", "1", "--tolerance", "0.001,0,0,0,0,0",
                "--format", "json")  # fmt: skip
    assert json.loads(given.out)["poses"][0]["accuracy"]["worst"] == stated


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--mode", "1", "--pose", POSE), "give either --mode or --pose"),
        (("--mode", "7"), "error: found mode 7, expected one of the 2 real poses\n"),
        (("--load", "1,2"), "error: --load: found 2 numbers, expected 3 or 6\n"),
        (("--load", "1,2,3@0"), "error: --load: found 1 numbers, expected 3\n"),
        (("--tolerance", "x"), "error: --tolerance: found 'x', expected a finite number\n"),
        (("--tolerance", "-1"), "expected six numbers of at least zero"),
        (("--stiffness", "1,2"), "error: --stiffness: found 2 numbers, expected 1 or 6\n"),
        (("--length", "0"), "Invalid value for '--length'"),
    ],
)
def test_mistakes(gsp, arguments, message):
    run = gsp("analyze", HEXAPOD, *arguments)
    assert run.code == 2
    assert run.out == ""
    assert message in run.err


POSES = "t,x,y,z,qw,qx,qy,qz\n0,0,0,1.5,1,0,0,0\n0.5,0.1,0,1.5,1,0,0,0\n1,0.2,0,1.4,1,0.1,0,0\n"


@pytest.fixture
def poses(tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text(POSES, encoding="utf-8")
    return path


def test_tolerances_leave_the_worst_force_as_it_is(gsp):
    plain, with_errors = (
        gsp("analyze", "@rubin-m2", *more, "--format", "csv").out.splitlines()
        for more in ((), ("--tolerance", "1e-6"))
    )
    place = plain[0].split(",").index("worst")
    assert with_errors[0].startswith(plain[0])
    for one, other in zip(plain[1:], with_errors[1:], strict=True):
        assert float(one.split(",")[place]) == float(other.split(",")[place])


def test_the_overview_has_a_column_for_each_option(gsp):
    options = ("--load", "0,0,-15000", "--stiffness", "2e6", "--geometry-tolerance", "5e-5")
    head, *rows = gsp("analyze", "@rubin-m2", *options, "--format", "csv").out.splitlines()
    document = json.loads(gsp("analyze", "@rubin-m2", *options, "--format", "json").out)
    for row, pose in zip(rows, document["poses"], strict=True):
        found = dict(zip(head.split(","), row.split(","), strict=True))
        largest = max(pose["reactions"], key=abs)
        assert float(found["force"]) == abs(largest)
        assert int(found["force_in"]) == pose["reactions"].index(largest) + 1
        assert float(found["geometry_shift"]) == pose["geometry"]["shift"]
        assert float(found["least_stiffness"]) == pose["least_stiffness"]
    assert "moment" not in head
    run = gsp("analyze", "@example-6.8", "--load", "0,0,-1", "--format", "csv")
    assert "force,force_in,moment,moment_in" in run.out


def test_the_least_stiffness_is_that_of_the_most_compliant_direction(gsp):
    run = gsp("analyze", HEXAPOD, "--stiffness", "1,2,3,4,5,6", "--format", "json")
    rng = np.random.default_rng(1)
    for pose in json.loads(run.out)["poses"]:
        forces = rng.normal(size=(2000, 3))
        forces /= np.linalg.norm(forces, axis=1, keepdims=True)
        # The matrix takes (omega, v) to (moment, force).
        loads = np.concatenate((np.zeros_like(forces), forces), axis=1)
        shifts = np.linalg.solve(np.array(pose["stiffness"]), loads.T).T[:, 3:]
        found = 1 / np.linalg.norm(shifts, axis=1).max()
        assert pose["least_stiffness"] <= found
        assert pose["least_stiffness"] == pytest.approx(found, rel=0.01)
    run = gsp("analyze", HEXAPOD, "--stiffness", "0")
    assert (run.code, "expected positive numbers" in run.err) == (2, True)


def test_rows_of_poses(gsp, poses):
    head, *rows = gsp("analyze", HEXAPOD, poses, "--format", "csv").out.splitlines()
    assert head == "row,t,condition,manipulability,largest,smallest,worst"
    for number, line in enumerate(POSES.splitlines()[1:], 1):
        t, *pose = line.split(",")
        run = gsp("analyze", HEXAPOD, "--pose", ",".join(pose), "--format", "json")
        (alone,) = json.loads(run.out)["poses"]
        found = rows[number - 1].split(",")
        assert (int(found[0]), float(found[1])) == (number, float(t))
        assert float(found[2]) == pytest.approx(alone["condition"])


def test_rows_of_values_follow_the_modes(gsp, tmp_path):
    path = tmp_path / "values.csv"
    path.write_text("1\n2.53\n2.535\n", encoding="utf-8")
    run = gsp("analyze", HEXAPOD, path, "--format", "json")
    found = json.loads(run.out)["poses"]
    assert [(one["row"], one["mode"]) for one in found] == [(1, 1), (1, 2), (2, 1), (2, 2)]
    track = json.loads(gsp("track", HEXAPOD, path, "--format", "json").out)
    expected = [one["condition"] for one in track["poses"]]
    assert [one["condition"] for one in found] == pytest.approx(expected)
    only = gsp("analyze", HEXAPOD, path, "--mode", "2", "--format", "json")
    assert [one["mode"] for one in json.loads(only.out)["poses"]] == [2, 2]
    path.write_text("1,2,3,4,5,6\n2.53,2.08,0.93,1.97,1.46,1.73\n2.6,2,1,1.9,1.46,1.73\n")
    run = gsp("analyze", HEXAPOD, path)
    assert run.code == 4
    assert "mode 1 ends at t = 1.71886061 (fold)" in run.err


def test_requirements_name_the_worst_row(gsp, poses):
    conditions = [
        float(line.split(",")[2])
        for line in gsp("analyze", HEXAPOD, poses, "--format", "csv").out.splitlines()[1:]
    ]
    worst = conditions.index(max(conditions)) + 1
    asked = ("--load", "0,0,-10", "--require", "condition<=1000, force<=0.001")
    run = gsp("analyze", HEXAPOD, poses, *asked)
    assert run.code == 1
    assert f"condition <= 1000: met; worst {max(conditions):.6g} in row {worst} (t = " in run.out
    assert "force <= 0.001: NOT met; worst" in run.out
    assert run.err == "error: not met: force <= 0.001\n"
    run = gsp("analyze", HEXAPOD, poses, *asked, "--format", "json")
    condition, force = json.loads(run.out)["requirements"]
    assert (condition["met"], condition["row"], condition["part"]) == (True, worst, None)
    assert (force["met"], force["requirement"]) == (False, "force <= 0.001")
    assert force["part"].startswith("constraint ")
    run = gsp("analyze", HEXAPOD, poses, "--require", "condition<=1000, clearance>=0")
    assert run.code == 0
    assert "clearance >= 0: met" in run.out
    run = gsp("analyze", HEXAPOD, "--require", "condition<=30")
    assert "condition <= 30: NOT met; worst 34.9255 in mode 1" in run.out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--require", "stiffness>=1"), "not known here, use gsp analyze with --stiffness"),
        (("--require", "moment<=1", "--load", "0,0,1"), "use gsp analyze with --load, of a type"),
        (("--require", "range"), "--require range: SPEC states no range"),
        (("--mode", "1"), "--mode: found the poses of"),
        (("--pose", POSE), "give either ROWS or --pose"),
    ],
)
def test_mistakes_with_rows(gsp, poses, arguments, message):
    run = gsp("analyze", HEXAPOD, poses, *arguments)
    assert (run.code, run.out) == (2, "")
    assert message in run.err


def test_the_stiffness_of_the_drives_counts_in_the_unit_of_the_file(gsp, tmp_path):
    """N/m in the file, N/mm at the option: they are the same stiffness."""
    body = "{mass: 1, centre: [0, 0, 0], inertia: [1, 1, 1, 0, 0, 0]}"
    stated = f"dynamics:\n  platform: {body}\n  drives: {{stiffness: 2e6}}\n"
    spec = tmp_path / "stated.yaml"
    spec.write_text(gsp("example", "workspace-study").out + stated)
    words = ["--pose", "0,0,400,1,0,0,0", "--part", "stiffness", "--format", "csv"]
    own = gsp("analyze", spec, *words)
    given = gsp("analyze", "@workspace-study", *words, "--stiffness", "2000")
    assert (own.code, own.out) == (given.code, given.out) == (0, given.out)


def test_a_table_of_poses_has_no_matrices_of_them(gsp, monkeypatch):
    """Those of 100 000 rows, twice, took 2.4 GB."""
    from gspcli.dynamics.analyses import Analysis

    to_json = Analysis.to_json

    def watched(*words, **options):
        document = to_json(*words, **options)
        assert "jacobian" not in document["poses"][0]
        return document

    monkeypatch.setattr(Analysis, "to_json", watched)
    run = gsp("analyze", "@dietmaier", "--format", "csv")
    assert run.code == 0
    assert len(run.out.splitlines()) == 41


def test_drives_of_a_pose_and_of_many(gsp, tmp_path):
    path = tmp_path / "rotary.yaml"
    words = ("base=80,12", "platform=55,10", "horn=24", "rod=130")
    path.write_text(gsp("new", "--rotary", *words).out, encoding="utf-8")
    run = gsp("analyze", path, "--pose", "0,0,122.7088874892,1,0,0,0", "--load", "0,0,-10",
              "--format", "json")  # fmt: skip
    found = json.loads(run.out)
    assert found["drives"] == [f"crank.B{k}" for k in range(1, 7)]
    (pose,) = found["poses"]
    assert pose["drives"] == pytest.approx([0] * 6, abs=1e-9)
    # Each arm lifts a sixth of 10 N with a lever of 24 mm.
    assert pose["torques"] == pytest.approx([40] * 6)
    assert pose["transmission"] == pytest.approx(0.943915, abs=1e-6)
    assert pose["reactions"] == pytest.approx([10 / 6 / 0.943915] * 6, rel=1e-5)
    require = "range, transmission>=0.5, torque<=30"
    run = gsp(
        "analyze", path, "--pose", "0,0,125,1,0.05,0,0", "--load", "0,0,-10", "--require", require
    )
    assert run.code == 1
    assert "torque <= 30: NOT met; worst 41.5926" in run.out
    assert "crank.B6" in run.out
    assert "Drives" in run.out
    # Modes are poses with all drives at zero.
    run = gsp("analyze", path, "--format", "json")
    assert all(pose["drives"] == [0] * 6 for pose in json.loads(run.out)["poses"])
    run = gsp("analyze", HEXAPOD, "--pose", "0,0,1.5,1,0,0,0", "--require", "transmission>=0.1")
    assert run.code == 2


def test_drives_are_judged_where_they_are_stated(gsp, tmp_path):
    """Some modes have other working modes than home: their drives are where SPEC has them, too."""
    path = tmp_path / "head.yaml"
    gsp("example", "t-top-head", "-o", path)
    text = path.read_text(encoding="utf-8").replace("crank: {", "crank: {range: [-30, 30], ")
    path.write_text(text, encoding="utf-8")
    run = gsp("analyze", path, "--require", "range<=0.001", "--format", "json")
    assert run.code == 0
    assert [one["range"] for one in json.loads(run.out)["poses"]] == [0.0] * 16
