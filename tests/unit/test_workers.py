"""Work in threads, processes and clusters."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from itertools import count, islice
from multiprocessing import active_children
from pathlib import Path
from signal import SIGKILL, raise_signal
from subprocess import getoutput
from typing import Any

import pytest

from gspcli import workers as module
from gspcli.catalogue.names import parse_type
from gspcli.errors import GspError
from gspcli.reality.real_search import Search, attempts
from gspcli.workers import HERE, Workers
from tools.atlas.tasks import Task, count_all, measure

# Work in several processes: all of it is done, none is left behind, and errors are reported.


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
    assert list(islice(workers.in_order(abs, count()), 5)) == [0, 1, 2, 3, 4]
    # In their order, a late item lets any number of others pass.
    found = list(islice(workers.as_completed(abs, items), 5))
    assert set(found) <= set(taken)
    assert len(taken) <= 5 + 2 * workers.jobs


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


# Threads that the system refuses are done without, and the answer is the same.


PROGRAM = """
import numpy as np, gspcli
from gspcli.resources import data_path
instance = gspcli.load(data_path("examples", "dietmaier.yaml"))
values = [[c.value.value for c in instance.constraints]] * 3
one, many = (gspcli.solve(instance, jobs=jobs) for jobs in (1, 16))
assert np.array_equal(one.R, many.R) and one.verdict == many.verdict == "complete"
batch = gspcli.solve_values(instance, values, jobs=16)
assert [len(result.R) for result in batch] == [40, 40, 40]
track = gspcli.track(instance, values, jobs=16)
assert len(track.modes) == 40 and not track.events
print(len(many.R))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="stacks of threads are sized as on Linux")
@pytest.mark.parametrize("refused", [False, True])
def test_without_threads(refused: bool) -> None:
    def limit() -> None:
        # No thread can be had: its stack would be larger than the address space.
        _, most = resource.getrlimit(resource.RLIMIT_STACK)
        resource.setrlimit(resource.RLIMIT_STACK, (1 << 48, most))

    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        preexec_fn=limit if refused else None,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "40\n", "")


# The same work on a Dask cluster: a real scheduler, workers killed in mid-run, nothing lost.


distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")

#: A scheduler with a worker in its process, until it is killed.
_SCHEDULER = """
import sys
import distributed
with distributed.LocalCluster(1, threads_per_worker=1, processes=False, dashboard_address=None,
                              protocol="tcp") as cluster:
    print(cluster.scheduler_address, flush=True)
    sys.stdin.read()
"""
TASKS = [Task("DPP DPP DPP DPP DPL", 1, 0, seed) for seed in range(40)]


def _cluster(workers: int, **settings: Any) -> Any:
    return distributed.LocalCluster(n_workers=workers, dashboard_address=":0", **settings)


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with _cluster(2, threads_per_worker=1, processes=True) as running:
        yield running


@pytest.fixture
def there(cluster: Any) -> Workers:
    return Workers(scheduler=cluster.scheduler_address)


def test_killed_workers_lose_nothing(cluster: Any, there: Workers) -> None:
    counts = {}
    killed = []
    for result in there.as_completed(measure, TASKS):
        counts[result.task] = result.count
        if len(counts) in (3, 12):
            worker = next(w for w in cluster.workers.values() if w.pid)
            os.kill(worker.pid, signal.SIGKILL)
            killed.append(worker.pid)
    assert len(set(killed)) == 2
    assert counts == {task: task.expected for task in TASKS}


def test_results_are_those_of_this_process(there: Workers) -> None:
    here = count_all(TASKS[:3])
    cluster = count_all(TASKS[:3], workers=there)
    assert {t: r.count for t, r in here.items()} == {t: r.count for t, r in cluster.items()}


def test_order_is_kept(there: Workers) -> None:
    assert list(there.in_order(abs, range(-30, 0))) == list(range(30, 0, -1))


def test_a_search_makes_the_same_attempts(there: Workers) -> None:
    search = Search(parse_type("6PP").kinds, starts=2, steps=3)

    def made(workers: Workers) -> list[tuple[int, int, bytes]]:
        return [
            (number, found.count, found.platform.values.tobytes())
            for number, found in attempts(search, 1, 4, workers)
            if found is not None
        ]

    here = made(HERE)
    assert [number for number, *_ in here] == [1, 2, 3]
    assert here == made(Workers(2)) == made(there)


def test_commands_print_the_same(gsp: Callable, there: Workers) -> None:
    commands = [
        ("sample", "6PH", "--one-sided", "--count", "2100"),
        ("maximize-real", "3D3A PP PP PP ALL ALL ALL", "--attempts", "2"),
        ("scan", "@octahedral-3-3", "--vary", "1=1:2:5"),
    ]
    for command in commands:
        here = gsp(*command, "--jobs", "1")
        assert here.code == 0
        assert gsp(*command, "--scheduler", there.scheduler) == here
    assert gsp(*commands[0], "--jobs", "2", "--scheduler", there.scheduler).code == 2


def test_no_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_CONNECTING_S", 0.5)
    with pytest.raises(GspError, match="no Dask scheduler at"):
        list(Workers(scheduler="tcp://127.0.0.1:1").in_order(abs, [1]))


@pytest.mark.parametrize(
    ("workers", "settings", "message"),
    [(0, {}, "has no workers"), (1, {"threads_per_worker": 2}, "has several threads")],
)
def test_unsuitable_workers(
    workers: int, settings: dict[str, int], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with _cluster(workers, processes=False, **settings) as running:
        monkeypatch.setattr(module, "_CONNECTING_S", 0.5)
        with pytest.raises(GspError, match=message):
            list(Workers(scheduler=running.scheduler_address).in_order(abs, [1]))


def test_a_scheduler_that_dies_is_told_in_one_line(capfd: pytest.CaptureFixture[str]) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", _SCHEDULER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        results = Workers(scheduler=address).as_completed(time.sleep, [0.0, *[0.2] * 50])
        assert next(results) is None
        process.kill()
        with pytest.raises(GspError, match=f"the connection to .* {address} was lost"):
            list(results)
    # The library has its own account of it.
    assert "Traceback" not in capfd.readouterr().err
