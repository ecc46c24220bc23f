"""Exact counts of random platforms: compared with the generic ones, and timed beside msolve.

    python -m tools.verify.counts families --check [--largest N] [--sample N]
    python -m tools.verify.counts times [--largest N] [--limit SECONDS] [--record]

`families` counts a random platform of every family with a generic one-sided count up to N (default
400), by linear algebra modulo a random 61-bit prime (gspcli.certification.counting). Its exact
count, its distinct count and the count of its geometry must all be the generic one, which then
proves them. `times` counts a random platform of some large types, on one core. So does msolve,
modulo a prime of 30 bits, in the coordinates that suit the constraints. Times are processor times,
the best of five if below a second; of msolve only F4 counts (`-g 1`: leading monomials). gsp's time
is given without and with the number of distinct solutions. With --record the table goes into
docs/exact-counts.md. The exit code is 1 if a count is not the generic one.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gspcli.catalogue.counts import family_counts, generic_counts
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import CLASSES, Family, families
from gspcli.certification.counting import count_exactly, count_geometry
from gspcli.certification.counting.coordinate_choice import Blocks
from gspcli.certification.counting.homomorphism import SMALL
from gspcli.certification.counting.modular_platform import ModularPlatform
from gspcli.certification.counting.residue_counts import count
from gspcli.cli.streams import progress
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance
from gspcli.geometry.random_instances import random_instance
from tools.oracle import msolve
from tools.oracle.homomorphisms import fields
from tools.oracle.matrix_ideal import (
    BODY,
    RHO,
    TRANSLATION,
    Ideal,
    equations,
    without_linear,
)
from tools.recording import CONFIRMED, DIFFERENT, ROOT, add_sample, report, sampled, with_section

#: The probability of error if a count equals the generic one: that of random tests of the border
#: basis.
LARGEST_ERROR = 1e-14
PAGE = ROOT / "docs" / "exact-counts.md"
TYPES = (
    "6 PP",
    "6 PL",
    "2 PP 2 PL 2 LP",
    "2 DPP 2 DPL DLP DLL",
    "3 PL 3 LP",
    "3 DPL 3 DLL",
    "6 DLL",
)
_UNLIMITED = 2**62
_REPEATED_BELOW_S = 1.0


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
    results = [
        counted(family, seed)
        for seed, family in progress(chosen, total=len(chosen), label="counting solutions")
    ]
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


@dataclass(frozen=True)
class Times:
    """What was measured for a type: solutions, and seconds of processor time."""

    type_id: str
    solutions: int
    expected: int
    count: float
    distinct: float
    f4: float | None


def without_other_coordinates(ideal: Ideal, blocks: Blocks) -> Ideal:
    """Return the ideal in the coordinates of some blocks; equations with others are left out."""
    names = {Blocks.TRANSLATION: TRANSLATION, Blocks.BODY: BODY, Blocks.DISTANCE: [RHO]}
    others = {name for block, group in names.items() if block not in blocks for name in group}
    kept = [p for p in ideal.polynomials if not any(others.intersection(m) for m in p)]
    return Ideal([name for name in ideal.names if name not in others], kept, ideal.prime)


def count_times(instance: Instance) -> tuple[int, float, float]:
    """Return the number of solutions, and the times without and with that of distinct ones."""
    platform = ModularPlatform(instance, SEED, bits=SMALL)
    equations_of_one_side = platform.equations(platform.choices[0])
    best = []
    for find_distinct in (False, True):
        seconds: list[float] = []
        while not seconds or (len(seconds) < 5 and min(seconds) < _REPEATED_BELOW_S):
            start = time.process_time()
            result = count(
                equations_of_one_side,
                platform.blocks,
                platform.prime,
                seed=SEED,
                max_work=_UNLIMITED,
                find_distinct=find_distinct,
            )
            seconds.append(time.process_time() - start)
        best.append(min(seconds))
    return result.solutions, best[0], best[1]


def measured(name: str, limit: float) -> Times:
    """Return the times of a random platform of a type."""
    gsp_type = parse_type(name)
    instance, _ = random_instance(gsp_type, np.random.default_rng(SEED), one_sided=True)
    solutions, first, second = count_times(instance)
    blocks = ModularPlatform(instance, SEED, bits=SMALL).blocks
    field = next(fields(instance))
    ideal = without_linear(without_other_coordinates(equations(instance, field), blocks))
    f4 = msolve.elimination_time(ideal, time_limit_s=limit)
    expected = generic_counts(gsp_type).one_sided
    return Times(gsp_type.id, solutions, expected, first, second, f4)


def table(rows: list[Times], limit: float) -> Iterator[str]:
    """Yield the lines of the table."""
    columns = ("platform", "solutions", "count", "and distinct", f"F4 of msolve {msolve.version()}")
    yield f"| {' | '.join(columns)} |"
    yield "|---|---:|---:|---:|---:|"
    for row in rows:
        f4 = f"more than {limit:g}" if row.f4 is None else f"{row.f4:.3g}"
        cells = (row.type_id, row.solutions, f"{row.count:.2g}", f"{row.distinct:.2g}", f4)
        yield "| " + " | ".join(map(str, cells)) + " |"


def measure(largest: int, limit: float, *, record: bool) -> int:
    """Time the counts of the types up to a generic count; return the exit code."""
    rows = []
    for name in TYPES:
        if generic_counts(parse_type(name)).one_sided <= largest:
            rows.append(measured(name, limit))
            print(rows[-1], flush=True)
    text = "\n".join(table(rows, limit)) + "\n"
    print(text)
    if record:
        PAGE.write_text(with_section(PAGE, "count times", text), encoding="utf-8")
    return CONFIRMED if all(row.solutions == row.expected for row in rows) else DIFFERENT


def main() -> int:
    """Do what is asked; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    families_parser = commands.add_parser("families")
    families_parser.add_argument("--check", action="store_true", help="as without it")
    families_parser.add_argument("--largest", type=int, default=400, metavar="N", help="solutions")
    add_sample(families_parser)
    times = commands.add_parser("times")
    times.add_argument("--largest", type=int, default=4096, metavar="N", help="solutions")
    times.add_argument("--limit", type=float, default=600, metavar="SECONDS", help="for msolve")
    times.add_argument("--record", action="store_true", help="write the page")
    arguments = parser.parse_args()
    if arguments.command == "families":
        return compare_families(arguments.largest, arguments.sample)
    return measure(arguments.largest, arguments.limit, record=arguments.record)


if __name__ == "__main__":
    sys.exit(main())
