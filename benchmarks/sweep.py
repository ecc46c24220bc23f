"""How the cost grows with the number of solutions: one platform of each of the 896 families."""

from __future__ import annotations

import csv
import resource
import time
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from itertools import islice
from pathlib import Path

from benchmarks.cases import random_instances
from benchmarks.charts import scatter_chart
from benchmarks.homotopy import structure_of
from gspcli.catalogue.counts import all_families, family_counts
from gspcli.catalogue.types import MAX_ANGLES
from gspcli.continuation.start import start_system
from gspcli.solver import solve

#: Platforms solved more quickly than this (in seconds) are solved again, and the least counts.
_QUICK = 0.05


@dataclass(frozen=True)
class Cost:
    """The cost of one random one-sided platform, solved alone after loading."""

    family: str
    method: str
    expected: int
    found: int
    real: int
    verdict: str
    milliseconds: float
    """Processor time."""


def costs(seed: int, step: int) -> Iterator[Cost]:
    """Yield the cost for every `step`-th family that has a finite number of solutions."""
    finite = (family for family in all_families() if family_counts(family).one_sided)
    for family in islice(finite, 0, None, step):
        gsp_type = family.types[0]
        instance = next(random_instances(gsp_type.id, seed))
        if len(gsp_type.angles) < MAX_ANGLES:
            # Now, because it is derived on first use, which does not count.
            start_system(structure_of(instance)[0])
        times: list[float] = []
        while not times or (len(times) < 3 and times[-1] < _QUICK):
            began = time.process_time()
            result = solve(instance)
            times.append(time.process_time() - began)
        yield Cost(
            family.id,
            "paths" if len(gsp_type.angles) < MAX_ANGLES else "closed form",
            result.expected,
            result.counts.found,
            result.counts.real,
            result.verdict,
            round(min(times) * 1e3, 3),
        )


def peak_memory() -> float:
    """Return the peak memory of this process so far, in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def write_csv(rows: Sequence[Cost], path: Path) -> None:
    """Write the costs as CSV."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(Cost))
        writer.writerows(map(astuple, rows))


def plot(rows: Sequence[Cost]) -> bytes:
    """Return the costs over the counts as SVG, both on logarithmic axes."""
    groups = {
        method: [(row.expected, row.milliseconds) for row in rows if row.method == method]
        for method in ("paths", "closed form")
    }
    return scatter_chart(
        groups, "svg", x_label="generic number of solutions", y_label="milliseconds"
    )
