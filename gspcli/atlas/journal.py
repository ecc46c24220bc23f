"""The work file: a line of JSON for each task that is done, so that work can be taken up again."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, wait
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path

from gspcli.atlas.tasks import Task
from gspcli.errors import GspError


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
    tasks: Iterable[Task], executor: Executor, *, timeout_s: float | None = None, ahead: int = 4
) -> Iterator[Result]:
    """Yield results as they become known.

    Parameters
    ----------
    tasks
        What to do, begun in this order.
    executor
        Where: threads of this machine suffice, as the work is done by other programs.
    timeout_s
        When to give up a task.
    ahead
        How many tasks are handed to the executor at once.
    """
    waiting = iter(tasks)
    running = {executor.submit(measure, task, timeout_s) for task in islice(waiting, ahead)}
    try:
        while running:
            done, running = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()
            running |= {
                executor.submit(measure, task, timeout_s) for task in islice(waiting, len(done))
            }
    finally:
        for future in running:
            future.cancel()
