"""The work file survives interruptions."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import pytest

from gspcli.errors import GspError
from gspcli.journal import Journal
from gspcli.workers import Workers
from tools.atlas import tasks as module
from tools.atlas.tasks import Result, Task, TraceTest, Tracked, count_all

TASKS = [Task("DPP DPP DPP", 1, 0, seed) for seed in range(3)]


def _result(task: Task) -> Result:
    return Result(task, 10 + task.seed, 0.5)


def append(path: Path, result: Result) -> None:
    with Journal.opened(path) as journal:
        journal.append(asdict(result))


def read_journal(path: Path) -> dict[Task, Result]:
    with Journal.opened(path) as journal:
        return {result.task: result for result in journal.read(Result.of_entry)}


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
        Result(TASKS[0], 16, 0.5, Tracked(16, TraceTest(1e-14, 1e-5))),
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


@pytest.mark.parametrize(
    "content", [b'{"task": 3}\n', b"\xff\xfe\n", b"\xb9\x00", b"[" * 100_000 + b"\n", b"notes"]
)
def test_another_file_is_not_taken_for_a_work_file(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "notes.txt"
    path.write_bytes(content)
    with pytest.raises(GspError, match=r"notes\.txt:1: this is not a line of a work file"):
        read_journal(path)
    if not content.endswith(b"\n"):
        # Nor is it cut off.
        with pytest.raises(GspError, match=r"notes\.txt: this is not a work file"):
            append(path, _result(TASKS[0]))
    assert path.read_bytes() == content


def test_a_long_line_cut_off_is_dropped(tmp_path: Path) -> None:
    path = tmp_path / "work.jsonl"
    append(path, _result(TASKS[0]))
    before = path.read_bytes()
    path.write_bytes(before + b'{"' + b"x" * 200_000)
    append(path, _result(TASKS[0]))
    assert path.read_bytes() == before * 2


def test_one_process_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "work.jsonl"
    script = (
        "import sys; from pathlib import Path; from gspcli.journal import Journal\n"
        "with Journal.opened(Path(sys.argv[1])) as journal:\n"
        "    journal.append({'a': 1}); print(flush=True); sys.stdin.read()"
    )
    command = [sys.executable, "-c", script, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        other.stdout.readline()
        with pytest.raises(GspError, match=r"work\.jsonl: another process is at this work"):
            append(path, _result(TASKS[0]))
        # What holds it is a process, not a mark that a killed one leaves behind.
        other.kill()
    assert path.read_bytes() == b'{"a": 1}\n'
    append(path, _result(TASKS[0]))


def test_an_append_reads_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "work.jsonl"
    with Journal.opened(path) as journal:
        journal.append({"a": 1})
        monkeypatch.setattr(journal, "_cut_off", None)
        journal.append({"a": 2})
    assert path.read_bytes() == b'{"a": 1}\n{"a": 2}\n'


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_is_told(tmp_path: Path) -> None:
    with pytest.raises(GspError, match="/dev/full: cannot be written: No space left"):
        append(Path("/dev/full"), _result(TASKS[0]))
    with pytest.raises(GspError, match="cannot be opened: No such file"):
        append(tmp_path / "none" / "work.jsonl", _result(TASKS[0]))


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
