"""A file of `data/witnesses/` with its manifest: written, and its platforms certified again."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from gspcli.cli.streams import progress
from gspcli.workers import Workers
from tools.recording import ROOT, report, sampled, sha256, versions

FOLDER = ROOT / "data" / "witnesses"
Item = TypeVar("Item")


@dataclass(frozen=True)
class Record:
    """A table of platforms, and what says how it was made.

    Attributes
    ----------
    file, manifest
        Where they are.
    columns
        The heading of the table.
    """

    file: Path
    manifest: Path
    columns: tuple[str, ...]

    def write(self, rows: Iterable[Sequence[object]], facts: dict[str, Any]) -> None:
        """Write the rows, and the manifest with some facts about them."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows(rows)
        made_with = {
            "versions": versions("numpy", "python-flint"),
            "sha256": {self.file.name: sha256(text.getvalue())},
        }
        FOLDER.mkdir(parents=True, exist_ok=True)
        self.file.write_text(text.getvalue(), encoding="utf-8")
        self.manifest.write_text(json.dumps(facts | made_with, indent=1) + "\n", encoding="utf-8")

    def check(
        self,
        wrong: Callable[[Item], str],
        known: Sequence[Item],
        size: int | None,
        workers: Workers,
        *,
        said: Callable[[list[Item]], str],
    ) -> int:
        """Certify this many of the platforms again, all if None; return the exit code.

        Parameters
        ----------
        wrong
            What is wrong with one of them, empty if nothing is.
        known
            All of them.
        size
            How many are chosen at random.
        workers
            Who does it.
        said
            What is confirmed of those that were chosen.
        """
        manifest = json.loads(self.manifest.read_text(encoding="utf-8"))
        problems = []
        if sha256(self.file.read_bytes()) != manifest["sha256"][self.file.name]:
            problems.append(f"{self.file.name} is not the file of the manifest")
        chosen = sampled(known, size)
        again = workers.in_order(wrong, chosen)
        problems += filter(None, progress(again, total=len(chosen), label="certifying platforms"))
        return report(problems, f"{len(chosen)} of {len(known)} {said(chosen)}")
