"""Threads that the system refuses are done without, and the answer is the same."""

from __future__ import annotations

import os
import resource
import subprocess
import sys

import pytest

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
