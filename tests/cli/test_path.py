"""`gsp path`: files that other commands take, what is said, and exit codes."""

from __future__ import annotations

import json

import pytest

#: A pose of @rubin-m2 near its home, and home itself.
NEAR = "0,0,0.001,1,0,0,0"


def test_a_path_is_a_file_that_track_proves_again(gsp, tmp_path):
    file = str(tmp_path / "path.csv")
    run = gsp("path", "@rubin-m2", "--from", "home", "--to", NEAR, "-o", file)
    assert run.code == 0
    first, second = run.err.splitlines()[:2]
    assert first.startswith("from mode 2 to the goal: proved, ")
    assert "(the values change linearly)" in first
    assert second.startswith("length ")
    rows = (tmp_path / "path.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0] == "t,1,2,3,4,5,6,x,y,z,qw,qx,qy,qz,condition,clearance"
    required = "range, condition<=100"
    again = gsp("track", "@rubin-m2", file, "--require", required, "--format", "json")
    assert again.code == 0
    document = json.loads(again.out)
    assert document["certified"] is True
    assert document["departures"] == []
    assert document["modes"] == [2]


def test_paths_along_poses_are_proved_again(gsp, tmp_path):
    file = str(tmp_path / "path.csv")
    ends = ("--from", "1", "--to", "5")
    run = gsp("path", "@surfaces-sss", *ends, "-o", file)
    assert (run.code, "(position and angles change linearly)" in run.err) == (0, True)
    again = gsp("track", "@surfaces-sss", file, "--require", "condition<=10000")
    assert again.code == 0


def test_a_path_with_a_time_is_proved_again(gsp, tmp_path):
    file = str(tmp_path / "path.csv")
    ends = ("--from", "home", "--to", "0,0,0.001,1,0,0,0")
    limits = ("--speed", "0.001", "--acceleration", "0.002")
    run = gsp("path", "@rubin-m2", *ends, *limits, "-o", file)
    assert run.code == 0
    assert run.err.splitlines()[3].endswith("s: each drive at most 0.001 m/s and 0.002 m/s^2")
    assert gsp("track", "@rubin-m2", file, "--require", "range").code == 0
    more = ("--speed", "drives=0.001,platform=0.0005", "--format", "json")
    run = gsp("path", "@rubin-m2", *ends, *limits, *more)
    document = json.loads(run.out)
    assert document["along"] == "poses"
    timing = document["timing"]
    assert timing["speed"] == {"drives": 0.001, "platform": 0.0005}
    assert timing["seconds"] == document["rows"][-1]["t"] >= 0.001 / 0.0005
    assert timing["corners"] == 0


def test_a_path_to_where_it_begins_has_no_length(gsp):
    result = gsp("path", "@rubin-m2", "--from", "1", "--to", "1")
    assert result.code == 0
    assert "\nlength 0 m\n" in result.out


def test_signs_that_are_not_proved_are_explained(gsp):
    result = gsp("path", "@three-prs", "--all", "--time", "0.1")
    assert "?: the sign is not proved" in result.out
    assert "?:" not in gsp("path", "@rubin-m2", "--all").out


def test_json(gsp):
    run = gsp("path", "@rubin-m2", "--from", "home", "--to", NEAR, "--format", "json")
    assert (run.code, run.err) == (0, "")
    document = json.loads(run.out)
    assert document["schema"] == "gsp.path/1"
    assert (document["verdict"], document["along"]) == ("proved", "values")
    assert (document["from"], document["to"]) == ("mode 2", "the goal")
    (part,) = document["parts"]
    assert part["rows"] == [1, len(document["rows"])]
    assert part["clearance"] > 0
    assert document["length"] == pytest.approx(0.001)
    assert document["rows"][-1]["z"] == pytest.approx(0.001, abs=1e-12)


def test_proved_impossible_is_exit_code_1(gsp):
    for more in ((), ("--format", "json")):
        run = gsp("path", "@rubin-m2", "--from", "1", "--to", "2", *more)
        assert run.code == 1
        assert run.err == (
            "error: from mode 1 to mode 2 there is no path, proved\n"
            "the sign of det J differs, and a regular path keeps it\n"
        )
        assert bool(run.out) == bool(more)
    assert json.loads(run.out)["verdict"] == "impossible"


def test_not_found_is_exit_code_4(gsp):
    run = gsp("path", "@workspace-study", "--from", "home", "--to", "3", "--time", "1e-9")
    assert (run.code, run.out) == (4, "")
    assert run.err == (
        "error: from mode 16 to mode 3 no path was found in the time given\n"
        "it is not proved that there is none: try --time or another --seed\n"
    )


def test_all_modes(gsp):
    run = gsp("path", "@rubin-m2", "--all")
    assert (run.code, run.err) == (0, "")
    lines = run.out.splitlines()
    assert lines[2].startswith("2 groups: modes of one group are joined by proved paths")
    assert lines[6].split()[:3] == ["1", "+", "1"]
    assert "alone, proved" in lines[6]
    run = gsp("path", "@workspace-study", "--all", "--time", "1e-9")
    assert run.code == 4
    assert "no path was found, and it is not proved that there is none" in run.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--from", "home"), "give --from and --to, or --all"),
        ((), "give --from and --to, or --all"),
        (("--all", "--to", "2"), "give either --all or --to"),
        (("--from", "@-", "--to", "@-"), "--from and --to cannot both be standard input"),
        (("--from", "9", "--to", "2"), "found mode 9, expected one of the 2 real poses"),
        (("--from", "1,2", "--to", "2"), "--from: found 2 numbers"),
        (("--from", "home", "--to", "2", "--clear", "-1"), "-1.0 is not in the range"),
        (("--from", "home", "--to", "2", "--clear", "nan"), "not"),
        (("--from", "home", "--to", "2", "--time", "0"), "0.0 is not in the range"),
        (("--from", "home", "--to", "2", "--along", "lines"), "'lines' is not one of"),
        (
            ("--from", "home", "--to", "2", "--speed", "1"),
            "--speed is for --acceleration: give it, too",
        ),
        (("--all", "--speed", "1", "--acceleration", "1"), "give either --all or --speed"),
        (("--speed", "drive=1"), "'drive' is not one of drives, platform, turn"),
        (("--speed", "1,2"), "drives stands twice"),
        (("--speed", "turn=1"), "give drives, or both platform and turn"),
        (("--speed", "-1"), "-1.0 is not in the range"),
        (("--speed", "nan"), "not"),
    ],
)
def test_mistakes(gsp, words, message):
    run = gsp("path", "@rubin-m2", *words)
    assert (run.code, run.out) == (2, "")
    assert message in run.err


def test_cranks_move_linearly(gsp, tmp_path):
    file = str(tmp_path / "path.csv")
    run = gsp("path", "@t-top-head", "--from", "home", "--to", "0,0,0.175,1,0,0,0", "-o", file)
    assert run.code == 0
    assert "1 straight part (the drives change linearly)" in run.err
    rows = (tmp_path / "path.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0].startswith("t,crank.B1,crank.B2,")
    assert rows[0].endswith(",qz,condition")
    # The drives beside the poses are what the poses ask for.
    assert gsp("track", "@t-top-head", file, "--require", "condition<=20").code == 0
    words = rows[-1].split(",")
    words[1] = str(float(words[1]) + 1)
    (tmp_path / "path.csv").write_text("\n".join([*rows[:-1], ",".join(words)]), encoding="utf-8")
    run = gsp("track", "@t-top-head", file)
    assert run.code == 2
    assert "beside a pose that asks for" in run.err


def test_a_mode_beyond_a_dead_point_is_outside_the_limits(gsp):
    run = gsp("path", "@t-top-head", "--from", "home", "--to", "1")
    assert (run.code, run.out) == (1, "")
    assert run.err.endswith(
        "mode 1 is outside the limits: crank B1 is beyond a dead point from home\n"
    )


def test_rounding_errors_of_motors_are_zero_in_tables(gsp, tmp_path):
    path = tmp_path / "rotary.yaml"
    numbers = ["base=80,12", "platform=55,10", "horn=24", "rod=130"]
    gsp("new", "--rotary", *numbers, "-o", path)
    result = gsp("path", path, "--from", "home", "--to", "0,0,127,1,0,0,0")
    (first,) = (line for line in result.out.splitlines() if line.split()[:1] == ["0"])
    assert first.split()[1:7] == ["0"] * 6
