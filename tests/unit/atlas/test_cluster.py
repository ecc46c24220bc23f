"""The same work on a Dask cluster: a real scheduler, workers killed in mid-run, nothing lost."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from typing import Any

import pytest

from gspcli.atlas.journal import carry_out, run_tasks
from gspcli.atlas.tasks import Task
from gspcli.errors import GspError

distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")

pytestmark = pytest.mark.filterwarnings("default")
TASKS = [Task("DPP DPP DPP DPP DPL", 1, 0, seed) for seed in range(40)]


@pytest.fixture
def cluster() -> Iterator[Any]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as running:
        yield running


def test_killed_workers_lose_nothing(cluster: Any) -> None:
    counts = {}
    for result in run_tasks(TASKS, scheduler=cluster.scheduler_address):
        counts[result.task] = result.count
        if len(counts) in (3, 12):
            worker = next(w for w in cluster.workers.values() if w.pid)
            os.kill(worker.pid, signal.SIGKILL)
    assert counts == {task: task.expected for task in TASKS}


def test_results_are_those_of_this_process(cluster: Any) -> None:
    here = carry_out(TASKS[:3])
    there = carry_out(TASKS[:3], scheduler=cluster.scheduler_address)
    assert {t: r.count for t, r in here.items()} == {t: r.count for t, r in there.items()}


def test_no_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gspcli.atlas.journal._CONNECTING_S", 1)
    with pytest.raises(GspError, match="no Dask scheduler at"):
        list(run_tasks(TASKS[:1], scheduler="tcp://127.0.0.1:1"))
