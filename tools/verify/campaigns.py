"""Long comparisons: many tasks with a work file, and the table of their results."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Self, TypeVar

from gspcli.atlas.journal import Done, carry_out
from gspcli.cli.streams import progress
from gspcli.errors import INTERRUPTED
from tools.recording import ROOT, add_workers, parser, report, save, sources_sha256, workers_of

#: What the answers come from: work files of other sources are not used.
SOURCES = ("native", "gspcli", "data/start-systems")
#: The folder of work files, unless another one is given.
WORK = ROOT / "build" / "verify"
Task = TypeVar("Task", bound=Hashable)
Result = TypeVar("Result", bound=Done)


@dataclass
class TaskRow:
    """A row of a record: the result of one task, which the first field names."""

    @property
    def task(self) -> Any:
        """The name of the task."""
        return getattr(self, fields(self)[0].name)

    @classmethod
    def of_entry(cls, entry: Mapping[str, Any]) -> Self:
        """Return the row of a line of the work file."""
        return cls(**entry)


def options(doc: str | None) -> argparse.ArgumentParser:
    """Return a parser for ``--check``, ``--sample N``, ``--work FOLDER`` and who does the work."""
    result = parser(doc, sample=True)
    add_workers(result)
    add_work(result)
    return result


def add_work(to: argparse.ArgumentParser) -> None:
    """Add the option ``--work FOLDER``."""
    to.add_argument("--work", type=Path, default=WORK, help="folder of the work files")


def results(
    tasks: Sequence[Task],
    examine: Callable[[Task], Result],
    decode: Callable[[Mapping[str, Any]], Result],
    arguments: argparse.Namespace,
    *,
    name: str,
    label: str,
    sources: Sequence[str] = SOURCES,
) -> list[Result]:
    """Return the results of tasks, in their order; what the work file has is not done again."""
    arguments.work.mkdir(parents=True, exist_ok=True)
    done = carry_out(
        tasks,
        examine,
        decode=decode,
        journal=arguments.work / f"{name}-{sources_sha256(sources)[:12]}.jsonl",
        workers=workers_of(arguments),
        progress=progress,
        label=label,
    )
    return [done[task] for task in tasks]


def conclude(record: Path, text: str, wrong: Sequence[str], summary: str, *, check: bool) -> int:
    """Write a table, or look for its lines in the record, of which it may be a part.

    Returns
    -------
    int
        The exit code: 1 if anything is wrong, or differs from the record.
    """
    differs: list[str] = []
    if check:
        lines = set(record.read_text(encoding="utf-8").splitlines())
        differs = [line for line in text.splitlines() if line not in lines]
    else:
        save({record: text}, check=False, confirmed="")
    return report([*wrong, *differs], summary)


def exit_after(main: Callable[[], int]) -> None:
    """Run a program, and exit with its code, or with that of an interruption."""
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
