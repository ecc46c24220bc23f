"""Measure how far the bounds of clearances are apart, on random hexapods, and record it.

    python tools/verify_clearances.py [--count 20] [--jobs 2] [--check [--sample N]]

For random 6-6 platforms (sizes and values of order one) the clearance of the pose they are made
from is bounded from below with proof and from above by the nearest fold found, at once and refined
(`gspcli.motion.clearances`). What must hold: the lower bound is positive and not above the upper
one, refining makes neither worse, and the medians of the ratios are at most 4 and 2. The record is
``data/verification/clearances.csv``.
"""

from __future__ import annotations

import csv
import io
import statistics
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields

import numpy as np
from recording import ROOT, add_sample, parser, report, sampled, save

from gspcli.catalogue.parsing import parse_type
from gspcli.defaults import SEED
from gspcli.motion.clearances import clearance
from gspcli.solver.generate import random_instance
from gspcli.workers import Workers

RECORD = ROOT / "data" / "verification" / "clearances.csv"
#: The most that medians of the ratios may be: at once, refined.
MOST = (4.0, 2.0)


@dataclass(frozen=True)
class Row:
    """The bounds of one platform."""

    number: int
    lower: float
    upper: float
    refined_lower: float
    refined_upper: float

    @property
    def ratios(self) -> tuple[float, float]:
        """Upper bound by lower bound, at once and refined."""
        return self.upper / self.lower, self.refined_upper / self.refined_lower

    @property
    def holds(self) -> bool:
        """Whether the bounds are in order."""
        return (
            0 < self.lower <= self.refined_lower <= self.refined_upper <= self.upper < float("inf")
        )


def examine(number: int) -> Row:
    """Bound the clearance of a random platform."""
    rng = np.random.default_rng((SEED, number))
    instance, (R, T) = random_instance(parse_type("6PP"), rng)
    found = [clearance(instance, R, T, refine=refine) for refine in (False, True)]
    # Four digits: the last ones depend on the processor.
    numbers = [float(f"{bound:.4g}") for one in found for bound in (one.lower, one.upper)]
    return Row(number, *numbers)


def written(rows: Mapping[int, Row]) -> str:
    """Return the record."""
    text = io.StringIO()
    writer = csv.DictWriter(text, [field.name for field in fields(Row)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(asdict(rows[number]) for number in sorted(rows))
    return text.getvalue()


def main() -> int:
    """Measure, compare or write; return the exit code."""
    options = parser(__doc__)
    add_sample(options)
    options.add_argument("--count", type=int, default=20, help="how many platforms")
    options.add_argument("--jobs", type=int, default=1, help="processes")
    arguments = options.parse_args()
    numbers = sampled(range(arguments.count), arguments.sample if arguments.check else None)
    rows = {row.number: row for row in Workers(arguments.jobs).in_order(examine, numbers)}
    medians = [statistics.median(row.ratios[k] for row in rows.values()) for k in (0, 1)]
    summary = (
        f"{len(rows)} platforms: median ratio {medians[0]:.2f} at once, {medians[1]:.2f} refined"
    )
    wrong = [f"{row.number}: {asdict(row)}" for row in rows.values() if not row.holds]
    if len(rows) == arguments.count and any(a > b for a, b in zip(medians, MOST, strict=True)):
        wrong.append(f"the medians are above {MOST}")
    if arguments.check:
        lines = set(RECORD.read_text(encoding="utf-8").splitlines())
        differs = [line for line in written(rows).splitlines() if line not in lines]
        return report([*differs, *wrong], summary)
    save({RECORD: written(rows)}, check=False, confirmed="")
    return report(wrong, summary)


if __name__ == "__main__":
    sys.exit(main())
