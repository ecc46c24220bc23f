"""Count a random platform of each family exactly, and compare with the generic counts.

    python -m tools.data.family_counts --check [--largest N] [--sample N]

Families with a generic one-sided count up to N (default 400) are counted by linear algebra modulo a
random 61-bit prime (gspcli.certification.counting). The exact count of a platform, its distinct
count and the count of its geometry must all be the generic one, which then proves them. Times are
processor times. The exit code is 1 if a count is not the generic one.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

import numpy as np

from gspcli.catalogue.counts import family_counts
from gspcli.catalogue.types import CLASSES, Family, families
from gspcli.certification.counting import count_exactly, count_geometry
from gspcli.geometry.random_instances import random_instance
from tools.recording import parser, report, sampled

#: The probability of error if a count equals the generic one: that of random tests of the border
#: basis.
LARGEST_ERROR = 1e-14


@dataclass(frozen=True)
class Counted:
    """What was found for a family: its counts, the largest error, the processor time of a count."""

    family: Family
    counts: set[int | None]
    error: float
    seconds: float

    @property
    def is_right(self) -> bool:
        """Whether all counts are the generic one, and proved."""
        expected = family_counts(self.family).one_sided
        return self.counts == {expected} and self.error <= LARGEST_ERROR


def chosen_families(largest: int) -> list[Family]:
    """Return the families up to a generic one-sided count."""
    every = (family for group in CLASSES for family in families(group))
    return [family for family in every if family_counts(family).one_sided <= largest]


def counted(family: Family, seed: int) -> Counted:
    """Count a random platform of a family."""
    rng = np.random.default_rng(seed)
    instance, _ = random_instance(family.types[seed % len(family.types)], rng, one_sided=True)
    start = time.process_time()
    exact = count_exactly(instance, limit=None)
    seconds = time.process_time() - start
    geometry = count_geometry(instance, limit=None)
    return Counted(
        family,
        {exact.solutions, exact.distinct, geometry.solutions},
        max(exact.error, exact.distinct_error, geometry.error),
        seconds,
    )


def compare_families(largest: int, sample: int | None) -> int:
    """Count a platform of each family; return the exit code."""
    chosen = sampled(enumerate(chosen_families(largest)), sample)
    results = [counted(family, seed) for seed, family in chosen]
    slowest = sorted(results, key=lambda result: result.seconds, reverse=True)
    for result in slowest[:5]:
        print(f"{result.seconds:7.3f} s  {result.family.id}")
    seconds = [result.seconds for result in results]
    above = sum(x > 1 for x in seconds)
    print(f"{np.median(seconds):7.3f} s  median of processor times;  {above} above 1 s")
    wrong = [
        f"different: {result.family.id}: {result.counts}, error {result.error:.1e}"
        for result in results
        if not result.is_right
    ]
    return report(wrong, f"the generic counts of {len(results)} families, by exact counts")


def main() -> int:
    """Count the families; return the exit code."""
    options = parser(__doc__, sample=True)
    options.add_argument("--largest", type=int, default=400, metavar="N", help="solutions")
    arguments = options.parse_args()
    return compare_families(arguments.largest, arguments.sample)


if __name__ == "__main__":
    sys.exit(main())
