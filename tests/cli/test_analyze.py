from __future__ import annotations

import json
from pathlib import Path

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
    run = gsp("analyze", HEXAPOD, "--mode", "1", "--geometry", "1e-4", "--part", "geometry")
    assert run.code == 0
    assert run.out.splitlines()[0] == "Errors of the pose from the geometry"
    run = gsp("analyze", HEXAPOD, "--geometry", "-1")
    assert (run.code, run.out) == (2, "")
    assert "--geometry: found -1, expected numbers of at least 0" in run.err


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
