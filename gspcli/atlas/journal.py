"""Doing many tasks, with a work file: a line of JSON for each, so that work can be taken up."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar

from gspcli.errors import GspError
from gspcli.progress import Progress, silent
from gspcli.records import dataclass
from gspcli.workers import HERE, Workers

Item = TypeVar("Item")


class Done(Protocol):
    """What a task gave: a dataclass, whose values JSON can write."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def task(self) -> Hashable:
        """The task."""


Result = TypeVar("Result", bound=Done)


@dataclass(frozen=True)
class Journal:
    """A work file; it need not exist yet."""

    path: Path

    def read(self, decode: Callable[[dict[str, Any]], Item]) -> list[Item]:
        """Return what its lines stand for; a last line that was cut off is ignored.

        Parameters
        ----------
        decode
            What makes an item of the values of a line, with any of ValueError, TypeError and
            KeyError if they are others.

        Raises
        ------
        GspError
            If another line is none.
        """
        if not self.path.is_file():
            return []
        items = []
        lines = self.path.read_text(encoding="utf-8").split("\n")
        # Whatever follows the last end of line was being written when the work was interrupted.
        for number, line in enumerate(lines[:-1], start=1):
            try:
                items.append(decode(json.loads(line)))
            except (ValueError, TypeError, KeyError) as error:
                message = f"{self.path}:{number}: this is not a line of a work file"
                raise GspError(message) from error
        return items

    def append(self, entry: Mapping[str, Any]) -> None:
        """Add a line."""
        if self.path.is_file():
            content = self.path.read_bytes()
            # Drop a line that was cut off when the work was interrupted.
            if content and not content.endswith(b"\n"):
                os.truncate(self.path, content.rfind(b"\n") + 1)
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(entry) + "\n")


def carry_out(
    tasks: Iterable[Hashable],
    do: Callable[[Any], Result],
    *,
    decode: Callable[[dict[str, Any]], Result],
    journal: Path | None = None,
    workers: Workers = HERE,
    progress: Progress = silent,
    label: str = "",
) -> dict[Any, Result]:
    """Return the results of tasks, those in the work file taken from there.

    Parameters
    ----------
    tasks
        What is wanted.
    do
        Gives the result of a task, with the task as its `task`.
    decode
        The inverse of `dataclasses.asdict` for results; see `Journal.read`.
    journal
        The work file, which each new result is added to at once; None keeps no record.
    workers
        Who does them.
    progress, label
        Who is told, and what it is called.
    """
    wanted = list(tasks)
    work_file = Journal(journal) if journal else None
    known = {result.task: result for result in work_file.read(decode)} if work_file else {}
    results = {task: known[task] for task in wanted if task in known}
    missing = [task for task in wanted if task not in results]
    for result in progress(workers.as_completed(do, missing), total=len(missing), label=label):
        results[result.task] = result
        if work_file:
            work_file.append(asdict(result))
    return results
