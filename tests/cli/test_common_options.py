"""Options that several commands share."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import click
import numpy as np
import pytest

import gspcli
from gspcli.cli.help import _words_of
from gspcli.cli.options import Finite
from gspcli.cli.pose_options import PoseType, real_poses
from gspcli.errors import GspError
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Frame, Frames, HomePose, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_quaternion
from gspcli.motion.poses.mode_filters import ModeFilter, heights, parse_conditions
from gspcli.resources import data_path
from gspcli.solver import solve
from tests.support.special.platforms import platforms, recorded
from tools.build.samples import commands

# One spelling of each option, and one meaning of each spelling, in all commands.


#: What differs by nature: the formats and tables that a command has.
_CHOICES_OF_A_COMMAND = {"--format", "--part"}
#: Options that go together: a command with the first has the others.
_TOGETHER = {
    "--set": ("--delta",),
    "--delta": ("--set",),
    "--near": ("--euler", "--pivot"),
    "--pose": ("--euler", "--pivot"),
    "--euler": ("--pivot",),
    "--scheduler": ("--jobs",),
}


def _uses() -> dict[str, dict[str, click.Option]]:
    """Return the options by spelling and command."""
    found: dict[str, dict[str, click.Option]] = defaultdict(dict)
    for name, command in commands():
        for parameter in command.params:
            if isinstance(parameter, click.Option):
                for spelling in (*parameter.opts, *parameter.secondary_opts):
                    found[spelling][name] = parameter
    return found


USES = _uses()
#: The types by spelling: completion in this process gives some others later.
TYPES = {
    spelling: {type(option.type) for option in uses.values()} for spelling, uses in USES.items()
}


#: Options whose meaning in a command is its own: `gsp import` prints no proved solutions, a path
#: begins and ends at poses, and the columns of `gsp enumerate` are those of its own table.
OWN = {
    "--all": {"path", "freedoms"},
    "--along": {"track"},
    "--columns": {"enumerate"},
    "--digits": {"import"},
    "--from": {"path", "calibrate"},
    "--stiffness": {"dynamics"},
    "--to": {"path"},
}


def _said(option: click.Option) -> str:
    """Return the first clause of a help: the meaning, before what is special to a command."""
    return re.split(r"[.:;](?:\s|$)", option.help or "")[0]


@pytest.mark.parametrize("spelling", [name for name, uses in USES.items() if len(uses) > 1])
def test_an_option_means_the_same_in_all_commands(spelling: str) -> None:
    own = OWN.get(spelling, set())
    uses = [option for name, option in USES[spelling].items() if name not in own]
    assert len({option.metavar for option in uses}) == 1
    assert len({option.is_flag for option in uses}) == 1
    assert len({_said(option) for option in uses}) == 1
    assert own or len(TYPES[spelling]) == 1
    assert len({(option.multiple, option.nargs) for option in uses}) == 1
    if spelling not in _CHOICES_OF_A_COMMAND:
        choices = {
            tuple(option.type.choices) for option in uses if isinstance(option.type, click.Choice)
        }
        assert len(choices) < 2


@pytest.mark.parametrize("first", _TOGETHER)
def test_options_that_go_together(first: str) -> None:
    assert USES[first]
    for other in _TOGETHER[first]:
        assert set(USES[first]) <= set(USES[other]), other


def test_a_pose_is_written_in_one_way() -> None:
    poses = [
        option for uses in USES.values() for option in uses.values() if option.metavar == "POSE"
    ]
    assert len(poses) > 8
    assert all(isinstance(option.type, PoseType) for option in poses)
    assert set(USES["--near"]) | set(USES["--pose"]) == {
        name for uses in USES.values() for name, o in uses.items() if isinstance(o.type, PoseType)
    }


def test_who_reads_an_instance_takes_other_values_for_it() -> None:
    # Of these the values make no difference, or there is none to begin with.
    without = {"check", "calibrate", "freedoms", "measure", "maximize-real", "realize"}
    readers = {
        name
        for name, command in commands()
        if any("SPEC" in _words_of(p) for p in command.params if isinstance(p, click.Argument))
    }
    assert readers - without == set(USES["--set"])


def test_results_go_to_a_file_everywhere() -> None:
    named = {name for name, _ in commands()}
    assert named == set(USES["-o"])


@pytest.mark.parametrize("pose", ["1,2,3,1,0,0,0", "1,2,3,0,0,0 --euler ZYX", "@FILE"])
def test_every_command_takes_a_pose_in_each_form(gsp: Callable, tmp_path, pose: str) -> None:
    file = tmp_path / "pose.csv"
    file.write_text("x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,0\n")
    words = pose.replace("FILE", str(file)).split()
    spec = "@octahedral-3-3"
    runs = {
        ("solve", spec, "--near"): (),
        ("measure", spec, "--pose"): (),
        ("analyze", spec, "--pose"): (),
        ("clearance", spec, "--pose"): (),
        ("scan", spec, "--vary", "x=0:1:2", "--pose"): (),
    }
    for run, more in runs.items():
        outcome = gsp(*run, *words, *more)
        assert outcome.code == 0, outcome.err
    several = tmp_path / "poses.csv"
    several.write_text("x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,0\n1,2,4,1,0,0,0\n")
    for run, more in runs.items():
        outcome = gsp(*run, f"@{several}", *more)
        assert (outcome.code, outcome.out) == (2, "")
        assert "found 2 poses, expected one" in outcome.err


def test_values_are_set_and_added_to(gsp: Callable) -> None:
    spec = "@octahedral-3-3"
    set_ = gsp("solve", spec, "--set", "1=1.6", "--format", "csv").out
    one = gsp("solve", spec, "--set", "1=1.5", "--delta", "1=0.1", "--format", "csv").out
    assert set_ == one
    other = gsp("solve", spec, "--delta", "1=0.1", "--format", "csv").out
    assert other != gsp("solve", spec, "--format", "csv").out
    wrong = gsp("analyze", spec, "--delta", "1=-9")
    assert (wrong.code, wrong.out) == (2, "")
    assert wrong.err.startswith("error: --delta '1=-9': found '-9', expected a distance")


# Logs without a heading: the message, and `--columns` in every command that reads tables.


POSES = "0 0 0 400 1 0 0 0\n1 0 0 401 1 0 0 0\n2 0 0 402 1 0 0 0\n"
NAMES = "t,x,y,z,qw,qx,qy,qz"
COMMANDS = [
    ("measure", "@workspace-study", "LOG"),
    ("track", "@workspace-study", "LOG"),
    ("analyze", "@workspace-study", "LOG"),
    ("clearance", "@workspace-study", "LOG"),
    ("sensors", "@workspace-study", "LOG", "--sensor", "leg P1 B4"),
    ("view", "@workspace-study", "--track", "LOG"),
]


@pytest.mark.parametrize("words", COMMANDS, ids=[words[0] for words in COMMANDS])
def test_names_stand_for_the_heading(gsp, tmp_path, words):
    log, headed = tmp_path / "log.txt", tmp_path / "headed.csv"
    log.write_text(POSES, encoding="utf-8")
    headed.write_text(NAMES.replace(",", " ") + "\n" + POSES, encoding="utf-8")
    runs = [
        gsp(*(str(path) if word == "LOG" else word for word in words), *more)
        for path, more in ((log, ()), (log, ("--columns", NAMES)), (headed, ()))
    ]
    assert runs[0].code == 2
    assert runs[0].err.startswith(
        f"error: {log}:1:1: the first line has numbers: give names with --columns x,y,z,..."
    )
    assert runs[1].code == runs[2].code == 0
    assert runs[1].out == runs[2].out


def test_forces_and_measurements_have_names_too(gsp, tmp_path):
    log = tmp_path / "log.txt"
    log.write_text("0.5 2\n", encoding="utf-8")
    for words in (
        ("calibrate", "@workspace-study-cones", log),
        ("calibrate", "--from", log),
        ("dynamics", "@workspace-study", log),
    ):
        assert "give names with --columns" in gsp(*words).err
        assert "give names with --columns" not in gsp(*words, "--columns", "t,1").err


def test_one_pose_of_a_file_has_its_own_heading(gsp, tmp_path):
    pose = tmp_path / "pose.csv"
    pose.write_text("x,y,z,qw,qx,qy,qz\n0,0,400,1,0,0,0\n", encoding="utf-8")
    run = gsp("analyze", "@workspace-study", "--pose", f"@{pose}", "--columns", "a,b")
    assert run.code == 0


# Every command that reads or prints poses tells them in the frames of the file.


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


# Real poses that the machine cannot mean are counted and not listed; all else stays.


RESULT = gspcli.solve(MACHINE)
REAL = RESULT.counts.real
T = RESULT.T[:REAL].real


def _solved(gsp, *words):
    run = gsp("solve", *words, "--format", "json")
    return json.loads(run.out), run


def _mode_filters_numbers(document):
    return [entry["number"] for entry in document["solutions"]]


@pytest.mark.parametrize(
    ("texts", "kept"),
    [
        (["z>0"], T[:, 2] > 0),
        (["0<z"], T[:, 2] > 0),
        (["z<=-282.0729, x>=-1"], (T[:, 2] <= -282.0729) & (T[:, 0] >= -1)),
        (["z>0 and y>1"], (T[:, 2] > 0) & (T[:, 1] > 1)),
        (["z>0", "y>1"], (T[:, 2] > 0) & (T[:, 1] > 1)),
        (["z>1e9"], T[:, 2] > 1e9),
    ],
)
def test_where(gsp, texts, kept):
    words = [word for text in texts for word in ("--where", text)]
    document, run = _solved(gsp, "@workspace-study", *words)
    assert run.code == 0
    wanted = (np.flatnonzero(kept) + 1).tolist()
    assert _mode_filters_numbers(document) == wanted
    assert document["left_out"]["modes"] == sorted(set(range(1, REAL + 1)) - set(wanted))
    assert sum(len(one["modes"]) for one in document["left_out"]["reasons"]) == REAL - len(wanted)
    # Numbers, counts and completeness are those of all poses.
    whole, _ = _solved(gsp, "@workspace-study")
    assert document["counts"] == whole["counts"]
    assert document["proof"] == whole["proof"]
    for entry in document["solutions"]:
        other = dict(whole["solutions"][entry["number"] - 1])
        assert {**entry, "home": None} == {**other, "home": None}
    assert "left_out" not in whole


def test_zero_that_is_a_rounding_error_is_equal_to_the_bound(gsp):
    """Poses 2 and 16, and their mirror images, have y = 0."""
    flat = [k + 1 for k in range(REAL) if abs(T[k, 1]) < 1e-9]
    above, _ = _solved(gsp, "@workspace-study", "--where", "y>0")
    below, _ = _solved(gsp, "@workspace-study", "--where", "y<0")
    equal, _ = _solved(gsp, "@workspace-study", "--where", "y>=0, y<=0")
    assert _mode_filters_numbers(equal) == flat
    assert sorted(_mode_filters_numbers(above) + _mode_filters_numbers(below) + flat) == list(
        range(1, REAL + 1)
    )


def test_above_is_the_side_of_home(gsp, tmp_path):
    high = (np.flatnonzero(T[:, 2] > 0) + 1).tolist()
    assert _mode_filters_numbers(_solved(gsp, "@workspace-study", "--above")[0]) == high
    low = sorted(set(range(1, REAL + 1)) - set(high))
    for home, wanted in ((HomePose([0, 0, -400]), low), (None, high)):
        path = tmp_path / "machine.yaml"
        gspcli.dump(replace(MACHINE, home=home), path)
        assert _mode_filters_numbers(_solved(gsp, path, "--above")[0]) == wanted


def test_above_does_not_depend_on_the_frame_of_the_base():
    """The base is turned on its side, and the platform with it."""
    from gspcli.geometry.expressed_instances import expressed_instance

    tilted = replace(MACHINE, frames=Frames(work=Frame([30, 0, 9], [1, 1, 0.5, 0])))
    turned = replace(expressed_instance(tilted), home=None)
    frame = PoseFrame.of(tilted)
    home = frame.from_platform(np.eye(3), np.array([0, 0, 400.0]))
    turned = replace(turned, home=HomePose(home[1].tolist(), euler="ZYX", angles=[0, 0, 0]))
    there = gspcli.solve(turned)
    R, at = (part[: there.counts.real].real for part in (there.R, there.T))
    assert np.sort(heights(there, R, at)) == pytest.approx(np.sort(T[:, 2]), abs=1e-6)


def test_where_reads_the_frames_of_the_file_and_the_order_of_angles(gsp, tmp_path):
    path = tmp_path / "machine.yaml"
    gspcli.dump(replace(MACHINE, frames=Frames(work=Frame([0, 0, 300]))), path)
    wanted = (np.flatnonzero(T[:, 2] > 300) + 1).tolist()
    assert _mode_filters_numbers(_solved(gsp, path, "--where", "z>0")[0]) == wanted
    home = ("--relative-to", "home", "--where", "z>-1e-6,z<1e-6, x<1,x>-1, rz<1, rz>-1")
    assert _mode_filters_numbers(_solved(gsp, path, *home)[0]) == [16]
    orders = [
        _mode_filters_numbers(
            _solved(gsp, "@workspace-study", "--where", "rx>10", "--euler", order)[0]
        )
        for order in ("XYZ", "ZYX")
    ]
    assert orders[0] != orders[1]


def test_within_limits_keeps_what_is_said_to_keep_them(gsp):
    whole, _ = _solved(gsp, "@workspace-study-cones")
    wanted = [entry["number"] for entry in whole["solutions"] if not entry["limits"]]
    found, _ = _solved(gsp, "@workspace-study-cones", "--within-limits")
    assert _mode_filters_numbers(found) == wanted
    assert 0 < len(wanted) < len(whole["solutions"])
    none, run = _solved(gsp, "@workspace-study-cones", "--set", "6=300", "--within-limits")
    assert (none["solutions"], run.code) == ([], 0)


def test_home_is_chosen_among_what_is_left(gsp):
    document, _ = _solved(gsp, "@workspace-study", "--where", "z<0")
    assert document["home"]["mode"] in _mode_filters_numbers(document)
    assert [e["number"] for e in document["solutions"] if e["home"]] == [document["home"]["mode"]]
    shown = gsp("solve", "@workspace-study", "--where", "z<0").out
    assert f"home is mode {document['home']['mode']}: nearest to the stated home" in shown
    alone = gsp("solve", "@workspace-study", "--where", "z>399").out
    assert "home is mode 16: the only real pose that is kept" in alone
    nothing, _ = _solved(gsp, "@workspace-study", "--where", "z>999")
    assert nothing["home"] is None


def test_one_line_says_what_is_left_out(gsp):
    lines = gsp("solve", "@workspace-study", "--above", "--where", "x>0").out.splitlines()
    kept = int(((T[:, 2] > 0) & (T[:, 0] > 1e-6)).sum())
    low = int((T[:, 0] <= 1e-6).sum())
    said = f"{kept} of 16 real poses kept; left out: {low} by x>0, {16 - kept - low} by above"
    assert said in lines
    assert lines[2] == "16 real poses, each proved, all different"
    everything = gsp("solve", "@workspace-study", "--where", "x>-1e9").out
    assert "16 of 16 real poses kept; left out: none" in everything


def test_many_instances_have_their_own_answers(gsp):
    run = gsp("solve", "@workspace-study", "@rubin-m2", "--where", "z>0", "--format", "jsonl")
    documents = [json.loads(line) for line in run.out.splitlines()]
    assert _mode_filters_numbers(documents[0]) == (np.flatnonzero(T[:, 2] > 0) + 1).tolist()
    assert all("left_out" in document for document in documents)
    # What cannot be asked of one instance stops no other.
    mixed = gsp("solve", "@example-6.8", "@workspace-study", "--above", "--format", "jsonl")
    first, second = (json.loads(line) for line in mixed.out.splitlines())
    assert (first["exit_code"], second["exit_code"]) == (2, 0)
    assert "no one plane" in first["message"]


def test_poses_that_are_not_real_are_listed_with_all(gsp):
    some, _ = _solved(gsp, "@workspace-study", "--where", "z>0", "--all")
    assert [entry["real"] for entry in some["solutions"]].count(False) == len(RESULT.R) - REAL


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--where", "q>0"), "--where: found 'q>0', expected a condition such as z>0"),
        (("--where", "z>"), "found 'z>'"),
        (("--where", "z>0,"), "found ''"),
        (("--where", "0<z<9"), "found '0<z<9'"),
        (("--where", "z=0"), "found 'z=0'"),
        (("--where", "z>nan"), "found 'z>nan'"),
    ],
)
def test_conditions_that_are_none(gsp, words, message):
    run = gsp("solve", "@workspace-study", *words)
    assert (run.code, run.out) == (2, "")
    assert message in run.err


def test_without_limits_or_a_plane_there_is_nothing_to_keep(gsp):
    run = gsp("solve", "@example-6.8", "--within-limits")
    assert run.err == "error: --within-limits: the platform states no range and no cone\n"
    run = gsp("solve", "@example-6.8", "--above")
    assert run.err == "error: --above: the points of the base are in no one plane\n"


def test_from_python():
    assert not ModeFilter()
    left = ModeFilter(parse_conditions("z>0"), above=True).left_out(RESULT)
    assert left == {"z>0": (np.flatnonzero(T[:, 2] <= 0) + 1).tolist()}


# Numbers and files on the command line that nothing can be done with: exit code 2, and why.


Run = Callable[..., object]
HUGE = "1" + "0" * 30
_KEPT = {"schema": "gsp.maximize-real/1", "subject": "6PP", "seed": 20031, "attempts": 1, "real": 2}
_SHAPES = {"kinds": ["DPP"] * 6, **dict.fromkeys("yxuv", [[0.0] * 3] * 6), "values": [1.0] * 6}
FORGED = [
    json.dumps(_KEPT | changes).encode()
    for changes in (
        {"attempts": "many"},
        {"attempts": -1},
        {"real": 1.5},
        _SHAPES | {"y": [[0.0] * 2] * 6},
        _SHAPES | {"values": [1.0] * 5},
        _SHAPES | {"values": [float("nan")] * 6},
    )
]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("count @dietmaier --effort nan", "'--effort': nan is not a finite number"),
        ("count @dietmaier --effort inf", "'--effort': inf is not a finite number"),
        ("certify @dietmaier - --max-deviation nan", "'--max-deviation': nan is not"),
        ("analyze @dietmaier --length inf", "'--length': inf is not a finite number"),
        ("workspace @workspace-study --gap nan", "'--gap': nan is not a finite number"),
        ("calibrate @dietmaier - --prior nan", "'--prior': nan is not a finite number"),
        ("calibrate @dietmaier - --prior inf", "'--prior': inf is not a finite number"),
        ("sensors @dietmaier --need nan", "'--need': nan is not a finite number"),
        ("calibrate @workspace-study --plan 3001", "'--plan': 3001 is not at most 300"),
        *(
            (words.replace("NUMBER", number), "expected")
            for number in ("nan", "inf", "1e999")
            for words in (
                "calibrate @dietmaier - --sigma value=NUMBER",
                "calibrate @dietmaier - --target P1=0,0,NUMBER",
                "measure @dietmaier - --pivot 0,0,NUMBER",
                "measure @dietmaier --pose 0,0,NUMBER,1,0,0,0",
                "solve @dietmaier --set 1=NUMBER",
                "analyze @dietmaier --load 0,0,NUMBER",
                "scan @dietmaier --vary x=0:NUMBER:5 --pose 0,0,1,1,0,0,0",
                "workspace @workspace-study --shift z=0:NUMBER:3",
                "sensors @dietmaier --sigma point=NUMBER",
                "measure @dietmaier --pose 0,0,1,1,0,0,0 --require condition<=NUMBER",
            )
        ),
        (f"sample 6PP --count {HUGE}", f"'--count': {HUGE} is not at most 1000000000"),
        (f"sample 6PP --seed {HUGE}", f"'--seed': {HUGE} is not at most 9223372036854775807"),
        (f"sample 6PP --jobs {HUGE}", f"'--jobs': {HUGE} is not at most 1000"),
        (f"solve @dietmaier --jobs {HUGE}", f"'--jobs': {HUGE} is not at most 1000"),
        (f"solve @dietmaier --seed {HUGE}", "is not at most 9223372036854775807"),
        ("solve @dietmaier --seed -1", "-1 is not in the range x>=0"),
        (f"enumerate --max-table-3 {HUGE}", "is not at most 1000000000"),
        (f"enumerate --first {HUGE}", "is not at most 1000000000"),
        (f"track @dietmaier - --steps {HUGE}", "is not at most 1000000000"),
    ],
)
def test_numbers_that_are_none_or_too_large(gsp: Run, words: str, said: str) -> None:
    outcome = gsp(*words.split())
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err


def test_every_option_that_is_a_number_refuses_what_is_not_finite() -> None:
    """In one place, `Finite`: comparisons with NaN are false, so that a range lets it pass."""
    found = 0
    for name, command in commands():
        for option in command.params:
            if isinstance(option.type, click.types.FloatParamType):
                found += 1
                assert isinstance(option.type, Finite), (name, option.name)
            if isinstance(option.type, click.types.FloatParamType | click.types.IntParamType):
                for number in ("nan", "inf", "-inf", "1e999"):
                    with pytest.raises(click.BadParameter):
                        option.type.convert(number, None, None)
    assert found >= 9


@pytest.mark.parametrize("content", [b"\xb9\x00\xff", b"[" * 100_000, b"{}", *FORGED])
def test_a_state_that_is_none(gsp: Run, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "state.json"
    path.write_bytes(content)
    outcome = gsp("maximize-real", "6PP", "--attempts", "1", "--resume", path)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err == (
        f"error: {path}: this is not a state of gsp maximize-real: choose another file\n"
    )
    assert path.read_bytes() == content


def test_a_journal_that_is_none(gsp: Run, tmp_path: Path) -> None:
    path = tmp_path / "work.jsonl"
    path.write_bytes(b"\xb9\x00\xff")
    outcome = gsp("scan", "@octahedral-3-3", "--vary", "1=1.4:1.6:5", "--resume", path)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err == f"error: {path}:1: this is not a line of a work file\n"
    assert path.read_bytes() == b"\xb9\x00\xff"


def test_a_cell_of_a_megabyte(gsp: Run, tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_text('x,y,z,qw,qx,qy,qz\n0,0,1,1,0,0,"' + "1" * 1_000_000 + '"\n')
    outcome = gsp("certify", "@dietmaier", path)
    assert (outcome.code, outcome.out) == (2, "")
    assert f"{path}:2:1: found no row of CSV: field larger than field limit" in outcome.err
    for words in (("measure", "@dietmaier", path), ("view", "@dietmaier", "--track", path)):
        outcome = gsp(*words)
        assert (outcome.code, outcome.out) == (2, "")
        assert len(outcome.err) < 300


def test_a_row_over_several_lines(gsp: Run, tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_text('x,y,z,qw,qx,qy,qz\n0,0,1,1,0,0,0\n0,b,",1,0,0,0\n0,0,1,1,0,0,0\n')
    outcome = gsp("certify", "@dietmaier", path)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {path}:3:1: ")


def test_a_column_and_a_count_of_thousands_of_digits(gsp: Run, tmp_path: Path) -> None:
    path = tmp_path / "values.csv"
    path.write_text("t," + "9" * 5000 + ",1\n0,1,1\n1,1,1\n")
    outcome = gsp("track", "@dietmaier", path)
    assert (outcome.code, outcome.out) == (2, "")
    assert "…, expected a constraint from 1 to 6" in outcome.err
    for words in (
        ("scan", "@dietmaier", "--vary", "1=1:2:" + "9" * 5000),
        ("workspace", "@workspace-study", "--shift", "z=0:1:" + "9" * 5000),
        ("workspace", "@workspace-study", "--shift", "z=0:1:999999999"),
    ):
        outcome = gsp(*words)
        assert (outcome.code, outcome.out) == (2, "")
        assert len(outcome.err) < 300


# Requirements and sensors of a platform by its readings are those of the corrected platform.


MASSES = gspcli.Dynamics(gspcli.RigidBody(12, [0, 0, 0], [1, 1, 1, 0, 0, 0]))
#: Offsets are larger than the ranges (28 mm) are wide, and scales move values by as much.
OFFSETS = {0: "0.04", 1: "0.4", 3: "-sqrt(2)/10"}
SCALES = {1: "-0.2", 4: "0.1"}
HOME = np.eye(3)[None], np.array([[0.0, 0.0, 0.002]])


def corrected() -> Instance:
    instance = gspcli.load(data_path("platforms", "rubin-m2.yaml"))
    return replace(instance, dynamics=MASSES)


def by_readings() -> Instance:
    rows = list(corrected().constraints)
    for k, text in OFFSETS.items():
        rows[k] = replace(rows[k], offset=Number.of(text))
    for k, text in SCALES.items():
        rows[k] = replace(rows[k], scale=Number.of(text))
    return replace(corrected(), constraints=tuple(rows))


def _readings_poses(instance: Instance) -> str:
    del instance
    return "t,x,y,z,qw,qx,qy,qz\n" + "".join(f"{k},0,0,{k / 1e3},1,0,0,0\n" for k in range(8))


def _values(instance: Instance) -> str:
    T = np.linspace((0, 0, 0), (0, 0, 0.007), 8)
    rows = gspcli.measure(instance, np.tile(np.eye(3), (8, 1, 1)), T)
    lines = [",".join(map(repr, [float(k), *row])) for k, row in enumerate(rows.tolist())]
    return "\n".join(["t,1,2,3,4,5,6", *lines])


@pytest.mark.parametrize(
    ("rows", "arguments"),
    [
        (_readings_poses, ["measure"]),
        (_readings_poses, ["analyze"]),
        (_readings_poses, ["dynamics"]),
        (_values, ["track", "--mode", "1"]),
        (_values, ["dynamics", "--mode", "1"]),
    ],
)
@pytest.mark.parametrize("most", ["0.3", "0.6"])
def test_ranges_are_required_of_values(gsp, tmp_path, rows, arguments, most):
    found = []
    for instance in (by_readings(), corrected()):
        spec, path = tmp_path / "spec.yaml", tmp_path / "rows.csv"
        spec.write_text(gspcli.dumps(instance))
        path.write_text(rows(instance))
        command, *more = arguments
        asked = ("--require", f"range<={most}", "--format", "json")
        run = gsp(command, spec, path, *more, *asked)
        (told,) = json.loads(run.out)["requirements"]
        found.append((run.code, told["met"], told["worst"]))
    (code, met, worst), (same_code, same_met, same_worst) = found
    assert (code, met) == (same_code, same_met) == (0 if same_met else 1, same_met)
    assert worst == pytest.approx(same_worst, abs=1e-9)
    # 7 mm along z use half of the 14 mm on either side: one bar is kept, one is not.
    assert met is (most == "0.6")


@pytest.mark.parametrize("ranged", [True, False])
def test_sensors_see_the_same_modes(ranged):
    found = []
    for instance in (by_readings(), corrected()):
        if not ranged:
            rows = tuple(replace(row, limits=None) for row in instance.constraints)
            instance = replace(instance, constraints=rows)
        found.append(gspcli.sensors(instance, sensors=["leg P1 B2", "inclinometer"]))
    one, other = found
    assert one.separations.modes.tolist() == other.separations.modes.tolist()
    assert other.separations.modes.max() > 1
    assert one.separations.least == pytest.approx(other.separations.least, rel=1e-6, abs=1e-6)


def test_sensors_at_rows_of_readings():
    R, T = np.tile(HOME[0], (3, 1, 1)), np.linspace((0, 0, 0), (0.001, 0.002, 0.003), 3)
    found = [
        gspcli.sensors(instance, gspcli.measure(instance, R, T), sensors=["leg P1 B2"])
        for instance in (by_readings(), corrected())
    ]
    assert found[0].separations.modes.tolist() == found[1].separations.modes.tolist()
    assert found[0].separations.least == pytest.approx(found[1].separations.least, rel=1e-6)
    assert found[1].separations.modes.min() > 1


FIT = ("solve", "@rubin-m2", "--fit", "--sigma", "value=0.001", "--reading")


def test_a_fit_of_more_than_six(gsp):
    run = gsp(*FIT, "leg P1 B2 = 2.913 ± 0.002")
    assert run.code == 0
    assert run.out.splitlines()[2].startswith("one pose fits the 7 numbers: chi-squared 0.0")
    assert "it is not proved that there are no others" in run.out
    assert "leg P1 B2" in run.out
    document = json.loads(gsp(*FIT, "leg P1 B2 = 2.913 ± 0.002", "--format", "json").out)
    assert document["fit"]["fitting"] == [1]
    assert np.shape(document["fit"]["poses"][0]["covariance"]) == (6, 6)
    rows = gsp(*FIT, "leg P1 B2 = 2.913 ± 0.002", "--format", "csv").out.splitlines()
    assert rows[0].startswith("number,Tx,Ty,Tz,qw,qx,qy,qz,chi_squared,probability,")


def test_a_fit_that_fails(gsp):
    run = gsp(*FIT, "leg P1 B2 = 2.953 ± 0.002")
    assert run.code == 1
    assert "the data do not show which" in run.err


def test_wrong_use_of_fit(gsp):
    for words, message in (
        (("solve", "@rubin-m2", "--fit"), "--fit needs readings besides the six values"),
        (("solve", "@rubin-m2", "--sigma", "value=1"), "--sigma is for --fit"),
        ((*FIT, "leg P1 B2 = 3 ± 1", "--all"), "--all: not with --fit"),
        ((*FIT, "leg P1 B2 = 3 ± 1", "@dietmaier"), "for one SPEC"),
        ((*FIT, "leg P1 B2 = 3 ± 1", "--sigma", "value"), "expected WHAT=NUMBER"),
        (("solve", "@rubin-m2", "--fit", "--reading", "leg P1 B2 = 3 ± 1"), "give --sigma value="),
    ):
        run = gsp(*words)
        assert run.code == 2, words
        assert message in run.err


# Commands that need one real pose number them as `gsp solve` does, on special platforms too.


#: Of a platform whose lines touch there was a second mode that met no constraint.
TOUCHING = "line-pairs/2/parallel-touching"
#: This many platforms of the corpus, those with the fewest solutions, one for each group.
COUNT = 12


def _sample() -> list[str]:
    finite = [(int(row["count"]), name) for name, row in recorded().items() if row["count"]]
    by_group: dict[str, str] = {}
    for _, name in sorted(finite):
        by_group.setdefault(name.split("/")[0], name)
    return [*list(by_group.values())[:COUNT], TOUCHING]


@pytest.fixture(scope="module")
def corpus():
    groups = dict.fromkeys(name.split("/")[0] for name in _sample())
    return {platform.id: platform.instance for platform in platforms(groups)}


@pytest.mark.parametrize("name", _sample())
def test_modes_are_those_of_solve(name: str, corpus) -> None:
    result = solve(corpus[name])
    real = recorded()[name]["real"]
    assert result.counts.real == int(real or result.counts.real)
    if not result.counts.real or result.verdict != "complete":
        with pytest.raises(GspError):
            real_poses(corpus[name])
        return
    R, T = real_poses(corpus[name])
    np.testing.assert_array_equal(R, result.R[result.real].real)
    np.testing.assert_array_equal(T, result.T[result.real].real)


def test_lines_that_touch_have_one_mode(corpus) -> None:
    assert len(real_poses(corpus[TOUCHING])[0]) == 1
