"""Counting solutions for the atlas: the results of its tasks, with a work file."""

from __future__ import annotations

import time
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any

from gspcli.atlas.journal import carry_out
from gspcli.atlas.tasks import Task
from gspcli.atlas.trace import TraceTest
from gspcli.atlas.tracked_counts import Tracked
from gspcli.progress import Progress, silent
from gspcli.records import dataclass
from gspcli.workers import HERE, Workers


@dataclass(frozen=True)
class Result:
    """The result of a task.

    Attributes
    ----------
    task
        The task.
    count
        The number of solutions; None after the time limit.
    seconds
        The time.
    tracked
        The details of the count if paths were tracked.
    """

    task: Task
    count: int | None
    seconds: float
    tracked: Tracked | None = None

    @classmethod
    def of_entry(cls, entry: dict[str, Any]) -> Result:
        """Return the result in a line of a work file."""
        tracked = entry.get("tracked")
        if tracked is not None:
            trace = tracked["trace"]
            tracked = Tracked(**{**tracked, "trace": None if trace is None else TraceTest(**trace)})
        return cls(Task(**entry["task"]), entry["count"], entry["seconds"], tracked)


def measure(task: Task, timeout_s: float | None = None) -> Result:
    """Run a task."""
    began = time.monotonic()
    found = task.run(timeout_s)
    tracked = found if isinstance(found, Tracked) else None
    count = found.certified if isinstance(found, Tracked) else found
    return Result(task, count, round(time.monotonic() - began, 3), tracked)


def count_all(
    tasks: Iterable[Task],
    *,
    journal: Path | None = None,
    workers: Workers = HERE,
    timeout_s: float | None = None,
    progress: Progress = silent,
) -> dict[Task, Result]:
    """Return the results of tasks, see `carry_out`; a task ends after the time limit."""
    return carry_out(
        tasks,
        partial(measure, timeout_s=timeout_s),
        decode=Result.of_entry,
        journal=journal,
        workers=workers,
        progress=progress,
        label="counting solutions",
    )
