"""A scan on a Dask cluster of two processes, one of which is killed: the same bytes."""

from __future__ import annotations

import os
import signal
from functools import partial

import numpy as np
import pytest

import gspcli
from gspcli.defaults import SEED
from gspcli.motion.singularities.scans import Axis, Scan, VariedNumbers, scan_grid, scanned
from gspcli.resources import data_path
from gspcli.workers import Workers

distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")


@pytest.mark.slow
def test_a_scan_survives_a_killed_worker(gsp):
    name = data_path("examples", "platform-6-6.yaml")
    grid = ("--vary", "1=2:3:60", "--vary", "2=1.5:2.5:60")
    axes = [Axis("1", tuple(np.linspace(2, 3, 60))), Axis("2", tuple(np.linspace(1.5, 2.5, 60)))]
    instance = gspcli.load(name)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0"
    ) as cluster:
        there = Workers(scheduler=cluster.scheduler_address)
        found = Scan.of(VariedNumbers(instance, axes))
        victim = next(worker.pid for worker in cluster.workers.values())
        results = there.as_completed(partial(scanned, found, SEED), range(found.pieces))
        for number, piece in enumerate(results):
            if number == 0:
                os.kill(victim, signal.SIGKILL)
            found.enter(piece)
        here = scan_grid(VariedNumbers(instance, axes))
        assert found.pieces == 4
        for name in ("modes", "condition"):
            assert np.array_equal(found.numbers[name], here.numbers[name])
        printed = [
            gsp("scan", name, *grid, *who, "--format", "csv")
            for who in (("--jobs", "1"), ("--scheduler", there.scheduler))
        ]
    assert printed[0].code == 0
    assert printed[0] == printed[1]
