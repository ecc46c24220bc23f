"""Search, build and check `data/witnesses/`: platforms with many real solutions.

    python tools/build_witnesses.py search JOURNAL [--minutes N] [--effort PATHS] [--most SOLUTIONS]
    python tools/build_witnesses.py write JOURNAL
    python tools/build_witnesses.py check [--sample N] [--jobs N]

`search` makes attempts (`gspcli.atlas.maximize`) for one family after the other, those with few
solutions first, and appends each result to the journal, a work file; it continues where the journal
ends. An attempt depends on the seed, its number and the effort only. `write` rounds the best
platform of each family to short decimals, certifies its real poses and records it, if it is
better than what is recorded. `check` solves every recorded platform and certifies its real poses
again; it exits with 1 if a number differs.
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
from pathlib import Path

import flint
import numpy as np
from recording import ROOT, add_sample, report, sampled

sys.path.insert(0, str(ROOT))

from gspcli.atlas.maximize import SEED, Search, Solved, multiplier
from gspcli.atlas.platforms import Platforms
from gspcli.atlas.processes import in_order
from gspcli.atlas.witnesses import certified_real, real_instance, rows_of, witness_instance
from gspcli.catalogue.counts import all_families, family_counts, mirrored
from gspcli.catalogue.kinds import ALL, Kind
from gspcli.catalogue.types import CONSTRAINTS, Family
from gspcli.catalogue.witnesses import Witness, read_row, witness_text
from gspcli.cli.progress import progress
from gspcli.errors import GspError

FOLDER = ROOT / "data" / "witnesses"
EFFORT = 40_000


def canonical_families() -> list[Family]:
    """Return one of each two mirrored families, those with few solutions first."""
    chosen = [f for f in all_families() if not mirrored(f.distances) < f.distances]
    return sorted(chosen, key=solutions)


def kinds_of(family: Family) -> tuple[Kind, ...]:
    """Return the kinds of a type of a family, all angles ALL."""
    return family.distances + (ALL,) * (CONSTRAINTS - len(family.distances))


def solutions(family: Family) -> int:
    """Return how many solutions almost every reduced platform has."""
    return family_counts(family).two_sided // multiplier(kinds_of(family))


def search(journal: Path, minutes: float, effort: int, most: int) -> None:
    """Make attempts until the time is over, or all solutions of all families are real.

    Families with more than `most` solutions are left out.
    """
    done: dict[str, list[int]] = {}
    for entry in read_journal(journal):
        done.setdefault(entry["family"], []).append(entry["real"])
    end = time.monotonic() + 60 * minutes
    families = [family for family in canonical_families() if solutions(family) <= most]
    for number in range(10_000):
        for family in families:
            real, total = done.setdefault(family.id, []), solutions(family)
            if len(real) > number or total in real:
                continue
            if time.monotonic() > end:
                return
            attempt = Search(
                kinds_of(family),
                SEED,
                starts=max(4, min(32, effort // (20 * total))),
                steps=max(20, effort // total),
            )
            found = attempt.attempt(number)
            real.append(found.count if found else 0)
            with journal.open("a", encoding="utf-8") as file:
                file.write(json.dumps(_entry(family, number, effort, found)) + "\n")
            sys.stderr.write(f"{family.id}, attempt {number}: {real[-1]} of {total}\n")


def _entry(family: Family, number: int, effort: int, found: Solved | None) -> dict[str, object]:
    entry: dict[str, object] = {"family": family.id, "attempt": number, "effort": effort}
    if found is None:
        return {**entry, "real": 0}
    one = found.platform
    numbers = [part.tolist() for part in (one.y, one.x, one.u, one.v, one.values)]
    return {**entry, "real": found.count, "numbers": numbers}


def read_journal(journal: Path) -> list[dict]:
    """Return the entries of the journal; a last line that was cut off is ignored."""
    if not journal.exists():
        return []
    lines = journal.read_text(encoding="utf-8").split("\n")[:-1]
    return [json.loads(line) for line in lines]


def recorded() -> dict[str, Witness]:
    """Return what is recorded, by the names of the families."""
    path = FOLDER / "real.csv"
    if not path.exists():
        return {}
    rows = csv.DictReader(path.read_text(encoding="utf-8").splitlines())
    return {row["family"]: read_row(row) for row in rows}


def write(journal: Path) -> None:
    """Record the best platforms of the journal that are better than the recorded ones."""
    known = recorded()
    best: dict[str, list[dict]] = {}
    for entry in read_journal(journal):
        best.setdefault(entry["family"], []).append(entry)
    for family in canonical_families():
        entries = sorted(best.get(family.id, []), key=lambda entry: -entry["real"])
        for entry in entries:
            each = multiplier(kinds_of(family))
            least = known[family.id].real if family.id in known else 0
            if each * entry["real"] <= least:
                break
            found = certified(family, entry)
            if found is None:
                sys.stderr.write(f"{family.id}: {entry['real']} cannot be rounded\n")
                continue
            known[family.id] = found
            save(known)
            sys.stderr.write(f"{family.id}: {least} -> {found.real}\n")
            break


def certified(family: Family, entry: dict) -> Witness | None:
    """Return the witness of an entry of the journal, None if it does not survive rounding."""
    kinds = kinds_of(family)
    numbers = Platforms(kinds, *(np.array(part, float) for part in entry["numbers"]))
    real = entry["real"] * multiplier(kinds)
    try:
        instance = real_instance(numbers, real)
    except GspError:
        return None
    if certified_real(instance) != real:
        return None
    return Witness(family, real, tuple(rows_of(instance)))


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
        "command": "python tools/build_witnesses.py search JOURNAL, then write JOURNAL",
        "check": "python tools/build_witnesses.py check",
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
    real = certified_real(instance)
    if real != found.real:
        return f"{name}: {found.real} recorded, {real} certified"
    return f"{name}: {real} recorded, more than the generic count" if real > most else ""


def check(size: int | None, jobs: int) -> int:
    """Certify the recorded platforms again; return the exit code."""
    manifest = json.loads((FOLDER / "manifest.json").read_text(encoding="utf-8"))
    content = (FOLDER / "real.csv").read_bytes()
    problems = []
    if hashlib.sha256(content).hexdigest() != manifest["sha256"]["real.csv"]:
        problems.append("real.csv is not the file of the manifest")
    known = list(recorded().values())
    chosen = sampled(known, size)
    again = in_order(wrong, chosen, jobs)
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
    part = parts.add_parser("check")
    add_sample(part)
    part.add_argument("--jobs", type=int, default=1)
    arguments = parser.parse_args()
    if arguments.part == "search":
        search(arguments.journal, arguments.minutes, arguments.effort, arguments.most)
    elif arguments.part == "write":
        write(arguments.journal)
    else:
        return check(arguments.sample, arguments.jobs)
    return 0


if __name__ == "__main__":
    sys.exit(main())
