from __future__ import annotations

import json
from pathlib import Path

import pytest

HEXAPOD = str(Path(__file__).parents[2] / "data" / "examples" / "platform-6-6.yaml")


def test_home_by_default(gsp):
    run = gsp("clearance", "@rubin-m2")
    assert (run.code, run.err) == (0, "home is mode 2: nearest to the stated home\n")
    assert [line.split()[0] for line in run.out.splitlines()[4:6] if line] == ["2"]
    run = gsp("clearance", HEXAPOD, "--all-modes", "--mode", "home")
    assert (run.code, "give either --all-modes or --mode" in run.err) == (2, True)


def test_table(gsp):
    run = gsp("clearance", HEXAPOD, "--all-modes")
    assert (run.code, run.err) == (0, "")
    lines = run.out.splitlines()
    assert lines[0] == "General 6-6 platform: DPP DPP DPP DPP DPP DPP"
    assert lines[2].split()[:7] == ["mode", "proved", "free", "ends", "at", "ratio", "by"]
    assert [line.split()[0] for line in lines[4:6]] == ["1", "2"]
    assert lines[-1].startswith("clearances in units of 1 unit for distances, 1 deg for angles")


def test_refined_bounds_are_nearer(gsp):
    ratios = []
    for more in ((), ("--refine",)):
        run = gsp("clearance", HEXAPOD, "--mode", "1", "--format", "json", *more)
        document = json.loads(run.out)
        assert document["schema"] == "gsp.clearance/1"
        (mode,) = document["modes"]
        assert mode["lower"] < mode["upper"]
        assert len(mode["values"]) == 6
        ratios.append(mode["ratio"])
    assert ratios[1] < ratios[0] < 4
    assert ratios[1] < 2


def test_a_distance_that_becomes_zero_before_any_fold(gsp):
    run = gsp("clearance", "@surfaces-ppp", "--mode", "1")
    assert "0.71" in run.out
    assert "end of range   3" in run.out
    run = gsp("clearance", "@surfaces-ppp", "--mode", "1", "--format", "json")
    (mode,) = json.loads(run.out)["modes"]
    assert (mode["upper"], mode["by"], mode["constraint"]) == (
        pytest.approx(0.71), "end of range", 3,
    )  # fmt: skip
    assert mode["values"][2] == 0
    assert mode["R"] is None


def test_a_column_of_track(gsp, tmp_path):
    path = tmp_path / "values.csv"
    path.write_text("1\n2.53\n2.535\n", encoding="utf-8")
    run = gsp("track", HEXAPOD, path, "--mode", "1", "--clearance", "--format", "csv")
    head, *rows = run.out.splitlines()
    assert head.endswith("condition,clearance")
    single = gsp("clearance", HEXAPOD, "--mode", "1", "--format", "json")
    lower = json.loads(single.out)["modes"][0]["lower"]
    assert float(rows[0].split(",")[-1]) == pytest.approx(lower, rel=0.05)


def test_the_clearance_of_the_pose_as_a_column_of_track(gsp, tmp_path):
    path = tmp_path / "values.csv"
    path.write_text("1\n2.53\n2.535\n", encoding="utf-8")
    options = ("--mode", "1", "--clearance", "--pose-clearance", "--format", "csv")
    head, *rows = gsp("track", HEXAPOD, path, *options).out.splitlines()
    assert head.endswith("condition,clearance,pose_clearance")
    single = gsp("clearance", HEXAPOD, "--mode", "1", "--of", "pose", "--format", "json")
    lower = json.loads(single.out)["modes"][0]["lower"]
    assert float(rows[0].split(",")[-1]) == pytest.approx(lower, rel=1e-6)
    assert rows[0].split(",")[-1] != rows[1].split(",")[-1]


def test_mistakes(gsp):
    run = gsp("clearance", HEXAPOD, "--mode", "1", "--pose", "1")
    assert run.code == 2
    assert "give either --mode or --pose" in run.err


def test_of_the_pose(gsp, tmp_path):
    run = gsp("clearance", "@octahedral-3-3", "--of", "pose", "--mode", "1", "--format", "json")
    document = json.loads(run.out)
    assert document["of"] == "pose"
    (mode,) = document["modes"]
    assert 0 < mode["lower"] < mode["upper"]
    (tmp_path / "pose.csv").write_text(_pose(mode), encoding="utf-8")
    run = gsp("measure", "@octahedral-3-3", tmp_path / "pose.csv", "--format", "csv")
    measured = [float(cell) for cell in run.out.splitlines()[1].split(",")[1:]]
    assert measured == pytest.approx(mode["values"])
    run = gsp("clearance", "@octahedral-3-3", "--of", "pose", "--mode", "1")
    assert "singular at" in run.out
    assert run.out.splitlines()[-1].startswith("clearances in m, root mean squares")


def _pose(mode):
    numbers = [*mode["T"], *(x for row in mode["R"] for x in row)]
    names = ["Tx", "Ty", "Tz", *(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))]
    return ",".join(names) + "\n" + ",".join(map(repr, numbers)) + "\n"


def test_mistakes_of_points(gsp):
    pose = ("clearance", HEXAPOD, "--of", "pose", "--mode", "1", "--points")
    assert "found 2 coordinates, expected X,Y,Z" in gsp(*pose, "0,0,0;1,0").err
    assert "--points: found 'x', expected a finite number" in gsp(*pose, "0,0,x").err
    assert "lie on a line" in gsp(*pose, "0,0,0;1,0,0").err
    run = gsp("clearance", HEXAPOD, "--points", "0,0,0")
    assert (run.code, "--points needs --of pose" in run.err) == (2, True)


@pytest.mark.parametrize(
    "command", [("clearance",), ("clearance", "--of", "pose"), ("analyze",), ("workspace",)]
)
def test_a_platform_without_a_real_pose(gsp, tmp_path, command):
    path = tmp_path / "short.yaml"
    text = (
        Path(HEXAPOD)
        .read_text(encoding="utf-8")
        .replace("value: 2.53", "value: 0.001, range: [0, 9]")
    )
    path.write_text(text, encoding="utf-8")
    name, *options = command
    run = gsp(name, path, *options)
    assert (run.code, run.out) == (2, "")
    assert "error: the platform has no real pose for its values\ngive a pose with --pose" in run.err


def test_poses_without_number(gsp, tmp_path):
    """Infinitely many poses are not modes: similar regular hexagons in parallel planes."""
    corners = [
        (1, 0),
        (0.5, "sqrt(3)/2"),
        (-0.5, "sqrt(3)/2"),
        (-1, 0),
        (-0.5, "-sqrt(3)/2"),
        (0.5, "-sqrt(3)/2"),
    ]
    points = [f"  {{}}{k}: {{{{point: [{x}, {y}, 0]}}}}" for k, (x, y) in enumerate(corners, 1)]
    lines = [f"  - {{distance: [P{k}, B{k}], value: 2}}" for k in range(1, 7)]
    text = [
        "gsp: 1",
        "units: {length: mm, angle: deg}",
        "platform:",
        *(p.format("P") for p in points),
    ]
    text += ["base:", *(p.format("B") for p in points), "constraints:", *lines]
    path = tmp_path / "moving.yaml"
    path.write_text("\n".join(text), encoding="utf-8")
    for command in ("clearance", "analyze"):
        run = gsp(command, path)
        assert (run.code, run.out) == (3, "")
        assert "infinitely many" in run.err
        assert gsp(command, path, "--pose", "0,0,2,1,0,0,0").code == 0
    # The legs are parallel: that pose is singular.
    for of in ("values", "pose"):
        run = gsp("clearance", path, "--pose", "0,0,2,1,0,0,0", "--of", of, "--format", "json")
        assert json.loads(run.out)["modes"][0]["lower"] == 0


def test_rows(gsp, tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text("t,x,y,z,qw,qx,qy,qz\n3,0,0,0,1,0,0,0\n4,0,0,0.005,1,0,0,0\n", "utf-8")
    run = gsp("clearance", "@rubin-m2", path, "--format", "csv")
    head, *rows = run.out.splitlines()
    assert head == "row,t,lower,upper,ratio,by,constraint,1,2,3,4,5,6"
    assert [row.split(",")[:2] for row in rows] == [["1", "3.0"], ["2", "4.0"]]
    alone = gsp("clearance", "@rubin-m2", "--pose", "0,0,0.005,1,0,0,0", "--format", "csv")
    assert rows[1].split(",")[2:] == alone.out.splitlines()[1].split(",")[1:]
    path.write_text("1\n2.53\n2.535\n", encoding="utf-8")
    run = gsp("clearance", HEXAPOD, path, "--mode", "1", "--of", "pose", "--format", "json")
    found = [(one["row"], one["t"], one["mode"]) for one in json.loads(run.out)["modes"]]
    assert found == [(1, 1.0, 1), (2, 2.0, 1)]
    path.write_text("crank.B1\n0.01\n0.02\n", encoding="utf-8")
    run = gsp("clearance", "@t-top-head", path, "--mode", "home", "--format", "csv")
    followed = tmp_path / "track.csv"
    gsp("track", "@t-top-head", path, "--mode", "home", "--format", "csv", "-o", followed)
    poses = gsp("clearance", "@t-top-head", followed, "--format", "csv")
    one, other = (
        [float(x) for line in text.out.splitlines()[1:] for x in line.split(",")[-6:]]
        for text in (run, poses)
    )
    assert len(one) == 12
    assert one == pytest.approx(other, abs=1e-6)


def test_mirrored_modes_have_the_same_clearance(gsp, tmp_path):
    """Two modes mirror each other in the base, and one of them has other working modes than home.

    The drives are at zero in both; the numbers of home's working modes are elsewhere in one.
    """
    run = gsp("clearance", "@t-top-head", "--all-modes", "--format", "json")
    lower = [entry["lower"] for entry in json.loads(run.out)["modes"]]
    for k in (0, 14):
        assert lower[k] == pytest.approx(lower[k + 1], rel=1e-3)
    assert lower[0] > 2
    assert lower[14] > 4
    # Along a track, too.
    names = ",".join(f"crank.B{k}" for k in range(1, 7))
    path = tmp_path / "cranks.csv"
    path.write_text(f"{names}\n0,0,0,0,0,0\n0.01,0,0,0,0,0\n", encoding="utf-8")
    run = gsp("track", "@t-top-head", path, "--clearance", "--format", "json")
    rows = [row["clearance"] for row in json.loads(run.out)["poses"][:16]]
    assert rows == pytest.approx(lower, rel=1e-6)
