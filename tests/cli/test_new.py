"""`gsp new`: what it writes can be read, solved and repeated."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from gspcli.defaults import SEED
from gspcli.geometry.instance import Side
from gspcli.spec import loads

Run = Callable[..., object]


def test_the_same_command_gives_the_same_bytes(gsp: Run) -> None:
    outcome = gsp("new", "6PP", "--decimals", "2")
    assert outcome.code == 0
    assert outcome.out == gsp("new", "DPP", "PP PP", "3pp", "--decimals", 2, "--seed", SEED).out
    assert outcome.out != gsp("new", "6PP", "--decimals", "2", "--seed", 1).out
    assert outcome.out.startswith("# DPP DPP DPP DPP DPP DPP (type 3389, 6D)\ngsp: 1\n")


@pytest.mark.parametrize("name", ["627", "3D3A PL PH HP ALL ALH AHH", "hp,ph,pl all ahh alh"])
def test_a_type_in_any_spelling(gsp: Run, name: str) -> None:
    assert loads(gsp("new", *name.split()).out).type.number == 627


def test_a_template_is_a_correct_file_with_comments(gsp: Run) -> None:
    outcome = gsp("new", "627", "--template")
    assert loads(outcome.out) == loads(gsp("new", "627").out)
    assert "constraints:  # exactly six; the platform's primitive comes first\n" in outcome.out
    assert "  # ALH: angle of a platform line and a base plane, -90 to 90\n" in outcome.out
    assert outcome.out.count("; side: positive, negative or both") == 2


def test_planar_and_one_sided(gsp: Run) -> None:
    instance = loads(gsp("new", "6PH", "--planar", "--one-sided").out)
    for constraint in instance.constraints:
        assert constraint.platform.position[2].fraction == 0
        assert constraint.base.position[2].fraction == 0
        assert constraint.side is not Side.BOTH


def test_a_pattern_of_shared_primitives(gsp: Run, tmp_path: Path) -> None:
    path = tmp_path / "octahedron.yaml"
    pattern = "P1-p1 P1-p2 P2-p1 P2-p3 P3-p2 P3-p3"
    assert gsp("new", pattern, "-o", path).code == 0
    (entry,) = json.loads(gsp("check", path, "--format", "json").out)["files"]
    assert entry["pattern"] == pattern


def test_a_pattern_that_never_fixes_the_platform_is_refused(gsp: Run) -> None:
    outcome = gsp("new", "P1-p1 P1-p2 P1-p3 P1-p4 P2-p1 P2-p2")
    assert outcome.code == 2
    assert outcome.err == (
        "error: no instance of this pattern can fix the platform: motions that keep P1 in place "
        "have 3 freedoms, so at most 3 of these 4 constraints are independent\n"
    )


def test_a_family_is_refused_with_what_is_missing(gsp: Run) -> None:
    outcome = gsp("new", "3D3A", "PL", "PL", "LP")
    assert outcome.code == 2
    assert "is a family of 20 types" in outcome.err


def test_files_are_replaced_as_by_all_commands(gsp: Run, tmp_path: Path) -> None:
    path = tmp_path / "x.yaml"
    assert gsp("new", "6PP", "-o", path).code == 0
    assert gsp("new", "421", "-o", path).code == 0
    assert loads(path.read_text(encoding="utf-8")).type.number == 421
    assert [file.name for file in tmp_path.iterdir()] == ["x.yaml"]


def test_a_file_that_cannot_be_written(gsp: Run, tmp_path: Path) -> None:
    outcome = gsp("new", "6PP", "-o", tmp_path / "none" / "x.yaml")
    assert outcome.code == 2
    assert outcome.err.endswith("x.yaml: cannot be written: No such file or directory\n")


@pytest.mark.parametrize("digits", ["0", "16", "x"])
def test_digits_have_a_range(gsp: Run, digits: str) -> None:
    assert gsp("new", "6PP", "--decimals", digits).code == 2


def test_a_machine_from_a_drawing_is_a_file_without_remarks(gsp: Run) -> None:
    words = ("base=80,12", "platform=55,10", "horn=24", "rod=130")
    made = gsp("new", "--rotary", *words, "--template")
    assert made.code == 0
    assert "an arm turns the point" in made.out
    assert loads(made.out).name == "Rotary hexapod"
    assert (
        gsp("new", "--rotary", *words[1:]).err.strip().startswith("error: --rotary: base missing")
    )
    assert "give either --rotary or --linear" in gsp("new", "--rotary", "--linear", *words).err
    assert "--seed: not with --linear" in gsp("new", "--linear", *words, "--seed", "3").err
