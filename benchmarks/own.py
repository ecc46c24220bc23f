"""What gsp itself needs: time in process and from the shell, memory, throughput."""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np
from numpy.typing import NDArray

from benchmarks.cases import random_instances
from benchmarks.processes import run
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.resources import data_path
from gspcli.solver import solve, solve_values
from gspcli.spec import dumps

#: What a child counts as its peak memory begins with that of its parent; only the peak of its own
#: address space, which Linux tells the process itself, is right.
_MEMORY = """
import sys
from pathlib import Path
from gspcli.cli.main import run
code = run(sys.argv[1:])
status = Path("/proc/self/status").read_text()
sys.stderr.write(status[status.index("VmHWM"):].splitlines()[0])
sys.exit(code)
"""
#: Seconds of one slice.
_SLICE = 0.25


def solve_seconds(instances: Sequence[Instance]) -> list[float]:
    """Return the processor times of solving one of some instances, after loading.

    They are solved one by one, round and round for a slice of time, once at least. A machine with
    others on it is quicker or slower for seconds at a time: slices of what is compared take turns.
    """
    times: list[float] = []
    while sum(times) < _SLICE:
        for instance in instances:
            began = time.process_time()
            solve(instance)
            times.append(time.process_time() - began)
    return times


@dataclass(frozen=True)
class Throughput:
    """Wall time for each set of values when many of one geometry are solved together."""

    type_text: str
    batch: int
    jobs: int
    seconds: float


def throughput(type_text: str, batch: int, jobs: int, seed: int) -> Throughput:
    """Solve a batch of sets of values three times, and take the median."""
    instance = next(random_instances(type_text, seed))
    values = _random_values(instance, batch, np.random.default_rng(seed))
    for _ in solve_values(instance, values[:1]):
        pass
    times = []
    for _ in range(3):
        began = time.perf_counter()
        complete = sum(
            poses.account.verdict == "complete" and poses.proof is not None
            for poses in solve_values(instance, values, jobs=jobs)
        )
        times.append(time.perf_counter() - began)
        if complete < batch:
            sys.stderr.write(f"{type_text}: {batch - complete} of {batch} are incomplete\n")
    return Throughput(type_text, batch, jobs, median(times) / batch)


def _random_values(instance: Instance, batch: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the values that random poses of the geometry have, shape (batch, 6)."""
    arrangement = Arrangement.of(instance)
    R = rotation_from_quaternion(rng.normal(size=(batch, 4)))
    values = measured(arrangement, R, rng.uniform(-1, 1, size=(batch, 3)))
    values[:, arrangement.distances] = np.abs(values[:, arrangement.distances])
    values[:, arrangement.angles] /= arrangement.in_radians
    return np.asarray(values)


@dataclass(frozen=True)
class Shell:
    """A run of `gsp solve` from the shell: medians of some runs."""

    seconds: float
    """Wall time above that of a Python interpreter that does nothing."""
    bare: float
    """Wall time of that interpreter."""
    memory: float
    """Peak memory in MB."""
    trouble: str


def shell(path: Path, repeats: int) -> Shell:
    """Solve an instance file from the shell, certified, JSON out."""
    words = ["solve", path, "--format", "json"]
    with tempfile.TemporaryDirectory() as folder:
        # As installed: Python keeps its modules compiled, even if this environment forbids it.
        kept = {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": folder}
        known = data_path("examples", "dietmaier.yaml")
        run([sys.executable, "-m", "gspcli", "solve", known, "--format", "json"], more=kept)
        bare = [
            run([sys.executable, "-c", "pass"], more=kept).seconds for _ in range(max(5, repeats))
        ]
        runs = [run([sys.executable, "-m", "gspcli", *words], more=kept) for _ in range(repeats)]
        measured = run([sys.executable, "-c", _MEMORY, *words], more=kept)
    return Shell(
        seconds=median(done.seconds for done in runs) - median(bare),
        bare=median(bare),
        memory=float(measured.errors.split()[-2]) / 1024,
        trouble=next((done.trouble for done in runs if done.trouble), ""),
    )


def write_instance(instance: Instance, path: Path) -> Path:
    """Write an instance file, and return its path."""
    path.write_text(dumps(instance), encoding="utf-8")
    return path
