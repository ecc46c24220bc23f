"""Every command that reads or prints poses tells them in the frames of the file."""

import json
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import gspcli
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.home_pose import Frame, Frames
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_quaternion

MACHINE = gspcli.example("workspace-study")
FRAMES = Frames(
    Frame([5, -8, 40], euler="ZYX", angles=[10, 0, 25]), Frame([20, 0, -30], [1, 0.25, 0, 0.5])
)
EXPRESSED = replace(MACHINE, frames=FRAMES)
STILL = replace(MACHINE, frames=Frames(Frame([0, 0, 0]), Frame([0, 0, 0])))
POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


@pytest.fixture
def spec(tmp_path):
    """Return a function that writes an instance to a file, and returns its path."""

    def written(instance):
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.yaml"
        gspcli.dump(instance, path)
        return path

    return written


def _path(frame=None, count=6):
    """Return poses near home as CSV, as they are expressed in a frame."""
    rows, way = [], np.linspace(0, 1, count)
    for s in way:
        R = rotation_from_euler("ZYX", np.array([0.1, -0.05, 0.2]) * s)
        T = np.array([15 * s, -10 * s * s, 400 + 20 * s])
        if frame is not None:
            R, T = frame.from_platform(R, T)
        rows.append([s, *T, *quaternion_from_rotation(R)])
    return "\n".join(["t," + ",".join(POSE), *(",".join(map(repr, map(float, r))) for r in rows)])


def _numbers(text):
    head, *rows = text.splitlines()
    columns = [row.split(",") for row in rows]
    return {name: [row[k] for row in columns] for k, name in enumerate(head.split(","))}


def _poses(table):
    expressed = np.array([table[name] for name in POSE], float).T
    return rotation_from_quaternion(expressed[:, 3:]), expressed[:, :3]


#: Numbers of the nearest fold that is found: they depend on the last digits of a pose.
_SEARCHED = {("clearance", name) for name in ("upper", "ratio", *"123456")}


@pytest.mark.parametrize("options", [(), ("--relative-to", "home")])
@pytest.mark.parametrize("command", ["measure", "dynamics", "clearance", "analyze", "sensors"])
def test_what_is_read_is_expressed(gsp, spec, tmp_path, command, options):
    """The answers are those for the same poses of the platform itself."""
    frame = PoseFrame.of(EXPRESSED, relative=bool(options))
    expressed, own = tmp_path / "expressed.csv", tmp_path / "own.csv"
    expressed.write_text(_path(frame), encoding="utf-8")
    own.write_text(_path(), encoding="utf-8")
    more = ("--sensor", "leg P1 B4") if command == "sensors" else ()
    masses = {}
    if command == "dynamics":
        pytest.importorskip("scipy")
        masses["dynamics"] = gspcli.Dynamics(gspcli.RigidBody(10, [0, 0, 20], [1, 1, 1, 0, 0, 0]))
    runs = [
        gsp(command, spec(replace(one, **masses)), path, *extra, *more, "--format", "csv")
        for one, path, extra in ((MACHINE, own, ()), (EXPRESSED, expressed, options))
    ]
    assert [run.code for run in runs] == [0, 0]
    tables = [_numbers(run.out) for run in runs]
    assert tables[0].keys() == tables[1].keys()
    for name, column in tables[0].items():
        if (command, name) in _SEARCHED:
            continue
        try:
            wanted, found = (np.array(t[name], float) for t in tables)
        except ValueError:
            assert column == tables[1][name]
            continue
        # A bound of clearances is the best that some norms and halvings prove.
        tolerance = 1e-2 if command == "clearance" else 1e-6
        assert found == pytest.approx(wanted, rel=tolerance, abs=1e-6)


@pytest.mark.parametrize("options", [(), ("--relative-to", "home")])
def test_track_prints_what_it_reads(gsp, spec, tmp_path, options):
    frame = PoseFrame.of(EXPRESSED, relative=bool(options))
    path = tmp_path / "path.csv"
    path.write_text(_path(frame), encoding="utf-8")
    run = gsp("track", spec(EXPRESSED), path, *options, "--format", "csv")
    assert run.code == 0
    for found, given in zip(
        _poses(_numbers(run.out)), _poses(_numbers(path.read_text())), strict=True
    ):
        assert found == pytest.approx(given, abs=1e-9)
    document = json.loads(gsp("track", spec(EXPRESSED), path, *options, "--format", "json").out)
    assert document["frames"]["relative_to"] == (options[1] if options else "work")
    assert document["poses"][0]["x"] == float(_numbers(run.out)["x"][0])
    shown = gsp("track", spec(EXPRESSED), path, *options).out
    assert f"x y z and the rotation: {frame.words}" in " ".join(shown.split())


@pytest.mark.parametrize("options", [(), ("--relative-to", "home")])
def test_solve_tells_each_mode(gsp, spec, options):
    frame, path = PoseFrame.of(EXPRESSED, relative=bool(options)), spec(EXPRESSED)
    result = gspcli.solve(MACHINE)
    R, T = frame.from_platform(result.R[result.real].real, result.T[result.real].real)
    table = _numbers(gsp("solve", path, *options, "--format", "csv").out)
    assert "Tx" not in table
    found = _poses(table)
    assert found[0] == pytest.approx(R, abs=1e-12)
    assert found[1] == pytest.approx(T, abs=1e-9)
    document = json.loads(gsp("solve", path, *options, "--format", "json").out)
    for entry, turn, at in zip(document["solutions"], R, T, strict=True):
        assert entry["expressed"]["position"] == pytest.approx(at, abs=1e-9)
        assert rotation_from_quaternion(
            np.array(entry["expressed"]["quaternion"])
        ) == pytest.approx(turn)
    # R and T are those of the platform itself: what reads them needs no frames.
    assert [entry["T"] for entry in document["solutions"]] == result.T[result.real].real.tolist()


def test_modes_are_read_again_in_both_forms(gsp, spec, tmp_path):
    path = spec(EXPRESSED)
    for form in ("json", "csv"):
        modes = tmp_path / f"modes.{form}"
        modes.write_text(gsp("solve", path, "--format", form).out, encoding="utf-8")
        table = _numbers(gsp("measure", path, modes, "--format", "csv").out)
        values = np.array([table[str(k)] for k in range(1, 7)], float)
        stated = [[row.value.value] for row in MACHINE.constraints]
        assert values == pytest.approx(np.broadcast_to(stated, values.shape), abs=1e-9)


def test_all_modes_are_certified_from_both_forms(gsp, spec, tmp_path):
    """Also those that are not real, whose coordinates in the frames are complex."""
    path = spec(EXPRESSED)
    for form in ("json", "csv"):
        modes = tmp_path / f"all.{form}"
        modes.write_text(gsp("solve", path, "--all", "--format", form).out, encoding="utf-8")
        run = gsp("certify", path, modes, "--format", "json")
        assert run.code == 0
        outcomes = [one["outcome"] for one in json.loads(run.out)["solutions"]]
        assert outcomes == ["certified"] * len(gspcli.solve(MACHINE).R)


def test_the_platforms_own_pose_is_refused_where_others_are_expressed(gsp, spec, tmp_path):
    path = tmp_path / "own.csv"
    path.write_text("Tx,Ty,Tz,qw,qx,qy,qz\n0,0,400,1,0,0,0\n", encoding="utf-8")
    run = gsp("measure", spec(EXPRESSED), path)
    assert run.code == 2
    assert "expected x y z: poses of the tool in the work frame" in run.err
    assert gsp("measure", spec(MACHINE), path).code == 0
    assert gsp("measure", spec(MACHINE), path, "--relative-to", "home").code == 2


def test_zero_is_home_for_every_way_to_give_a_pose(gsp, spec):
    path = spec(EXPRESSED)
    home = gsp("measure", spec(MACHINE), "--pose", "0,0,400,1,0,0,0", "--format", "csv").out
    wanted = np.array(list(_numbers(home).values())[1:7], float)
    for extra in ((), ("--pivot", "3,4,5")):
        for pose in (("0,0,0,1,0,0,0",), ("0,0,0,0,0,0", "--euler", "xyz")):
            run = gsp(
                "measure", path, "--pose", *pose, "--relative-to", "home", *extra, "--format", "csv"
            )
            found = np.array(list(_numbers(run.out).values())[1:7], float)
            assert found == pytest.approx(wanted, abs=1e-9)


def test_a_maker_in_an_option_says_its_order(gsp):
    for words in (("--rotation", "PI"), ("--near", "0,0,400,0,0,0", "--euler", "PI")):
        run = gsp("solve", "@workspace-study", *words)
        assert run.code == 0
        assert f"{words[-2]} PI: the order XYZ, about the axes of the platform" in run.err
    one, other = (
        gsp("solve", "@workspace-study", "--rotation", order, "--format", "csv").out
        for order in ("linuxcnc", "ZYX")
    )
    assert one == other
    run = gsp("solve", "@workspace-study", "--rotation", "SimHub")
    assert (run.code, run.out) == (2, "")


def test_without_home_nothing_is_relative_to_it(gsp, spec):
    run = gsp("solve", spec(replace(MACHINE, home=None)), "--relative-to", "home")
    assert (run.code, run.out) == (2, "")
    assert run.err.startswith("error: --relative-to home: the platform states no home")


@pytest.mark.parametrize("fmt", ["table", "csv", "json"])
@pytest.mark.parametrize(
    "words",
    [
        ("solve",),
        ("measure", "--pose", "0,0,400,1,0,0,0"),
        ("analyze",),
        ("clearance", "--mode", "home"),
        ("workspace",),
        ("scan", "--vary", "x=-9:9:3", "--pose", "0,0,400,1,0,0,0"),
    ],
)
def test_frames_of_no_turn_and_no_shift_change_no_byte(gsp, spec, words, fmt):
    one, other = (
        gsp(words[0], spec(instance), *words[1:], "--format", fmt) for instance in (MACHINE, STILL)
    )
    assert one.code == 0
    assert (one.out, one.err) == (other.out, other.err)


def test_workspace_travels_along_the_expressed_axes(gsp, spec):
    """A work frame turned by 90 degrees exchanges the axes; its proofs are about exact numbers."""
    turned = replace(MACHINE, frames=Frames(work=Frame([5, 0, 0], euler="ZYX", angles=[0, 0, 90])))
    plain, expressed = (
        {
            row["axis"]: row
            for row in json.loads(gsp("workspace", path, "--format", "json").out)["travel"]
        }
        for path in (spec(MACHINE), spec(turned))
    )
    for axis, other, sign in (("x", "y", 1), ("y", "x", -1), ("z", "z", 1)):
        ends = [plain[other]["down"], plain[other]["up"]]
        ends = ends if sign > 0 else [-end for end in reversed(ends)]
        assert [expressed[axis]["down"], expressed[axis]["up"]] == pytest.approx(ends, abs=1e-9)


def test_workspace_has_the_platforms_own_home_in_json(gsp, spec):
    document = json.loads(
        gsp("workspace", spec(EXPRESSED), "--relative-to", "home", "--format", "json").out
    )
    assert document["home"]["T"] == pytest.approx([0, 0, 400], abs=1e-9)
    assert document["frames"]["relative_to"] == "home"
    shown = gsp("workspace", spec(EXPRESSED), "--relative-to", "home").out
    assert "position (0, 0, 0), quaternion (1, 0, 0, 0)" in shown


@pytest.mark.parametrize("fmt", ["mjcf", "sdf"])
def test_models_mark_the_frames_and_keep_them(gsp, spec, tmp_path, fmt):
    """The pose of the tool in the work frame, as the model has it, is the expressed pose."""
    written = {}
    for name, instance in (("marked", EXPRESSED), ("plain", MACHINE)):
        written[name] = tmp_path / f"{name}.xml"
        run = gsp("export", spec(instance), "--to", fmt, "-o", written[name])
        assert run.code == 0
        assert "left out" not in run.err
    root = ET.parse(written["marked"]).getroot()
    tag, place = ("site", None) if fmt == "mjcf" else ("frame", "pose")
    found = {one.get("name"): one for one in root.iter(tag) if one.get("name") in ("tool", "work")}
    for name, stated in (("tool", FRAMES.tool), ("work", FRAMES.work)):
        one = found[name]
        text = one.get("pos") if place is None else one.find(place).text
        numbers = [float(x) for x in text.split()]
        assert numbers[:3] == pytest.approx(stated.T * 1e-3, abs=1e-12)
        if place is None:
            R = rotation_from_quaternion(np.array([float(x) for x in one.get("quat").split()]))
        else:
            R = rotation_from_euler("ZYX", np.array(numbers[3:]))
        assert pytest.approx(stated.R(np.pi / 180), abs=1e-12) == R
    assert not any(
        one.get("name") in ("tool", "work") for one in ET.parse(written["plain"]).iter(tag)
    )
    if fmt == "mjcf":
        pytest.importorskip("mujoco")
    again = tmp_path / "again.yaml"
    assert gsp("import", written["marked"], "-o", again).code == 0
    assert gspcli.load(again) == EXPRESSED


def test_programs_without_frames_say_so(gsp, spec, tmp_path):
    run = gsp("export", spec(EXPRESSED), "--to", "urdf", "-o", tmp_path / "m.urdf")
    assert run.code == 0
    assert "the frames of SPEC are left out" in run.err


def test_the_page_says_what_is_expressed(gsp, spec, tmp_path):
    page = tmp_path / "page.html"
    assert gsp("view", spec(EXPRESSED), "-o", page).code == 0
    assert "expressed x, y, z" in page.read_text(encoding="utf-8")
    assert gsp("view", spec(STILL), "-o", page).code == 0
    assert "expressed x, y, z" not in page.read_text(encoding="utf-8")


def test_plans_and_what_is_measured_are_expressed(gsp, spec, tmp_path):
    path, plan = spec(EXPRESSED), tmp_path / "plan.csv"
    run = gsp("calibrate", path, "--plan", "8", "--relative-to", "home", "-o", plan)
    assert run.code == 0
    frame = PoseFrame.of(EXPRESSED, relative=True)
    table = _numbers(plan.read_text(encoding="utf-8"))
    R, T = frame.to_platform(*_poses(table))
    values = np.array([table[str(k)] for k in range(1, 7)], float).T
    assert gspcli.measure(MACHINE, R, T) == pytest.approx(values, abs=1e-6)
    # Read again with the same option, the plan fits the machine as it is stated.
    run = gsp(
        "calibrate", path, plan, "--relative-to", "home", "--hold", "offsets",
        "--sigma", "value=0.01", "--sigma", "position=0.01", "--sigma", "rotation=0.001",
        "--hold-unknown",
    )  # fmt: skip
    assert run.code == 0
    wrong = gsp(
        "calibrate", path, plan, "--hold", "offsets", "--sigma", "value=0.01",
        "--sigma", "position=0.01", "--sigma", "rotation=0.001", "--hold-unknown",
    )  # fmt: skip
    assert wrong.code != 0
