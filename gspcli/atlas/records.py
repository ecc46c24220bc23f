"""What `data/counts/` holds: the counts with their evidence, made from the results of tasks."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import platform
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from enum import Enum
from importlib.metadata import version
from pathlib import Path
from typing import Any

from gspcli.atlas.groebner import msolve_path, msolve_version
from gspcli.atlas.journal import Result
from gspcli.atlas.tasks import PRIMES, SEED, Task, monodromy_counts
from gspcli.catalogue.counts import (
    FAMILIES_FILE,
    NUMBERS_FILE,
    Method,
    all_families,
    family_counts,
    family_of,
    intersection_numbers,
    law,
)
from gspcli.catalogue.kinds import Kind
from gspcli.catalogue.types import Family
from gspcli.errors import CheckFailed

MANIFEST_FILE = "manifest.json"
COMMAND = "gsp atlas build"
COLUMNS = {
    FAMILIES_FILE: {
        "family": "class and distances; the kinds of the angles make no difference",
        "one_sided": "generic count with the side of each DPH and DHP chosen",
        "two_sided": "the same with every side open: twice as many for each",
        "method": "what establishes it: groebner, tracking, both, or only the law for products",
        "certified": "different poses of a random real platform proved to exist",
        "orders": "dimensions of the quotients of random platforms modulo the primes, if not large",
        "two_sided_certified": "as certified, sides open, where the poses are few",
        "two_sided_orders": "as orders, likewise",
    },
    NUMBERS_FILE: {
        "families": "families of the six quadrics",
        "number": "generic number of their common points with N not zero on the Study quadric",
        "monodromy": "from data/start-systems",
        "orders": "dimensions of the quotients modulo the primes",
    },
}

Results = Mapping[Task, Result]
Row = dict[str, Any]


def recorded(task: Task) -> int:
    """Return the count that the data have for a task."""
    if task.distances is None:
        return intersection_numbers()[task.subject]
    return family_counts(family_of(task.distances)).of(sides=task.sides)


class Verdict(Enum):
    """What a result says of the record."""

    EQUAL = "equal"
    DIFFERENT = "different"
    UNFINISHED = "unfinished"


def verdict(result: Result) -> Verdict:
    """Compare a result with the record.

    Too few certified poses contradict nothing: they are a lower bound.
    """
    count = recorded(result.task)
    if result.count == count:
        return Verdict.EQUAL
    certified = not result.task.characteristic
    if result.count is None or (certified and result.count < count):
        return Verdict.UNFINISHED
    return Verdict.DIFFERENT


def contents(results: Results, seed: int = SEED) -> dict[str, str]:
    """Return the files of the data by their names, manifest included.

    Parameters
    ----------
    results
        Of `all_tasks`; any may be missing.
    seed
        That of the tasks.

    Raises
    ------
    CheckFailed
        If two methods or two primes disagree.
    """
    counts = {task: r.count for task, r in results.items() if task.seed == seed}
    numbers = [_number(families, counts, seed) for families in monodromy_counts()]
    rows = [_family(family, counts, seed) for family in all_families()]
    files = {NUMBERS_FILE: _csv(NUMBERS_FILE, numbers), FAMILIES_FILE: _csv(FAMILIES_FILE, rows)}
    manifest = {
        "what": "generic numbers of solutions of all types, and how each was established",
        "command": COMMAND,
        "seed": seed,
        "primes": list(PRIMES),
        "methods": dict(sorted(Counter(row["method"] for row in rows).items())),
        "columns": COLUMNS,
        "versions": {
            "msolve": msolve_version() if msolve_path() else None,
            "python": platform.python_version(),
            **{name: version(name) for name in ("numpy", "python-flint")},
        },
        "sha256": {n: hashlib.sha256(text.encode()).hexdigest() for n, text in files.items()},
    }
    files[MANIFEST_FILE] = json.dumps(manifest, indent=1, ensure_ascii=False) + "\n"
    return files


def differences(folder: Path, files: Mapping[str, str]) -> list[str]:
    """Return the names of the files of a folder that differ from what they should be."""
    return [
        name
        for name, text in files.items()
        if not (folder / name).is_file() or (folder / name).read_text(encoding="utf-8") != text
    ]


def _number(families: str, counts: Mapping[Task, int | None], seed: int) -> Row:
    monodromy = monodromy_counts()[families]
    orders = _orders(families, 1, counts, seed)
    return {
        "families": families,
        "number": _agreed(families, [monodromy, *orders]),
        "monodromy": monodromy,
        "orders": orders,
    }


def _family(family: Family, counts: Mapping[Task, int | None], seed: int) -> Row:
    subject, sides = _subject(family.distances), 2 ** _sides(family)
    certified = counts.get(Task(subject, 1, 0, seed))
    two_certified = counts.get(Task(subject, 2, 0, seed))
    orders = _orders(subject, 1, counts, seed)
    two_orders = _orders(subject, 2, counts, seed)
    # By the law there are no more solutions, and certified ones are a lower bound.
    count = _agreed(family.id, orders or [law(family.distances)])
    _agreed(f"{family.id}, both sides", [sides * count, *two_orders])
    for proved, most in ((certified, count), (two_certified, sides * count)):
        if proved is not None and proved > most:
            message = f"{family.id}: {proved} poses are certified, but there should be {most}"
            raise CheckFailed(message)
    if orders:
        method = Method.BOTH if certified == count else Method.GROEBNER
    else:
        method = Method.TRACKING if certified == count else Method.LAW
    return {
        "family": family.id,
        "one_sided": count,
        "two_sided": sides * count,
        "method": method.value,
        "certified": certified,
        "orders": orders,
        "two_sided_certified": two_certified,
        "two_sided_orders": two_orders,
    }


def _sides(family: Family) -> int:
    return sum(kind.has_sides for kind in family.distances)


def _subject(distances: Sequence[Kind]) -> str:
    return " ".join(kind.name for kind in distances)


def _orders(subject: str, sides: int, counts: Mapping[Task, int | None], seed: int) -> list[int]:
    """Return the orders modulo all primes, or none if one is missing."""
    orders = [counts.get(Task(subject, sides, prime, seed)) for prime in PRIMES]
    return [] if None in orders else [order for order in orders if order is not None]


def _agreed(what: str, numbers: Iterable[int | None]) -> int:
    """Return the one number that all known ones are."""
    different = {number for number in numbers if number is not None}
    if len(different) != 1:
        message = f"{what}: the methods disagree: {sorted(different)}"
        raise CheckFailed(message)
    return different.pop()


def _csv(name: str, rows: Iterable[Row]) -> str:
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, list(COLUMNS[name]), lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow(
            {k: " ".join(map(str, v)) if isinstance(v, list) else v for k, v in row.items()}
        )
    return buffer.getvalue()
