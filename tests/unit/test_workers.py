"""Work in several processes: all of it is done, none is left behind, and errors are reported."""

from __future__ import annotations

import time
from functools import partial
from itertools import count, islice
from multiprocessing import active_children
from pathlib import Path
from signal import SIGKILL, raise_signal
from subprocess import getoutput

import pytest

from gspcli.errors import GspError
from gspcli.workers import HERE, Workers

TWO = Workers(2)


@pytest.mark.parametrize("workers", [HERE, TWO])
def test_all_work_is_done(workers: Workers) -> None:
    squares = [k * k for k in range(20)]
    assert list(workers.in_order(partial(pow, exp=2), range(20))) == squares
    assert sorted(workers.as_completed(partial(pow, exp=2), range(20))) == squares
    assert list(workers.in_order(abs, [])) == []


def test_results_come_as_they_are_known_or_in_order(tmp_path: Path) -> None:
    last = tmp_path / "last"
    # However late a process begins, the first piece of work ends after the others.
    slow = f"until [ -e {last} ]; do sleep 0.01; done; sleep 0.3; echo slow"
    slow_first = [slow, "echo quick", f"touch {last}; echo last"]
    assert list(TWO.as_completed(getoutput, slow_first))[-1] == "slow"
    last.unlink()
    assert list(TWO.in_order(getoutput, slow_first)) == ["slow", "quick", "last"]


@pytest.mark.parametrize("workers", [HERE, TWO])
def test_items_may_be_endless(workers: Workers) -> None:
    taken = []
    items = (taken.append(k) or k for k in count())
    assert list(islice(workers.in_order(abs, items), 5)) == [0, 1, 2, 3, 4]
    assert len(taken) <= 5 + 2 * workers.jobs + workers.jobs


@pytest.mark.parametrize("workers", [HERE, TWO])
def test_errors_of_the_work_are_raised(workers: Workers) -> None:
    with pytest.raises(ValueError, match="invalid literal"):
        list(workers.in_order(int, ["1", "2", "three", "4"]))


def test_one_piece_of_work_needs_no_processes() -> None:
    # What is done here need not be picklable.
    assert list(TWO.in_order(lambda k: k + 1, [1])) == [2]


def test_a_killed_process_is_reported() -> None:
    with pytest.raises(
        GspError, match="a process was killed, perhaps because memory was exhausted"
    ):
        list(TWO.as_completed(raise_signal, [SIGKILL, SIGKILL]))


def test_nothing_goes_on_when_no_more_is_wanted(tmp_path: Path) -> None:
    number = tmp_path / "number"
    before = set(active_children())
    items = [f"echo $$ > {number}; exec sleep 100", "sleep 0.2; echo done"]
    results = TWO.as_completed(getoutput, items)
    assert next(results) == "done"
    while not (number.is_file() and number.read_text().strip()):
        time.sleep(0.01)
    process = Path("/proc") / number.read_text().strip()
    results.close()  # type: ignore[attr-defined]
    deadline = time.monotonic() + 30
    while set(active_children()) - before or _runs(process):
        assert time.monotonic() < deadline, "a process goes on"
        time.sleep(0.02)


def _runs(process: Path) -> bool:
    try:
        state = (process / "stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"
