"""The same work on a Dask cluster: a real scheduler, workers killed in mid-run, nothing lost."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from gspcli import workers as module
from gspcli.catalogue.names import parse_type
from gspcli.errors import GspError
from gspcli.reality.maximize import Search, attempts
from gspcli.workers import HERE, Workers
from tools.atlas.tasks import Task, count_all, measure

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
