"""The best platforms on record, `data/witnesses/real.csv`: rounded, certified, checked."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from gspcli.catalogue.counts import Witness, all_families, family_counts
from gspcli.catalogue.kinds import ALL
from gspcli.catalogue.types import CONSTRAINTS, Family
from gspcli.defaults import SEED
from gspcli.errors import GspError
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane
from gspcli.reality.platforms import Platforms, multiplier
from gspcli.reality.witness_proofs import (
    certified_real,
    quickly_certified_real,
    real_instance,
    rounded,
    with_gap,
    witness_instance,
)
from gspcli.workers import Workers
from tools.witnesses.known import REAL, canonical_families, kinds_of, read_journal, recorded

#: Decimals, and the distance of planes and of lines, where many decimals lose real poses.
_PLACES, _GAP = 10, Fraction(1, 1000)


def write(journal: Path) -> None:
    """Record the best platforms of the journal that are better than the recorded ones."""
    known = recorded()
    best: dict[str, list[dict[str, Any]]] = {}
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


def _worth(entry: dict[str, Any]) -> tuple[int, float]:
    """Sort entries of the journal: many real solutions first, then small platforms."""
    numbers = np.abs(np.concatenate([np.ravel(part) for part in entry.get("numbers", [0.0])]))
    return -entry["real"], float(numbers.max())


def certified(family: Family, entry: dict[str, Any]) -> Witness:
    """Return a witness from an entry of the journal; rounding may cost it real solutions.

    Where not all could be certified it has this many fewer that their number can be right.
    """
    kinds = kinds_of(family)
    numbers = Platforms(kinds, *(np.array(part, float) for part in entry["numbers"]))
    wanted = entry["real"] * multiplier(kinds)
    try:
        instance = real_instance(numbers, wanted)
        real = certified_real(instance, wanted)
    except GspError:
        instance = with_gap(rounded(numbers, _PLACES), _GAP)
        real = quickly_certified_real(instance, wanted)
    sides = 2 ** sum(kind.has_sides for kind in kinds)
    return Witness(family, real - real % max(2, sides), tuple(rows_of(instance)))


def witness_text(found: Witness) -> str:
    """Return the numbers of a witness as `read_row` reads them."""
    return ";".join(" ".join(row) for row in found.rows)


def rows_of(instance: Instance) -> Iterator[tuple[str, ...]]:
    """Yield the numbers of each constraint as `Witness.rows` has them; all angles are ALL."""
    for constraint in instance.constraints:
        numbers: list[Number] = []
        for geometry in (constraint.platform, constraint.base):
            if constraint.kind.is_distance:
                numbers += geometry.position
            if isinstance(geometry, Line):
                numbers += geometry.direction
            elif isinstance(geometry, Plane):
                numbers += geometry.normal
        yield tuple(map(str, [*numbers, constraint.value]))


def save(known: dict[str, Witness]) -> None:
    """Write the records and their manifest."""
    families = [family for family in all_families() if family.id in known]
    REAL.write(
        [(f.id, known[f.id].real, witness_text(known[f.id])) for f in families],
        {
            "what": "platforms with many real solutions: lower bounds of the largest possible"
            " number",
            "command": "python -m tools.witnesses search JOURNAL, then write JOURNAL",
            "check": "python -m tools.witnesses check",
            "seed": SEED,
            "families": len(families),
            "all_solutions_real": sum(
                known[f.id].real == family_counts(f).two_sided for f in families
            ),
        },
    )


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

    def said(chosen: list[Witness]) -> str:
        return f"witnesses, {sum(found.real for found in chosen)} real poses certified"

    return REAL.check(wrong, list(recorded().values()), size, workers, said=said)
