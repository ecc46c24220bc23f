"""Attempts at platforms with many real solutions, for one family after the other.

Each (`gspcli.reality.maximize`) begins at the best platform known or at random ones, in turn. All
go to the journal, so that none is made twice.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from functools import partial
from typing import Any

from gspcli.catalogue.types import Family
from gspcli.defaults import SEED
from gspcli.reality.maximize import Search
from gspcli.reality.platforms import Platforms
from gspcli.workers import Workers
from tools.witnesses.known import (
    Known,
    add_entry,
    canonical_families,
    kinds_of,
    read_journal,
    result,
    simpler_ones,
    solutions,
)

EFFORT = 40_000


def search(known: Known, minutes: float, effort: int, most: int, workers: Workers) -> None:
    """Make attempts until the time is over, or all solutions of all families are real.

    Families with more than `most` solutions are left out, and those to which a platform of a
    simpler family with as many solutions is lifted (`lift.py`).
    """
    families = [
        family
        for family in canonical_families()
        if solutions(family) <= most and not any(simpler_ones(family))
    ]
    done: dict[str, set[int]] = {family.id: set() for family in families}
    for entry in read_journal(known.journal):
        done.setdefault(entry["family"], set()).add(entry.get("attempt", -1))
    end = time.monotonic() + 60 * minutes

    def wanted() -> Iterator[tuple[Family, int, Platforms | None]]:
        for number in range(10_000):
            for family in families:
                count = known.counts.get(family.id, 0)
                if number not in done[family.id] and count < solutions(family):
                    if time.monotonic() > end:
                        return
                    yield family, number, known.platform(kinds_of(family)) if count else None

    for entry in workers.as_completed(partial(attempt, effort=effort), wanted()):
        name, number, real = entry["family"], entry["attempt"], entry["real"]
        before = known.counts.get(name, 0)
        if real <= before:
            entry.pop("numbers", None)
        add_entry(known.journal, entry)
        known.add(name, real, entry)
        sys.stderr.write(f"{name}, attempt {number}: {real}, known {before}\n")


def attempt(which: tuple[Family, int, Platforms | None], effort: int) -> dict[str, Any]:
    """Make an attempt, from the best platform or a random one; return its entry of the journal."""
    family, number, best = which
    kinds, total = kinds_of(family), solutions(family)
    starts, steps = max(4, min(32, effort // (20 * total))), max(20, effort // total)
    search = Search(kinds, SEED, starts=starts, steps=steps)
    found = search.near(best, number).attempt(number)
    entry: dict[str, Any] = {"family": family.id, "attempt": number, "effort": effort, "real": 0}
    if found is not None:
        entry |= result(family, found)
    return entry
