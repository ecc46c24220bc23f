"""Real poses that the machine cannot mean are counted and not listed; all else stays."""

import json
from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.home_pose import Frame, Frames, HomePose
from gspcli.motion.poses.mode_filters import ModeFilter, heights, parse_conditions

MACHINE = gspcli.example("workspace-study")
RESULT = gspcli.solve(MACHINE)
REAL = RESULT.counts.real
T = RESULT.T[:REAL].real


def _solved(gsp, *words):
    run = gsp("solve", *words, "--format", "json")
    return json.loads(run.out), run


def _numbers(document):
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
    assert _numbers(document) == wanted
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
    assert _numbers(equal) == flat
    assert sorted(_numbers(above) + _numbers(below) + flat) == list(range(1, REAL + 1))


def test_above_is_the_side_of_home(gsp, tmp_path):
    high = (np.flatnonzero(T[:, 2] > 0) + 1).tolist()
    assert _numbers(_solved(gsp, "@workspace-study", "--above")[0]) == high
    low = sorted(set(range(1, REAL + 1)) - set(high))
    for home, wanted in ((HomePose([0, 0, -400]), low), (None, high)):
        path = tmp_path / "machine.yaml"
        gspcli.dump(replace(MACHINE, home=home), path)
        assert _numbers(_solved(gsp, path, "--above")[0]) == wanted


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
    assert _numbers(_solved(gsp, path, "--where", "z>0")[0]) == wanted
    home = ("--relative-to", "home", "--where", "z>-1e-6,z<1e-6, x<1,x>-1, rz<1, rz>-1")
    assert _numbers(_solved(gsp, path, *home)[0]) == [16]
    orders = [
        _numbers(_solved(gsp, "@workspace-study", "--where", "rx>10", "--euler", order)[0])
        for order in ("XYZ", "ZYX")
    ]
    assert orders[0] != orders[1]


def test_within_limits_keeps_what_is_said_to_keep_them(gsp):
    whole, _ = _solved(gsp, "@workspace-study-cones")
    wanted = [entry["number"] for entry in whole["solutions"] if not entry["limits"]]
    found, _ = _solved(gsp, "@workspace-study-cones", "--within-limits")
    assert _numbers(found) == wanted
    assert 0 < len(wanted) < len(whole["solutions"])
    none, run = _solved(gsp, "@workspace-study-cones", "--set", "6=300", "--within-limits")
    assert (none["solutions"], run.code) == ([], 0)


def test_home_is_chosen_among_what_is_left(gsp):
    document, _ = _solved(gsp, "@workspace-study", "--where", "z<0")
    assert document["home"]["mode"] in _numbers(document)
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
    assert lines[2].startswith("16 real poses, all proved different; complete, proved")
    everything = gsp("solve", "@workspace-study", "--where", "x>-1e9").out
    assert "16 of 16 real poses kept; left out: none" in everything


def test_many_instances_have_their_own_answers(gsp):
    run = gsp("solve", "@workspace-study", "@rubin-m2", "--where", "z>0", "--format", "jsonl")
    documents = [json.loads(line) for line in run.out.splitlines()]
    assert _numbers(documents[0]) == (np.flatnonzero(T[:, 2] > 0) + 1).tolist()
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
