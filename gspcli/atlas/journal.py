"""Doing many tasks, with a work file: a line of JSON for each, so that work can be taken up."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from gspcli.atlas.tasks import Task
from gspcli.atlas.trace import Trace
from gspcli.atlas.tracked_counts import Tracked
from gspcli.errors import GspError
from gspcli.progress import Progress, silent
from gspcli.workers import HERE, Workers


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
    tracked
        More about the count if paths were tracked.
    """

    task: Task
    count: int | None
    seconds: float
    tracked: Tracked | None = None


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
            tracked = _tracked(entry.get("tracked"))
            results[task] = Result(task, entry["count"], entry["seconds"], tracked)
        except (ValueError, TypeError, KeyError) as error:
            message = f"{path}:{number}: this is not a line of a work file of the atlas"
            raise GspError(message) from error
    return results


def _tracked(entry: dict[str, Any] | None) -> Tracked | None:
    if entry is None:
        return None
    trace = entry["trace"]
    return Tracked(**{**entry, "trace": None if trace is None else Trace(**trace)})


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
    found = task.run(timeout_s)
    tracked = found if isinstance(found, Tracked) else None
    count = found.certified if isinstance(found, Tracked) else found
    return Result(task, count, round(time.monotonic() - began, 3), tracked)


def carry_out(
    tasks: Iterable[Task],
    *,
    journal: Path | None = None,
    workers: Workers = HERE,
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
    workers
        Who does them.
    timeout_s
        When to give up a task.
    progress
        Who is told.
    """
    wanted = list(tasks)
    known = read_journal(journal) if journal else {}
    results = {task: known[task] for task in wanted if task in known}
    missing = [task for task in wanted if task not in results]
    new = workers.as_completed(partial(measure, timeout_s=timeout_s), missing)
    for result in progress(new, total=len(missing), label="counting solutions"):
        results[result.task] = result
        if journal:
            append(journal, result)
    return results
