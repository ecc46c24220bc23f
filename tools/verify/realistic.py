"""How quickly realistic machines are solved: for the first time, with other values, in a batch.

    python -m tools.verify.realistic [--count 500] [--seed 20031] [--jobs 2] [--only 6-6] [--check]

Each machine of `tools.special.realistic` is solved with nothing kept of its geometry, then with
other values one by one, then with many sets of values. All answers must be complete and proved.
Without ``--count`` the record ``data/verification/realistic-machines.csv`` is written or compared:
``--check`` compares counts, since times are of the machine, and asks what must hold of them: other
values and rows take no more than three times the median of their structure.

Times are processor times in ms; of other values and rows they are medians. Run it with
``OPENBLAS_NUM_THREADS=1``.
"""

from __future__ import annotations

import csv
import json
import os
import sys
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
from itertools import islice
from pathlib import Path
from statistics import median

from gspcli import __version__
from gspcli.defaults import SEED
from gspcli.geometry.numbers import Number
from gspcli.solver import solve, solve_batch
from gspcli.solver.result import SolveResult
from gspcli.solver.starts.solved_starts import SolvedStarts
from tools.recording import (
    ROOT,
    add_workers,
    csv_text,
    parser,
    report,
    sampled,
    save,
    sha256,
    versions,
    with_section,
    workers_of,
)
from tools.special.realistic import Machine, machines

RECORD = ROOT / "data" / "verification" / "realistic-machines.csv"
MANIFEST = RECORD.with_suffix(".manifest.json")
PAGE = ROOT / "docs" / "special-platforms.md"
COUNT = 500
#: Solved one by one with other values; sets of values of a batch, and of one that is slow.
_OTHERS, _ROWS, _FEW = 7, 64, 4
_SLOW = 0.01
#: Machines of which all strategies are used.
_EVERYTHING = (1, 226)
#: After a second solution of this many seconds only one other set of values is solved.
_LONG = 2.0
#: No time is above this many times the median of its structure.
FACTOR = 3.0


@dataclass(frozen=True)
class Row:
    """What is found of one machine.

    Attributes
    ----------
    machine, drawn
        Its name, and what was drawn.
    verdict
        ``complete``, ``infinite`` or ``incomplete``, and ``not proved`` where one of its answers is
        complete without a proof.
    poses, real
        How many it has.
    incomplete
        How many of the other sets of values, one by one and in the batch, are not complete and
        proved.
    first, others, row
        Processor times in ms.
    """

    machine: str
    drawn: str
    verdict: str
    poses: int
    real: int
    incomplete: int
    first: float
    others: float
    row: float

    @property
    def structure(self) -> str:
        """The first part of the name."""
        return self.machine.partition("/")[0]


def measured(number: int, seed: int = SEED) -> Row:
    """Return what is found of one machine."""
    _warm_up()
    machine = next(islice(machines(number + 1, seed, _ROWS + _OTHERS, begin=number), 1))
    return measure(machine)


@cache
def _warm_up() -> None:
    """Import what solutions of machines with poses far away import."""
    for number in _EVERYTHING:
        solve(next(machines(number + 1, rows=_ROWS + _OTHERS, begin=number)).instance)


def measure(machine: Machine) -> Row:
    """Return what is found of a machine."""
    instance, starts = machine.instance, SolvedStarts()
    began = time.process_time()
    result = solve(instance, starts=starts)
    first = time.process_time() - began
    others, wrong = [], 0
    for k, row in enumerate(machine.rows[: _OTHERS + 1]):
        numbers = {i: Number.of(repr(x)) for i, x in enumerate(row.tolist())}
        other = instance.with_values(numbers)
        began = time.process_time()
        found = solve(other, starts=starts)
        # The second solution of a geometry makes what is kept of it.
        taken = time.process_time() - began
        if not k and taken > _LONG:
            return _slow(machine, result, first, starts)
        others += [taken] if k else []
        wrong += found.verdict != result.verdict or found.proof is None
    few = machine.rows[:_FEW]
    solve_batch(instance, few, starts=starts)
    began = time.process_time()
    solve_batch(instance, few, starts=starts)
    slow = (time.process_time() - began) / _FEW > _SLOW
    rows = few if slow else machine.rows[_OTHERS:]
    solve_batch(instance, rows, starts=starts)
    began = time.process_time()
    batch = solve_batch(instance, rows, starts=starts)
    seconds = (time.process_time() - began) / len(rows)
    wrong += int((~(batch.complete & batch.proved)).sum())
    verdict = result.verdict if result.proof is not None else f"{result.verdict}, not proved"
    times = (round(1e3 * x, 3) for x in (first, median(others), seconds))
    counts = result.counts.found, result.counts.real, wrong
    return Row(machine.name, machine.text, verdict, *counts, *times)


def _slow(machine: Machine, result: SolveResult, first: float, starts: SolvedStarts) -> Row:
    """Return what is found of a machine that takes long: one row stands for all."""
    began = time.process_time()
    batch = solve_batch(machine.instance, machine.rows[:1], starts=starts)
    taken = time.process_time() - began
    verdict = result.verdict if result.proof is not None else f"{result.verdict}, not proved"
    wrong = int((~(batch.complete & batch.proved)).sum())
    times = (round(1e3 * x, 3) for x in (first, taken, taken))
    counts = result.counts.found, result.counts.real, wrong
    return Row(machine.name, machine.text, verdict, *counts, *times)


def outliers(rows: Sequence[Row]) -> Iterator[str]:
    """Yield which times are above `FACTOR` times the median of their structure."""
    for name, members in by_structure(rows).items():
        for what in ("others", "row"):
            middle = median(getattr(row, what) for row in members)
            for row in members:
                if (taken := getattr(row, what)) > FACTOR * middle:
                    yield f"{row.machine}: {what} {taken:g} ms, {taken / middle:.1f} times {name}"


def by_structure(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Return rows by structure."""
    found: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        found[row.structure].append(row)
    return dict(found)


def summary(rows: Sequence[Row]) -> Iterator[str]:
    """Yield a line for each structure: medians, nine tenths, and the largest."""
    for name, members in sorted(by_structure(rows).items()):
        parts = []
        for what in ("first", "others", "row"):
            times = sorted(getattr(row, what) for row in members)
            high = times[int(0.9 * (len(times) - 1))]
            parts.append(f"{what} {median(times):.3g} / {high:.3g} / {times[-1]:.3g} ms")
        yield f"{name}: {len(members)} machines, {', '.join(parts)}"


def recorded(path: Path = RECORD) -> list[Row]:
    """Return the rows of the record."""
    with path.open(encoding="utf-8", newline="") as file:
        return [
            Row(
                machine=row["machine"],
                drawn=row["drawn"],
                verdict=row["verdict"],
                poses=int(row["poses"]),
                real=int(row["real"]),
                incomplete=int(row["incomplete"]),
                first=float(row["first"]),
                others=float(row["others"]),
                row=float(row["row"]),
            )
            for row in csv.DictReader(file)
        ]


def wrong(rows: Sequence[Row]) -> Iterator[str]:
    """Yield which machines are not complete and proved, in one of their answers."""
    for row in rows:
        if row.verdict != "complete" or row.incomplete:
            yield f"{row.machine} ({row.drawn}): {row.verdict}, {row.incomplete} others incomplete"


def main() -> int:
    """Run the command line."""
    given = parser(__doc__, sample=True)
    add_workers(given)
    given.add_argument("--count", type=int, metavar="N", help="measure this many, record nothing")
    given.add_argument("--seed", type=int, default=SEED, metavar="N", help="others than recorded")
    given.add_argument(
        "--begin", type=int, default=0, metavar="N", help="with --count: from this number on"
    )
    given.add_argument("--only", default="", metavar="STRUCTURE", help="of this structure")
    arguments = given.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    numbers = sampled(range(arguments.begin, arguments.count or COUNT), arguments.sample)
    if arguments.only:
        names = [machine.structure for machine in machines(max(numbers) + 1, rows=1)]
        numbers = [k for k in numbers if names[k] == arguments.only]
    rows = []
    for row in workers_of(arguments).in_order(partial(measured, seed=arguments.seed), numbers):
        rows.append(row)
        sys.stderr.write(
            f"{row.machine}: {row.verdict} {row.poses} {row.real} {row.incomplete}"
            f" | {row.first:g} {row.others:g} {row.row:g} | {row.drawn}\n"
        )
    print("\n".join(summary(rows)))
    differences = [*wrong(rows), *outliers(rows)]
    if arguments.check:
        known = {row.machine: row for row in recorded()}
        differences += [f"{row.machine}: differs" for row in rows if _differs(known, row)]
    elif arguments.count is None and not arguments.only:
        save(record(rows, arguments.seed), check=False, confirmed="")
    return report(differences, f"{len(rows)} realistic machines")


def record(rows: Sequence[Row], seed: int) -> dict[Path, str | bytes]:
    """Return the files that are written: the record, its manifest, and the table of the page."""
    content = csv_text([asdict(row) for row in rows])
    manifest = {
        "command": "python -m tools.verify.realistic",
        "seed": seed,
        "sha256": sha256(content),
        "versions": {"gsp": __version__} | versions("numpy", "python-flint"),
    }
    return {
        RECORD: content,
        MANIFEST: json.dumps(manifest, indent=1) + "\n",
        PAGE: with_section(PAGE, "realistic", "\n".join(table(rows))),
    }


def table(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the lines of the table of the page: medians, and the largest in brackets."""
    yield "| structure | machines | first | other values | in a batch | incomplete |"
    yield "| --- | ---: | ---: | ---: | ---: | ---: |"
    for name, members in sorted(by_structure(rows).items(), key=lambda x: -len(x[1])):
        cells = []
        for what in ("first", "others", "row"):
            times = [getattr(row, what) for row in members]
            cells.append(f"{_digits(median(times))} ms ({_digits(max(times))})")
        missing = sum(row.verdict != "complete" or row.incomplete > 0 for row in members)
        yield f"| {name} | {len(members)} | {' | '.join(cells)} | {missing} |"


def _digits(x: float) -> str:
    """Return a time with two digits, or whole."""
    return f"{x:.0f}" if x >= 10 else f"{x:.2g}"


def _differs(known: dict[str, Row], row: Row) -> bool:
    """Return whether a row has other counts than the record."""
    other = known.get(row.machine)
    counts = "drawn", "verdict", "poses", "real"
    return other is None or any(getattr(row, key) != getattr(other, key) for key in counts)


if __name__ == "__main__":
    sys.exit(main())
