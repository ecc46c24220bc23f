"""`gsp realize`."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "data" / "examples" / "example-6.8.yaml"


def test_a_type(gsp: Callable) -> None:
    outcome = gsp("realize", "DPL", "DPP", "DHP", "ALL", "ALH", "AHH", "--format", "csv")
    assert (outcome.code, outcome.err) == (0, "")
    rows = list(csv.DictReader(io.StringIO(outcome.out)))
    assert [(row["kinds"], row["chain"]) for row in rows] == [
        ("DPP", "platform ─S─P*─S─ base"),
        ("DPL", "platform ─S─P*─C─ base"),
        ("DHP", "platform ─E─P*─S─ base"),
        ("ALL", "platform ─C─P─R*─C─ base"),
        ("ALH", "platform ─C─R*─E─ base"),
        ("AHH", "platform ─E─R*─E─ base"),
    ]
    assert [row["idle_freedoms"] for row in rows] == ["1", "0", "1", "0", "0", "1"]
    assert {row["held_freedoms"] for row in rows} == {"5"}


def test_the_sum_is_shown(gsp: Callable) -> None:
    outcome = gsp("realize", "6PP")
    assert outcome.out.startswith("DPP DPP DPP DPP DPP DPP (3389)\n")
    assert "6 (14 - 18 - 1) + 42 = 12; 12 - 6 idle = 6" in outcome.out


def test_markdown(gsp: Callable) -> None:
    lines = gsp("realize", "6PP", "--format", "markdown").out.splitlines()
    assert lines[4] == (
        "| 1 | DPP | P1 | p1 | platform ─S─P*─S─ base | 1 | 7 | 1 | leg turns about its own axis "
        "| S-P*-R-R | S-S-P* | 5 | 9 |"
    )


def test_json_of_the_platform_of_figure_14(gsp: Callable) -> None:
    outcome = gsp("realize", "L1-l3 L1^l3 L2-l4 L2^l4 L1^l4 L2-l3", "--format", "json")
    document = json.loads(outcome.out)
    assert document["schema"] == "gsp.realize/1"
    assert document["type"]["id"] == "DLL DLL DLL ALL ALL ALL"
    chains = [chain["chain"] for chain in document["chains"]]
    assert sorted(chains) == ["C-P-R*-C", "C-R*-P*-C", "C-R*-P*-C", "C-R-P*-C"]
    assert document["mobility"]["moving_freedoms"] == document["mobility"]["driven"] == 6
    assert document["over_constraint"] is None
    assert all(shared["joints"] == "2 C on one shaft" for shared in document["shared"])
    assert set(document["chains"][0]) == {
        "constraints",
        "kinds",
        "platform",
        "base",
        "chain",
        "description",
        "figure",
        "joint_freedoms",
        "idle_freedoms",
        "idle_motion",
        "freedoms",
        "held_freedoms",
        "alternative",
        "outside",
    }


def test_an_instance_file(gsp: Callable) -> None:
    outcome = gsp("realize", EXAMPLE)
    assert outcome.code == 0
    assert outcome.out.startswith("Example 6.8: DPL DPL DPL ALL ALL ALL\n")
    assert "P1: compound spherical joint: 3 S with one centre (chains 4 5 6)" in outcome.out
    assert "L4: 2 C on one shaft (chains 1 4)" in outcome.out


def test_a_platform_that_is_never_fixed_is_called_so(gsp: Callable) -> None:
    outcome = gsp("realize", "P1-p1 P1-p2 P1-p3 P2-p4 P3-p4 P4-p4")
    assert outcome.code == 0
    assert "the platform is never fixed: motions that keep P1 and p4 in place" in outcome.out


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("3D3A", "PP", "PP"), "2 constraints given"),
        (("3D3A", "PP", "PP", "PP"), "is a family of 20 types"),
        (("P1-p1 P1-",), "'P1-' is no constraint between named primitives"),
        (("no-such-file.yaml",), "no-such-file.yaml: cannot be read"),
    ],
)
def test_what_is_wrong_is_said(gsp: Callable, arguments: tuple[str, ...], expected: str) -> None:
    outcome = gsp("realize", *arguments)
    assert (outcome.code, outcome.out) == (2, "")
    assert expected in outcome.err
    assert len(outcome.err.splitlines()) <= 3


def test_output_file(gsp: Callable, tmp_path: Path) -> None:
    target = tmp_path / "six.json"
    assert gsp("realize", "6PP", "-o", target).out == ""
    assert len(json.loads(target.read_text())["chains"]) == 6


def test_outside_drivers(gsp: Callable) -> None:
    outcome = gsp("realize", "6PL", "--realization", "outside", "--format", "json")
    (first, *_) = json.loads(outcome.out)["chains"]
    assert (first["chain"], first["figure"], first["held_freedoms"]) == ("S-C-P*", 8, 5)


@pytest.mark.parametrize("names", [("6PP",), (EXAMPLE,)], ids=["type", "instance"])
def test_drawings(gsp: Callable, tmp_path: Path, names: tuple[str, ...]) -> None:
    target = tmp_path / "drawing.svg"
    outcome = gsp("realize", *names, "-o", target)
    assert (outcome.code, outcome.out, outcome.err) == (0, "", "")
    assert "<svg" in target.read_text(encoding="utf-8")


def test_without_a_real_pose_there_is_nothing_to_draw(gsp: Callable, tmp_path: Path) -> None:
    outcome = gsp("realize", "@no-real-pose", "-o", tmp_path / "drawing.svg")
    assert outcome.code == 2
    assert "no real pose to draw the mechanism at" in outcome.err


def test_chains_of_single_kinds_are_drawn(gsp, tmp_path):
    target = tmp_path / "chains.svg"
    assert gsp("realize", "PP", "LL", "-o", target).code == 0
    text = target.read_text(encoding="utf-8")
    assert all(f"<!-- {name} -->" in text for name in ("DPP", "DLL", "ALL"))
    outcome = gsp("realize", "PP", "XX", "-o", target)
    assert (outcome.code, target.read_text(encoding="utf-8")) == (2, text)


def test_cranks_and_slides_of_a_file_are_in_no_chain(gsp):
    run = gsp("realize", "@t-top-head")
    note = "chains 1 2 3 4 5 6: SPEC drives a joint by a crank or slide; here the constraint is"
    assert note in " ".join(run.out.split())
    assert "crank or slide" not in gsp("realize", "@rubin-m2").out
