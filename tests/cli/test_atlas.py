"""`gsp atlas`: summary, verification, building."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from gspcli.atlas import records
from gspcli.atlas.tasks import Task
from gspcli.defaults import SEED

Run = Callable[..., object]
DOCS = Path(__file__).resolve().parents[2] / "docs"
VERIFY = ("atlas", "verify", "--fast", "--method", "tracking", "--jobs", "1")


@pytest.fixture
def small_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gspcli.cli.commands.atlas._FAST", (8, 64))


def test_summary_by_class_and_against_the_bounds(gsp: Run) -> None:
    outcome = gsp("atlas", "summary", "--format", "json")
    assert (outcome.code, outcome.err) == (0, "")
    document = json.loads(outcome.out)
    assert document["schema"] == "gsp.atlas-summary/1"
    counts, bounds = document["counts"], document["bounds"]
    everything = {row["sides"]: row for row in counts if row["name"] == "all"}
    assert [row["types"] for row in counts[:8:2]] == [1120, 1260, 1008, 462]
    assert everything["one-sided"]["largest"] == max(row["largest"] for row in counts)
    by_bound = {(row["bound"], row["name"]): row for row in bounds}
    assert by_bound["table_3", "3D3A"]["sharp"] == 1120
    assert by_bound["theorem_5_4", "all"]["types"] == 35
    assert by_bound["theorem_5_4", "all"]["sharp"] == 0
    assert all(row["largest"] >= row["median"] >= 1 for row in bounds)


def test_the_page_of_counts_shows_the_summary(gsp: Run) -> None:
    page = (DOCS / "counts.md").read_text(encoding="utf-8")
    assert gsp("atlas", "summary", "--format", "markdown").out in page


@pytest.mark.usefixtures("small_samples")
def test_verify_a_sample(gsp: Run, tmp_path: Path) -> None:
    work = tmp_path / "work.jsonl"
    outcome = gsp(*VERIFY, "--resume", str(work), "--format", "json")
    assert (outcome.code, outcome.err) == (0, "")
    (row,) = json.loads(outcome.out)["methods"]
    assert (row["different"], row["unfinished"]) == (0, 0)
    assert row["equal"] == row["counts"] == len(work.read_text().splitlines())
    # Continued, there is nothing to do.
    again = gsp(*VERIFY, "--resume", str(work), "--format", "json")
    assert again.out == outcome.out
    assert len(work.read_text().splitlines()) == row["counts"]


@pytest.mark.usefixtures("small_samples")
def test_verify_finds_a_wrong_record(gsp: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    true = records.recorded
    monkeypatch.setattr(records, "recorded", lambda task: true(task) - 1)
    outcome = gsp(*VERIFY)
    assert outcome.code == 1
    assert "Different from the record" in outcome.out
    assert "counts differ from the record" in outcome.err
    # Fewer certified poses than recorded contradict nothing, but are not enough.
    monkeypatch.setattr(records, "recorded", lambda task: true(task) + 1)
    outcome = gsp(*VERIFY)
    assert outcome.code == 4
    assert "too few poses were certified" in outcome.err


def test_build_and_check(gsp: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tasks = [Task("DPP DPP DPL", 1, 0, SEED), Task("DPH DPH DPH DPH", 2, 0, SEED)]
    monkeypatch.setattr("gspcli.atlas.tasks.all_tasks", lambda: tasks)
    folder, work = tmp_path / "counts", tmp_path / "work.jsonl"
    build = ("atlas", "build", "--folder", str(folder), "--resume", str(work), "--jobs", "1")
    assert gsp(*build).code == 0
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert set(before) == {"families.csv", "intersection-numbers.csv", "manifest.json"}
    assert gsp(*build, "--check").code == 0
    assert gsp(*build).code == 0
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    (folder / "families.csv").write_text("")
    outcome = gsp(*build, "--check")
    assert outcome.code == 1
    assert "what was built differs: families.csv" in outcome.err


def test_build_needs_a_place(gsp: Run) -> None:
    outcome = gsp("atlas", "build")
    assert outcome.code == 2
    assert "--folder" in outcome.err
