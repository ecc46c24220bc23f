from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "constraint-solvers.md").read_text(encoding="utf-8")


@pytest.fixture
def door(tmp_path):
    found = re.search(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    path = tmp_path / "door.yaml"
    path.write_text(found[1], encoding="utf-8")
    return path


def test_the_door_of_the_page(gsp, door):
    run = gsp("freedoms", door)
    assert (run.code, run.err) == (0, "")
    shown = re.search(r"\$ gsp freedoms door.yaml\n(.*?)```", PAGE, re.DOTALL)
    assert shown is not None
    assert [line.rstrip() for line in run.out.strip().splitlines()] == [
        line.rstrip() for line in shown[1].strip().splitlines()
    ]
    document = json.loads(gsp("freedoms", door, "--format", "json").out)
    assert document["schema"] == "gsp.freedoms/1"
    assert document["rank"] == 5
    assert document["screws"][0]["pitch"] == 0
    assert document["candidates"] == [
        {"kind": "DPP", "platform": "C", "base": "W", "removes": 1, "touches": [1]}
    ]


def test_a_pose_that_does_not_meet_the_values(gsp, door):
    run = gsp("freedoms", door, "--pose", "5,0,0,1,0,0,0")
    assert run.code == 0
    assert "this pose does not meet the stated value of 1" in run.out


def test_other_commands_name_this_one(gsp, door):
    for command in ("solve", "check", "count", "view"):
        run = gsp(command, door)
        assert run.code == 2
        assert "found 2 constraints, expected exactly six; gsp freedoms takes any number" in run.err


def test_what_is_missing(gsp, door):
    door.write_text(door.read_text("utf-8").replace("home: {position: [0, 0, 0]}\n", ""), "utf-8")
    run = gsp("freedoms", door)
    assert run.code == 2
    assert "SPEC states no home: give --pose" in run.err
    run = gsp("freedoms", door, "--euler", "ZYX")
    assert run.code == 2
    assert "says how --pose is read" in run.err


def test_joints_of_a_rotary_machine_are_where_the_arms_have_them(gsp):
    """A pose that the arms reach meets all values; one beyond their reach does not."""
    run = gsp("freedoms", "@t-top-head", "--pose", "0,0,0.175,1,0,0,0")
    assert run.code == 0
    assert "does not meet the stated value" not in run.out
    run = gsp("freedoms", "@t-top-head", "--pose", "0,0,0.9,1,0,0,0")
    assert "this pose does not meet the stated value of 1, 2, 3, 4, 5, 6" in run.out
