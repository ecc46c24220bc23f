"""Search, build and check `data/witnesses/`: platforms with many real solutions.

    python -m tools.witnesses search JOURNAL [--minutes N] [--effort PATHS] [--most SOLUTIONS]
    python -m tools.witnesses write JOURNAL
    python -m tools.witnesses check [--sample N]

`search` and `check` take --jobs N, or --scheduler ADDRESS for the workers of a Dask scheduler.

`search` makes attempts (`gspcli.reality.maximize`) for one family after the other, those with few
solutions first, from the best platform known or from random ones in turn, and appends each result
to the journal, a work file; it continues where the journal ends. `write` rounds the best platform
of each family to short decimals, certifies its real poses and records it, if it is better than what
is recorded. `check` solves every recorded platform and certifies its real poses
again; it exits with 1 if there are fewer.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import io
import json
import platform as python_platform
import sys
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import flint
import numpy as np

from gspcli.catalogue.counts import all_families, family_counts
from gspcli.catalogue.kinds import ALL
from gspcli.catalogue.types import CONSTRAINTS, Family
from gspcli.catalogue.witnesses import Witness, witness_text
from gspcli.cli.progress_bars import progress
from gspcli.defaults import SEED
from gspcli.errors import GspError
from gspcli.reality.maximize import Search
from gspcli.reality.platforms import Platforms, multiplier
from gspcli.reality.witness_proofs import (
    certified_real,
    quickly_certified_real,
    real_instance,
    roughly_rounded,
    rows_of,
    witness_instance,
)
from gspcli.workers import Workers
from tools.recording import add_sample, report, sampled
from tools.witnesses.known import (
    FOLDER,
    Known,
    add_entry,
    canonical_families,
    kinds_of,
    read_journal,
    recorded,
    result,
    simpler_ones,
    solutions,
)

EFFORT = 40_000


def search(journal: Path, minutes: float, effort: int, most: int, workers: Workers) -> None:
    """Make attempts until the time is over, or all solutions of all families are real.

    Families with more than `most` solutions are left out, and those to which a platform of a
    simpler family with as many solutions is lifted (`tools/witnesses/lift.py`).
    """
    known = Known(journal)
    families = [
        family
        for family in canonical_families()
        if solutions(family) <= most and not any(simpler_ones(family))
    ]
    done: dict[str, set[int]] = {family.id: set() for family in families}
    for entry in read_journal(journal):
        done.setdefault(entry["family"], set()).add(entry.get("attempt", -1))
    end = time.monotonic() + 60 * minutes

    def wanted() -> Iterator[tuple[Family, int, Platforms | None]]:
        for number in range(10_000):
            for family in families:
                best, kinds = known.counts.get(family.id, 0), kinds_of(family)
                if number not in done[family.id] and best < solutions(family):
                    if time.monotonic() > end:
                        return
                    yield family, number, known.platform(kinds) if best else None

    for entry in workers.as_completed(partial(attempt, effort=effort), wanted()):
        name, number, real = entry["family"], entry["attempt"], entry["real"]
        best = known.counts.get(name, 0)
        if real <= best:
            entry.pop("numbers", None)
        add_entry(journal, entry)
        known.add(name, real, entry)
        sys.stderr.write(f"{name}, attempt {number}: {real}, known {best}\n")


def attempt(which: tuple[Family, int, Platforms | None], effort: int) -> dict[str, Any]:
    """Make an attempt, from the best platform or anew; return its entry of the journal."""
    family, number, best = which
    kinds, total = kinds_of(family), solutions(family)
    starts, steps = max(4, min(32, effort // (20 * total))), max(20, effort // total)
    search = Search(kinds, SEED, starts=starts, steps=steps)
    found = search.near(best, number).attempt(number)
    entry: dict[str, Any] = {"family": family.id, "attempt": number, "effort": effort, "real": 0}
    if found is not None:
        entry |= result(family, found)
    return entry


def write(journal: Path) -> None:
    """Record the best platforms of the journal that are better than the recorded ones."""
    known = recorded()
    best: dict[str, list[dict]] = {}
    for entry in read_journal(journal):
        best.setdefault(entry["family"], []).append(entry)
    for family in canonical_families():
        entries = sorted(best.get(family.id, []), key=_worth)
        for entry in entries:
            if "numbers" not in entry:
                continue
            each = multiplier(kinds_of(family))
            least = known[family.id].real if family.id in known else 0
            if each * entry["real"] <= least:
                break
            found = certified(family, entry)
            if found.real <= least:
                sys.stderr.write(f"{family.id}: {entry['real']} do not survive rounding\n")
                continue
            known[family.id] = found
            save(known)
            sys.stderr.write(f"{family.id}: {least} -> {found.real}\n")
            if found.real == each * entry["real"]:
                break


def _worth(entry: dict) -> tuple[int, float]:
    """Sort entries of the journal: many real solutions first, then small platforms."""
    numbers = np.abs(np.concatenate([np.ravel(part) for part in entry.get("numbers", [0.0])]))
    return -entry["real"], float(numbers.max())


def certified(family: Family, entry: dict) -> Witness:
    """Return a witness from an entry of the journal; rounding may cost it real solutions.

    Where not all could be certified it has so many fewer that their number can be right.
    """
    kinds = kinds_of(family)
    numbers = Platforms(kinds, *(np.array(part, float) for part in entry["numbers"]))
    wanted = entry["real"] * multiplier(kinds)
    try:
        instance = real_instance(numbers, wanted)
        real = certified_real(instance, wanted)
    except GspError:
        instance = roughly_rounded(numbers)
        real = quickly_certified_real(instance, wanted)
    sides = 2 ** sum(kind.has_sides for kind in kinds)
    return Witness(family, real - real % max(2, sides), tuple(rows_of(instance)))


def save(known: dict[str, Witness]) -> None:
    """Write the records and their manifest."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(["family", "real", "numbers"])
    families = [family for family in all_families() if family.id in known]
    writer.writerows([f.id, known[f.id].real, witness_text(known[f.id])] for f in families)
    FOLDER.mkdir(parents=True, exist_ok=True)
    (FOLDER / "real.csv").write_text(buffer.getvalue(), encoding="utf-8")
    manifest = {
        "what": "platforms with many real solutions: lower bounds of the largest possible number",
        "command": "python -m tools.witnesses search JOURNAL, then write JOURNAL",
        "check": "python -m tools.witnesses check",
        "seed": SEED,
        "families": len(families),
        "all_solutions_real": sum(known[f.id].real == family_counts(f).two_sided for f in families),
        "versions": {
            "numpy": np.__version__,
            "python": python_platform.python_version(),
            "python-flint": flint.__version__,
        },
        "sha256": {"real.csv": hashlib.sha256(buffer.getvalue().encode()).hexdigest()},
    }
    text = json.dumps(manifest, indent=1) + "\n"
    (FOLDER / "manifest.json").write_text(text, encoding="utf-8")


def wrong(found: Witness) -> str:
    """Return what is wrong with a record, after solving and certifying the platform again."""
    name, most = found.family.id, family_counts(found.family).two_sided
    instance = witness_instance(found, (ALL,) * (CONSTRAINTS - len(found.family.distances)))
    real = certified_real(instance, found.real)
    if real < found.real:
        return f"{name}: {found.real} recorded, {real} certified"
    return f"{name}: {real} recorded, more than the generic count" if real > most else ""


def check(size: int | None, workers: Workers) -> int:
    """Certify the recorded platforms again; return the exit code."""
    manifest = json.loads((FOLDER / "manifest.json").read_text(encoding="utf-8"))
    content = (FOLDER / "real.csv").read_bytes()
    problems = []
    if hashlib.sha256(content).hexdigest() != manifest["sha256"]["real.csv"]:
        problems.append("real.csv is not the file of the manifest")
    known = list(recorded().values())
    chosen = sampled(known, size)
    again = workers.in_order(wrong, chosen)
    problems += filter(None, progress(again, total=len(chosen), label="certifying platforms"))
    poses = sum(found.real for found in chosen)
    return report(
        problems, f"{len(chosen)} of {len(known)} witnesses, {poses} real poses certified"
    )


def main() -> int:
    """Run the part that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parts = parser.add_subparsers(dest="part", required=True)
    for name in ("search", "write"):
        part = parts.add_parser(name)
        part.add_argument("journal", type=Path)
        if name == "search":
            part.add_argument("--minutes", type=float, default=60)
            part.add_argument("--effort", type=int, default=EFFORT)
            part.add_argument("--most", type=int, default=10_000)
    add_sample(parts.add_parser("check"))
    for name in ("search", "check"):
        parts.choices[name].add_argument("--jobs", type=int, default=1)
        parts.choices[name].add_argument("--scheduler", metavar="ADDRESS")
    arguments = parser.parse_args()
    if arguments.part == "write":
        write(arguments.journal)
        return 0
    workers = Workers(arguments.jobs, arguments.scheduler)
    if arguments.part == "check":
        return check(arguments.sample, workers)
    search(arguments.journal, arguments.minutes, arguments.effort, arguments.most, workers)
    return 0


if __name__ == "__main__":
    sys.exit(main())
