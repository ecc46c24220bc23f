"""Doing many tasks, with a work file: a line of JSON for each, so that work can be taken up."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, ProcessPoolExecutor, wait
from dataclasses import asdict, dataclass
from importlib import import_module
from itertools import islice
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from gspcli.atlas.tasks import Task
from gspcli.errors import GspError
from gspcli.progress import Progress, silent

#: How long to wait for a Dask scheduler to answer.
_CONNECTING_S = 10


@dataclass(frozen=True)
class Result:
    """What a task gave.

    Attributes
    ----------
    task
        The task.
    count
        The number of solutions; None if the time did not suffice.
    seconds
        How long it took.
    """

    task: Task
    count: int | None
    seconds: float


def read_journal(path: Path) -> dict[Task, Result]:
    """Return the results in a work file; a last line that was cut off is ignored.

    Raises
    ------
    GspError
        If another line is not a result.
    """
    if not path.is_file():
        return {}
    results = {}
    lines = path.read_text(encoding="utf-8").split("\n")
    # Whatever follows the last end of line was being written when the work was interrupted.
    for number, line in enumerate(lines[:-1], start=1):
        try:
            entry = json.loads(line)
            task = Task(**entry["task"])
            results[task] = Result(task, entry["count"], entry["seconds"])
        except (ValueError, TypeError, KeyError) as error:
            message = f"{path}:{number}: this is not a line of a work file of the atlas"
            raise GspError(message) from error
    return results


def append(path: Path, result: Result) -> None:
    """Add a result to a work file."""
    if path.is_file():
        content = path.read_bytes()
        # Drop a line that was cut off when the work was interrupted.
        if content and not content.endswith(b"\n"):
            os.truncate(path, content.rfind(b"\n") + 1)
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(asdict(result)) + "\n")


def measure(task: Task, timeout_s: float | None = None) -> Result:
    """Run a task."""
    began = time.monotonic()
    count = task.run(timeout_s)
    return Result(task, count, round(time.monotonic() - began, 3))


def run_tasks(
    tasks: Sequence[Task],
    *,
    jobs: int = 1,
    scheduler: str | None = None,
    timeout_s: float | None = None,
) -> Iterator[Result]:
    """Yield the results of tasks as they become known.

    Parameters
    ----------
    tasks
        What to do, begun in this order.
    jobs
        How many processes work at once; 1 works in this one.
    scheduler
        Address of a Dask scheduler whose workers do it instead. What a lost worker was doing
        is done by another one.
    timeout_s
        When to give up a task.

    Raises
    ------
    GspError
        If there is no such scheduler, or a worker has several threads.
    """
    if scheduler is not None:
        with _client(scheduler) as client:
            ahead = 2 * max(1, len(client.nthreads()))
            yield from _run_on(client.get_executor(pure=False), tasks, ahead, timeout_s)
        return
    if jobs == 1:
        yield from (measure(task, timeout_s) for task in tasks)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as executor:
        yield from _run_on(executor, tasks, 2 * jobs, timeout_s)


def _client(address: str) -> Any:
    """Return a connection to a Dask scheduler."""
    try:
        distributed = import_module("distributed")
    except ModuleNotFoundError as error:
        message = "--scheduler needs Dask: pip install 'gspcli[cluster]'"
        raise GspError(message) from error
    try:
        client = distributed.Client(address, timeout=_CONNECTING_S)
    except (OSError, TimeoutError, ValueError) as error:
        message = f"no Dask scheduler at {address!r}: start one by `dask scheduler`"
        raise GspError(message) from error
    # The precision of ball arithmetic is a setting of the whole process.
    if any(threads > 1 for threads in client.nthreads().values()):
        client.close()
        message = f"a worker of {address} has several threads: start it with --nthreads 1"
        raise GspError(message)
    return client


def _run_on(
    executor: Executor, tasks: Iterable[Task], ahead: int, timeout_s: float | None
) -> Iterator[Result]:
    """Keep an executor busy, with a number of tasks handed over ahead."""
    waiting = iter(tasks)
    running = {executor.submit(measure, task, timeout_s) for task in islice(waiting, ahead)}
    try:
        while running:
            done, running = wait(running, return_when=FIRST_COMPLETED)
            running |= {
                executor.submit(measure, task, timeout_s) for task in islice(waiting, len(done))
            }
            for future in done:
                yield future.result()
    finally:
        for future in running:
            future.cancel()


def carry_out(
    tasks: Iterable[Task],
    *,
    journal: Path | None = None,
    jobs: int = 1,
    scheduler: str | None = None,
    timeout_s: float | None = None,
    progress: Progress = silent,
) -> dict[Task, Result]:
    """Return the results of tasks, those in the work file taken from there.

    Parameters
    ----------
    tasks
        What is wanted.
    journal
        The work file, which each new result is added to at once; None keeps no record.
    jobs, scheduler, timeout_s
        As for `run_tasks`.
    progress
        Who is told.
    """
    wanted = list(tasks)
    known = read_journal(journal) if journal else {}
    results = {task: known[task] for task in wanted if task in known}
    missing = [task for task in wanted if task not in results]
    new = run_tasks(missing, jobs=jobs, scheduler=scheduler, timeout_s=timeout_s)
    for result in progress(new, total=len(missing), label="counting solutions"):
        results[result.task] = result
        if journal:
            append(journal, result)
    return results
