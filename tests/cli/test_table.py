"""`gsp table`: ours beside theirs, and an exit code for CI."""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest

from gspcli.paper import tables

Run = Callable[..., object]


def test_all_tables_check(gsp: Run) -> None:
    outcome = gsp("table", "all", "--check", "--format", "json")
    assert outcome.code == 0
    document = json.loads(outcome.out)
    assert [len(table["computed"]) for table in document["tables"]] == [8, 8, 56]
    assert [len(table["differences"]) for table in document["tables"]] == [1, 16, 2]
    assert all(erratum["evidence"] for erratum in document["errata"])
    assert "56 families" in document["table_3_confirmed"]


def test_table_2_in_exact_radicals(gsp: Run) -> None:
    first = gsp("table", "2").out.splitlines()[4].split()
    assert first == ["1", "3√6/2", "*", "3√10/2", "*", "√10/2"]


def test_tables_for_a_paper(gsp: Run) -> None:
    shown = gsp("table", "3", "--format", "latex").out
    assert r"\begin{tabular}{rlrl}" in shown
    assert "64 & CCC & 4 & PL PL PL, PL PL LP, PL LP LP, LP LP LP *" in shown


def test_errata_alone(gsp: Run) -> None:
    shown = gsp("table", "errata", "--format", "csv").out.splitlines()
    assert shown[0] == "key,sort,place,printed,correct"
    assert any(line.startswith("theorem-5-4,") for line in shown)


def test_a_difference_without_an_erratum_exits_with_1(
    gsp: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = tables.printed_table(2)
    rows[4]["z"] = "7"
    monkeypatch.setattr(tables, "table_2", lambda: rows)
    monkeypatch.setattr("gspcli.paper.errata.prove", lambda erratum: erratum.key)
    outcome = gsp("table", "2", "--check")
    assert outcome.code == 1
    assert "Table 2, solution 5, z: printed" in outcome.err


def test_an_unknown_table_exits_with_2(gsp: Run) -> None:
    outcome = gsp("table", "4")
    assert (outcome.code, outcome.out) == (2, "")
