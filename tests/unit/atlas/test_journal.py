"""The work file survives interruptions."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import pytest

from gspcli.atlas import counting as module
from gspcli.atlas.counting import Result, count_all
from gspcli.atlas.journal import Journal
from gspcli.atlas.tasks import Task
from gspcli.atlas.trace import Trace
from gspcli.atlas.tracked_counts import Tracked
from gspcli.errors import GspError
from gspcli.workers import Workers

TASKS = [Task("DPP DPP DPP", 1, 0, seed) for seed in range(3)]


def _result(task: Task) -> Result:
    return Result(task, 10 + task.seed, 0.5)


def append(path: Path, result: Result) -> None:
    Journal(path).append(asdict(result))


def read_journal(path: Path) -> dict[Task, Result]:
    return {result.task: result for result in Journal(path).read(Result.of_entry)}


def test_results_come_back(tmp_path: Path) -> None:
    path = tmp_path / "work.jsonl"
    assert read_journal(path) == {}
    for task in TASKS:
        append(path, _result(task))
    append(path, Result(TASKS[0], None, 1.0))
    assert read_journal(path) == {
        **{task: _result(task) for task in TASKS},
        TASKS[0]: Result(TASKS[0], None, 1.0),
    }


def test_what_tracking_gave_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "work.jsonl"
    results = [
        Result(TASKS[0], 16, 0.5, Tracked(16, Trace(1e-14, 1e-5))),
        Result(TASKS[1], 16, 0.5, Tracked(16, None)),
    ]
    for result in results:
        append(path, result)
    assert list(read_journal(path).values()) == results


def test_a_line_cut_off_is_dropped(tmp_path: Path) -> None:
    path = tmp_path / "work.jsonl"
    append(path, _result(TASKS[0]))
    append(path, _result(TASKS[1]))
    path.write_bytes(path.read_bytes()[:-7])
    assert set(read_journal(path)) == {TASKS[0]}
    append(path, _result(TASKS[2]))
    assert set(read_journal(path)) == {TASKS[0], TASKS[2]}


def test_another_file_is_not_taken_for_a_work_file(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text('{"task": 3}\n')
    with pytest.raises(GspError, match=r"notes\.txt:1: this is not a line of a work file"):
        read_journal(path)


def test_done_work_is_not_done_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "work.jsonl"
    done = []

    def measure(task: Task, timeout_s: float | None = None) -> Result:
        done.append(task)
        if len(done) == 3:
            raise KeyboardInterrupt
        return _result(task)

    monkeypatch.setattr(module, "measure", measure)
    with pytest.raises(KeyboardInterrupt):
        count_all(TASKS, journal=path)
    assert count_all(TASKS, journal=path) == {task: _result(task) for task in TASKS}
    assert done == [*TASKS, TASKS[2]]


def test_processes_give_the_same(tmp_path: Path) -> None:
    one = count_all(TASKS)
    two = count_all(TASKS, workers=Workers(2), journal=tmp_path / "work.jsonl")
    assert {t: r.count for t, r in one.items()} == {t: r.count for t, r in two.items()}
    assert set(read_journal(tmp_path / "work.jsonl")) == set(TASKS)
