"""`gsp check`: its output for correct, unusual and wrong files."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from gspcli.resources import data_directory

Run = Callable[..., object]
EXAMPLES = data_directory() / "examples"


@pytest.fixture
def bad(tmp_path: Path) -> Path:
    text = (EXAMPLES / "example-6.8.yaml").read_text(encoding="utf-8")
    path = tmp_path / "bad.yaml"
    path.write_text(text.replace("[P1, L4]", "[P1, L9]").replace("60}", "181}"), encoding="utf-8")
    return path


def test_a_good_file_as_json(gsp: Run) -> None:
    path = str(EXAMPLES / "example-6.8.yaml")
    outcome = gsp("check", path, "--format", "json")
    assert outcome.code == 0
    assert outcome.err == ""
    assert json.loads(outcome.out) == {
        "schema": "gsp.check/1",
        "files": [
            {
                "file": path,
                "valid": True,
                "name": "Example 6.8",
                "type": {"id": "DPL DPL DPL ALL ALL ALL", "number": 421, "class": "3D3A"},
                "units": {"length": "unit", "angle": "deg"},
                "shared": {
                    "platform": {"P1": [4, 5, 6]},
                    "base": {"L4": [1, 4], "L5": [2, 5], "L6": [3, 6]},
                },
                "pattern": "P1-l1 P1-l2 P1-l3 L1^l1 L2^l2 L3^l3",
                "expected": 64,
                "bound": 64,
                "warnings": [],
            }
        ],
    }


def test_sides_left_open_double_the_counts(gsp: Run, tmp_path: Path) -> None:
    text = (EXAMPLES / "six-planes.yaml").read_text(encoding="utf-8")
    path = tmp_path / "two-sided.yaml"
    lines = [line.partition(", side:")[0] for line in text.splitlines()]
    closed = [line + "}" if line.startswith("  - ") else line for line in lines]
    path.write_text("\n".join(closed), encoding="utf-8")
    (row,) = csv.DictReader(io.StringIO(gsp("check", path, "--format", "csv").out))
    assert (row["expected"], row["bound"]) == (str(8 * 64), str(8 * 64))


def test_every_mistake_of_every_file_is_reported(gsp: Run, bad: Path) -> None:
    good = EXAMPLES / "dietmaier.yaml"
    outcome = gsp("check", bad, good, bad.with_name("none.yaml"), "--format", "csv")
    assert outcome.code == 2
    rows = list(csv.DictReader(io.StringIO(outcome.out)))
    assert [(row["valid"], row["expected"]) for row in rows] == [
        ("false", ""),
        ("true", "40"),
        ("false", ""),
    ]
    wrong = "found '181', expected an angle of LL from 0 to 180 (deg)"
    assert outcome.err.splitlines() == [
        f"error: {bad}:18:30: constraints[1].value: {wrong}",
        f"{bad}:19:30: constraints[2].value: {wrong}",
        f"{bad}:20:30: constraints[3].value: {wrong}",
        f"{bad}:21:21: constraints[4].distance[2]: found the unknown name 'L9', expected a "
        "primitive of the base: L4, L5 or L6",
        f"{bad.with_name('none.yaml')}: cannot be read: No such file or directory",
    ]


def test_the_problems_of_a_file_are_in_its_json(gsp: Run, bad: Path) -> None:
    outcome = gsp("check", bad, "--format", "json")
    (entry,) = json.loads(outcome.out)["files"]
    assert entry["valid"] is False
    assert entry["problems"][0] == {
        "line": 18,
        "column": 30,
        "path": "constraints[1].value",
        "message": "found '181', expected an angle of LL from 0 to 180 (deg)",
    }


def test_warnings_are_shown_and_are_no_failure(gsp: Run, tmp_path: Path) -> None:
    text = (EXAMPLES / "example-6.8.yaml").read_text(encoding="utf-8")
    path = tmp_path / "unusual.yaml"
    path.write_text(text.replace("value: 6}", "value: 0}"), encoding="utf-8")
    outcome = gsp("check", path)
    assert outcome.code == 0
    assert (
        f"warning: {path}:21:5: constraints[4]: DPL with value 0 is 2 equations, not one "
        "(Section 2): perhaps no solution, or infinitely many"
    ) in outcome.out


def test_all_examples_are_good(gsp: Run) -> None:
    examples = sorted(EXAMPLES.glob("*.yaml"))
    outcome = gsp("check", *examples, "--format", "json")
    assert outcome.code == 0
    warnings = [entry["warnings"] for entry in json.loads(outcome.out)["files"]]
    about = {path.stem: found for path, found in zip(examples, warnings, strict=True) if found}
    assert list(about) == ["point-on-line"]
    assert "DPL with value 0 is 2 equations" in about["point-on-line"][0]["message"]


def test_a_file_is_needed(gsp: Run) -> None:
    assert gsp("check").code == 2
