"""The content of `data/counts/`: the counts with their evidence, from the results of tasks."""

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

from gspcli.catalogue.counts import FAMILIES_FILE, Method, all_families, family_counts, family_of
from gspcli.catalogue.kinds import Kind
from gspcli.catalogue.types import Family
from gspcli.defaults import SEED
from gspcli.errors import CheckFailed
from tools.atlas.groebner import msolve_path, msolve_version
from tools.atlas.intersection_numbers import NUMBERS_FILE, intersection_number, law
from tools.atlas.tasks import LIMITS, PRIMES, TOLERANCE, Result, Task, monodromy_counts

MANIFEST_FILE = "manifest.json"
COMMAND = "gsp atlas build"
COLUMNS = {
    FAMILIES_FILE: {
        "family": "class and distances; the kinds of the angles make no difference",
        "one_sided": "generic count with the side of each DPH and DHP chosen; a theorem",
        "two_sided": "the same with every side open: twice as many for each",
        "confirmed": "the methods below that gave the one-sided count",
        "orders": "dimensions of the quotients for a random platform modulo each prime",
        "certified": "different poses of one random real platform proved to exist",
        "trace": "defect of the trace test of these poses; one that is rounding passes",
        "trace_without_one": "the smallest defect if one of them is left out",
        "two_sided_orders": "as orders, with the sides open, where the poses are few",
        "two_sided_certified": "as certified, likewise",
    },
    NUMBERS_FILE: {
        "spaces": "spaces of the six quadrics",
        "number": "generic number of their common points with N not zero on the Study quadric; "
        "a theorem",
        "monodromy": "from data/start-systems",
        "orders": "dimensions of the quotients for random quadrics modulo each prime",
    },
}
METHODS = {
    "groebner": "Each prime has a random platform of its own, and mirror images have different "
    f"ones. Up to {LIMITS[1]} solutions, with the sides open up to {LIMITS[2]}.",
    "tracking": "One random real platform for each family, and another with the sides open. All "
    "paths from the start system are tracked, and the ends proved in ball arithmetic to be near "
    "different simple poses.",
    "trace": "Of the poses of the same platform, sides chosen: second difference of the sum of "
    "the functions of a space along a general pencil, relative to the size of the sum; the best "
    f"of up to three pencils. It is passed if it is below {TOLERANCE} times what it becomes "
    "without one pose. Both numbers are measured in floating point and depend on the processor in "
    "their last digits.",
}

Results = Mapping[Task, Result]
Row = dict[str, Any]


def recorded(task: Task) -> int:
    """Return the recorded count for a task."""
    if task.distances is None:
        return intersection_number(task.subject)
    return family_counts(family_of(task.distances)).of(sides=task.sides)


class RecordVerdict(Enum):
    """The comparison of a result with the record."""

    EQUAL = "equal"
    DIFFERENT = "different"
    UNFINISHED = "unfinished"


def verdict(result: Result) -> RecordVerdict:
    """Compare a result with the record.

    A smaller number of certified poses is no contradiction: it is a lower bound. A trace test may
    fail because a path fails.
    """
    count = recorded(result.task)
    trace = result.tracked.trace if result.tracked else None
    if result.count == count and (trace is None or trace.passed):
        return RecordVerdict.EQUAL
    certified = not result.task.characteristic
    if result.count is None or (certified and result.count <= count):
        return RecordVerdict.UNFINISHED
    return RecordVerdict.DIFFERENT


def contents(results: Results, seed: int = SEED) -> dict[str, str]:
    """Return the files of the data by their names, manifest included.

    Parameters
    ----------
    results
        The results of `all_tasks`; some may be missing.
    seed
        The seed of the tasks.

    Raises
    ------
    CheckFailed
        If a count contradicts the theorems.
    """
    known = {task: result for task, result in results.items() if task.seed == seed}
    numbers = [_number(spaces, known, seed) for spaces in monodromy_counts()]
    rows = [_family(family, known, seed) for family in all_families()]
    files = {NUMBERS_FILE: _csv(NUMBERS_FILE, numbers), FAMILIES_FILE: _csv(FAMILIES_FILE, rows)}
    manifest = {
        "what": "generic numbers of solutions of all types, and how each was confirmed",
        "command": COMMAND,
        "seed": seed,
        "primes": list(PRIMES),
        "methods": METHODS,
        "families": dict(sorted(Counter(row["confirmed"] for row in rows).items())),
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
    """Return the names of the files of a folder that differ from the expected content."""
    return [
        name
        for name, text in files.items()
        if not (folder / name).is_file() or (folder / name).read_text(encoding="utf-8") != text
    ]


def _number(spaces: str, results: Results, seed: int) -> Row:
    number, monodromy = intersection_number(spaces), monodromy_counts()[spaces]
    orders = _orders(spaces, 1, results, seed)
    _agree(spaces, number, [monodromy, *orders])
    return {"spaces": spaces, "number": number, "monodromy": monodromy, "orders": orders}


def _family(family: Family, results: Results, seed: int) -> Row:
    subject = _subject(family.distances)
    count = law(family.distances)
    both = count * 2 ** sum(kind.has_sides for kind in family.distances)
    orders, certified = _evidence(family.id, subject, 1, count, results, seed)
    two_orders, two_certified = _evidence(
        f"{family.id}, both sides", subject, 2, both, results, seed
    )
    result = results.get(Task(subject, 1, 0, seed))
    trace = result.tracked.trace if result and result.tracked else None
    confirmed = [
        method.value
        for method, holds in (
            (Method.GROEBNER, bool(orders)),
            (Method.TRACKING, certified == count),
            (Method.TRACE, certified == count and trace is not None and trace.passed),
        )
        if holds
    ]
    return {
        "family": family.id,
        "one_sided": count,
        "two_sided": both,
        "confirmed": "+".join(confirmed),
        "orders": orders,
        "certified": certified,
        "trace": trace and f"{trace.defect:.0e}",
        "trace_without_one": trace and f"{trace.without_one:.0e}",
        "two_sided_orders": two_orders,
        "two_sided_certified": two_certified,
    }


def _evidence(
    what: str, subject: str, sides: int, count: int, results: Results, seed: int
) -> tuple[list[int], int | None]:
    """Return the orders and the number of certified poses, after a check against the count."""
    orders = _orders(subject, sides, results, seed)
    _agree(what, count, orders)
    result = results.get(Task(subject, sides, 0, seed))
    certified = result.count if result else None
    if certified is not None and certified > count:
        message = f"{what}: {certified} poses are certified, but there should be {count}"
        raise CheckFailed(message)
    return orders, certified


def _subject(distances: Sequence[Kind]) -> str:
    return " ".join(kind.name for kind in distances)


def _orders(subject: str, sides: int, results: Results, seed: int) -> list[int]:
    """Return the orders modulo all primes, or none if one is missing."""
    found = [results.get(Task(subject, sides, prime, seed)) for prime in PRIMES]
    orders = [r.count for r in found if r is not None and r.count is not None]
    return orders if len(orders) == len(PRIMES) else []


def _agree(what: str, number: int, counted: Iterable[int]) -> None:
    different = {number, *counted}
    if len(different) != 1:
        message = f"{what}: {number} by theorem, but counted were {sorted(different - {number})}"
        raise CheckFailed(message)


def _csv(name: str, rows: Iterable[Row]) -> str:
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, list(COLUMNS[name]), lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow(
            {k: " ".join(map(str, v)) if isinstance(v, list) else v for k, v in row.items()}
        )
    return buffer.getvalue()
