"""The best platforms of the families, on record in `data/witnesses/` or in a journal.

A journal is a work file of the ways to look for witnesses: a line of JSON for each reduced
platform that was found, with its family, its number of real solutions and its numbers.
"""

from __future__ import annotations

import csv
import json
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gspcli.catalogue.counts import (
    Witness,
    all_families,
    family_counts,
    mirrored,
    named_family,
    read_row,
)
from gspcli.catalogue.kinds import ALL, DHP, DLL, DPH, Kind
from gspcli.catalogue.types import CONSTRAINTS, Family
from gspcli.continuation.tracked_paths import track_all
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.reality.platforms import Platforms, multiplier
from gspcli.reality.recognition import look_real
from gspcli.reality.solved_platforms import Solved
from gspcli.reality.witness_proofs import witness_instance
from tools.witnesses.limits import limits
from tools.witnesses.record import FOLDER, Record

REAL = Record(FOLDER / "real.csv", FOLDER / "manifest.json", ("family", "real", "numbers"))
#: The part of the solutions that the first attempt must find.
_SETTLED = 0.4


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


def simpler_ones(family: Family) -> Iterator[Family]:
    """Yield the families in which one constraint is simpler, with as many solutions."""
    for limit in limits(kinds_of(family)):
        distances = sorted(kind for kind in limit.remaining if kind.is_distance)
        simpler = named_family(" ".join(kind.short for kind in distances))
        if solutions(simpler) == solutions(family):
            yield simpler


def by_dependents() -> list[Family]:
    """Return one of each two mirrored families, those first to which most others lead back.

    Families that have simpler ones with as many solutions are left out.
    """
    families = canonical_families()
    own = {one.distances: one for one in families}
    own |= {mirrored(one.distances): one for one in families}
    roots: dict[Family, set[Family]] = {}

    def of(family: Family) -> set[Family]:
        if family not in roots:
            simpler = [own[one.distances] for one in simpler_ones(family)]
            roots[family] = set().union(*map(of, simpler)) if simpler else {family}
        return roots[family]

    counts = Counter(root for family in families for root in of(family))
    return sorted(counts, key=lambda family: -counts[family])


def recorded() -> dict[str, Witness]:
    """Return what is recorded, by the names of the families."""
    if not REAL.file.exists():
        return {}
    rows = csv.DictReader(REAL.file.read_text(encoding="utf-8").splitlines())
    return {row["family"]: read_row(row) for row in rows}


def result(family: Family, found: Solved) -> dict[str, Any]:
    """Return the entry of the journal for a reduced platform of a family."""
    numbers = numbers_of(found.platform)
    return {"family": family.id, "real": found.count, "numbers": numbers}


def numbers_of(one: Platforms) -> list[Any]:
    """Return the numbers of a platform as a journal has them."""
    return [part.tolist() for part in (one.y, one.x, one.u, one.v, one.values)]


def add_entry(journal: Path, entry: dict[str, Any]) -> None:
    """Append an entry to the journal."""
    with journal.open("a", encoding="utf-8") as file:
        file.write(json.dumps(entry) + "\n")


def read_journal(journal: Path) -> list[dict[str, Any]]:
    """Return the entries of the journal; a last line that was cut off is ignored."""
    if not journal.exists():
        return []
    lines = journal.read_text(encoding="utf-8").split("\n")[:-1]
    return [json.loads(line) for line in lines]


def reduced_platform(found: Witness) -> Platforms:
    """Return the numbers of a recorded witness, its distances of planes and lines made zero."""
    angles = (ALL,) * (CONSTRAINTS - len(found.family.distances))
    given = Arrangement.of(witness_instance(found, angles))
    values = given.values.copy()
    values[[kind in (DPH, DHP, DLL) for kind in given.kinds]] = 0.0
    values[~np.array([kind.is_distance for kind in given.kinds])] = given.cosines(given.values)
    return Platforms(given.kinds, given.y, given.x, given.u, given.v, values)


class Known:
    """The best reduced platforms by their families, on record or in a journal."""

    def __init__(self, journal: Path) -> None:
        self.journal = journal
        self.counts: dict[str, int] = {}
        self._sources: dict[str, Witness | dict[str, Any]] = {}
        for name, found in recorded().items():
            self.add(name, found.real // multiplier(kinds_of(found.family)), found)
        for entry in read_journal(journal):
            self.add(entry["family"], entry["real"], entry)

    def add(self, name: str, count: int, source: Witness | dict[str, Any]) -> None:
        """Keep a platform if it is the best of its family."""
        if count > self.counts.get(name, 0):
            self.counts[name], self._sources[name] = count, source

    def improve(self, family: Family, found: Solved | None, remark: str = "") -> None:
        """Say what was found for a family; keep it, also in the journal, if it is better."""
        now, real = self.counts.get(family.id, 0), 0 if found is None else found.count
        sys.stderr.write(f"{family.id}: {now} -> {real} of {solutions(family)}{remark}\n")
        if found is not None and real > now:
            entry = result(family, found)
            add_entry(self.journal, entry)
            self.add(family.id, real, entry)

    def is_open(self, family: Family, below: float) -> bool:
        """Return whether less than a share of the solutions of a family is known to be real."""
        return self.counts.get(family.id, 0) < below * solutions(family)

    def count(self, kinds: tuple[Kind, ...]) -> int:
        """Return the most real solutions known of constraints of kinds in any order."""
        return self.counts.get(self._place(kinds)[0], 0)

    def platform(self, kinds: tuple[Kind, ...]) -> Platforms:
        """Return the best platform of constraints of kinds in any order."""
        name, is_exchanged = self._place(kinds)
        source = self._sources[name]
        if isinstance(source, Witness):
            platform = reduced_platform(source)
        else:
            numbers = (np.array(part, float) for part in source["numbers"])
            platform = Platforms(kinds_of(named_family(name.partition(" ")[2])), *numbers)
        if is_exchanged:
            platform = platform.exchanged
        # Alike constraints in their order: both orders, of the kinds sorted.
        own = sorted(range(CONSTRAINTS), key=lambda i: platform.kinds[i])
        theirs = sorted(range(CONSTRAINTS), key=lambda i: kinds[i])
        return platform.permuted([own[theirs.index(i)] for i in range(CONSTRAINTS)])

    def _place(self, kinds: tuple[Kind, ...]) -> tuple[str, bool]:
        """Return the name of the family on record, and whether its bodies are exchanged."""
        for exchanged in (False, True):
            distances = sorted(
                kind.mirrored if exchanged else kind for kind in kinds if kind.is_distance
            )
            name = named_family(" ".join(kind.short for kind in distances)).id
            if name in self.counts:
                return name, exchanged
        return "", False


def quickly_solved(platform: Platforms) -> Solved | None:
    """Return a platform with the solutions of a first attempt at all paths; None if most are lost.

    Solutions that are probably real count as real, without a check. A search begins with this.
    """
    system = next(platform[None].systems())
    (tracked_paths,) = track_all([system], seed=SEED)
    ends = tracked_paths.first()
    if ends.converged.mean() < _SETTLED:
        return None
    points = ends.points[ends.converged]
    real = look_real(points)
    size = np.sqrt((points[:, :4] ** 2).sum(axis=-1, keepdims=True))
    return Solved(platform, system, points / np.where(size, size, 1.0), real)
