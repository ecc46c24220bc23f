"""Time exact counts of large platforms against msolve's F4, and write the table of the page.

    python -m tools.verify.count_times [--largest N] [--limit SECONDS] [--record]

Both count the solutions of the same random platform of each type modulo a prime of 30 bits, in the
coordinates that suit its constraints, on one core; the times are processor times, the best of five
below a second, of msolve only that of F4 (`-g 1`: leading monomials). gsp's time is given without
and with the number of distinct solutions. With --record the table goes into docs/exact-counts.md.
The exit code is 1 if a count is not the generic one.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.parsing import parse_type
from gspcli.certification.counting.coordinate_choice import Blocks
from gspcli.certification.counting.homomorphism import SMALL
from gspcli.certification.counting.modular_platform import ModularPlatform
from gspcli.certification.counting.residue_counts import count
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance
from gspcli.solver.generate import random_instance
from tools.oracle import msolve
from tools.oracle.homomorphisms import fields
from tools.oracle.matrix_ideal import BODY, RHO, TRANSLATION, Ideal, equations, without_linear
from tools.recording import CONFIRMED, DIFFERENT, ROOT, with_section

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


def main() -> int:
    """Measure; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--largest", type=int, default=4096, metavar="N", help="solutions")
    parser.add_argument("--limit", type=float, default=600, metavar="SECONDS", help="for msolve")
    parser.add_argument("--record", action="store_true", help="write the page")
    arguments = parser.parse_args()
    rows = []
    for name in TYPES:
        if generic_counts(parse_type(name)).one_sided <= arguments.largest:
            rows.append(measured(name, arguments.limit))
            print(rows[-1], flush=True)
    text = "\n".join(table(rows, arguments.limit)) + "\n"
    print(text)
    if arguments.record:
        PAGE.write_text(with_section(PAGE, "count times", text), encoding="utf-8")
    return CONFIRMED if all(row.solutions == row.expected for row in rows) else DIFFERENT


if __name__ == "__main__":
    sys.exit(main())
