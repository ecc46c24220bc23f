"""`gsp bound`: the numbers, their reasons, what it accepts."""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest

Run = Callable[..., object]


def _document(gsp: Run, *names: str) -> dict:
    return json.loads(gsp("bound", *names, "--format", "json").out)


def test_the_family_of_the_readme(gsp: Run) -> None:
    document = _document(gsp, "3D3A", "PL", "PL", "LP")
    assert document["schema"] == "gsp.bound/1"
    assert document["type"] == {
        "id": None,
        "number": None,
        "class": "3D3A",
        "family": "3D3A PL PL LP",
    }
    assert document["bounds"]["theorem_5_3"] == 320
    assert document["bounds"]["table_3"] == 64
    assert [row["kind"] for row in document["constraints"]] == ["DPL", "DPL", "DLP"]
    assert [row["degree_mourrain"] for row in document["constraints"]] == [2, 2, 4]
    assert "20 · 2^2 · 4^1 = 320" in document["reasons"]["theorem_5_3"]


def test_the_stewart_platform(gsp: Run) -> None:
    document = _document(gsp, "6PP")
    assert document["type"]["number"] == 3389
    assert document["bounds"] == {
        "theorem_5_2": 40,
        "theorem_5_3": 40,
        "theorem_5_4": None,
        "table_3": None,
        "refined_one_sided": 40,
        "refined_two_sided": 40,
    }
    assert all(row["degree_lazard"] == 2 for row in document["constraints"])
    assert all(row["degree_mourrain"] == 1 for row in document["constraints"])


def test_the_example_after_theorem_5_2(gsp: Run) -> None:
    # Page 72: five DPP and one DPL have at most 40 · 2 = 80 solutions.
    bounds = _document(gsp, "5PP", "PL")["bounds"]
    assert bounds["theorem_5_2"] == bounds["theorem_5_3"] == 80


def test_the_platform_of_figure_3(gsp: Run) -> None:
    # Page 73: six DPH: at most 20 · 2^6 = 1280 solutions, 20 of them feasible.
    bounds = _document(gsp, "6PH")["bounds"]
    assert bounds["theorem_5_3"] == 1280
    assert bounds["theorem_5_4"] == 20
    assert bounds["refined_one_sided"] == 8


def test_several_subjects(gsp: Run) -> None:
    documents = json.loads(gsp("bound", "17", "3D3A PL PL LP", "6PP", "--format", "json").out)
    assert [document["type"]["number"] for document in documents] == [17, None, 3389]
    summary = gsp("bound", "17", "6PP", "--format", "csv").out.splitlines()
    assert summary[0].startswith("number,id,class,family,theorem_5_2")
    assert len(summary) == 3


def test_a_file_is_bounded_by_its_type(gsp: Run) -> None:
    document = _document(gsp, "data/examples/example-6.8.yaml")
    assert document["type"]["class"] == "3D3A"
    assert document["bounds"]["table_3"] == 64


@pytest.mark.parametrize("words", [["PP", "PQ"], ["99999"], ["missing.yaml"], []])
def test_mistakes_exit_with_2(gsp: Run, words: list[str]) -> None:
    outcome = gsp("bound", *words)
    assert outcome.code == 2
    assert outcome.out == ""
    assert outcome.err


def test_table_3_says_that_it_counts_one_orientation_of_each_dll(gsp: Run) -> None:
    lines = gsp("bound", "3D3A", "LL", "LL", "LL").out.splitlines()
    (row,) = (line for line in lines if line.startswith("bound") and "Table 3" in line)
    assert row.split(maxsplit=3)[2:] == ["3", "8  one-sided, one orientation of each DLL"]
    (reason,) = (line for line in lines if line.startswith("Table 3: "))
    assert reason.endswith("for one orientation of each DLL, one of its two planes; for both 64")
    # What it says holds: the generic count is of both.
    assert any(line.startswith("generic count") and " 64 " in line for line in lines)
    assert "orientation of each" not in gsp("bound", "3D3A", "PH", "PH", "PL").out
