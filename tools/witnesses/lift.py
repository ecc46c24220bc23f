"""Lift platforms with many real solutions to types that have them in the limit.

    python -m tools.witnesses.lift JOURNAL [--most SOLUTIONS] [--below SHARE]

For each family whose solutions are not all known to be real: take the best platforms of its simpler
families (`gspcli.reality.limits`), on record or in the journal, and go from there to platforms of
the family, as long as that finds better ones. The results go to the journal of
`python -m tools.witnesses`, whose part `write` rounds and certifies them.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from gspcli.catalogue.kinds import DHP, DPH, DPP
from gspcli.catalogue.types import Family
from gspcli.geometry.quaternions import pose_from_study
from gspcli.reality.limits import Limit, limits
from gspcli.reality.platforms import Platforms
from gspcli.reality.solved_platforms import Solved, quickly_solved
from tools.witnesses.known import Known, add_entry, canonical_families, kinds_of, result, solutions

#: How far away far points are, in units of the size of the set of places.
_REACHES = tuple(3.0 * 2.5**k for k in range(12))


def lifted(limit: Limit, known: Platforms, wanted: int) -> Solved | None:
    """Return the best platform near a simpler one; the first with as many as are wanted."""
    simple = quickly_solved(known)
    if simple is None:
        return None
    R, T = pose_from_study(simple.points[simple.real, :4], simple.points[simple.real, 4:])
    U = -np.einsum("nji,nj->ni", R, T)
    there, back = (np.median(places.real, axis=0) for places in (T, U))
    spread = float(np.median(np.abs(T.real - there)) + np.median(np.abs(known.y)))
    best: Solved | None = None
    for reach in _REACHES:
        far = float(f"{reach * spread:.1g}")
        found = quickly_solved(limit.lifted(known, there, back, far))
        if found is not None and (best is None or found.count > best.count):
            best = found
        if best is not None and best.count >= wanted:
            break
    return best


def _depth(family: Family) -> int:
    """Return how many times one constraint after the other may become simpler."""
    return sum({DPP: 2, DPH: 1, DHP: 1}.get(kind, 0) for kind in family.distances)


def lift(journal: Path, most: int, below: float) -> None:
    """Go through the families until nothing gets better.

    Families with more than `most` solutions are left out, and those of which not less than a share
    `below` is known to be real.
    """
    known = Known(journal)
    tried: dict[tuple[str, Limit], int] = {}

    def try_all(family: Family) -> bool:
        kinds, total = kinds_of(family), solutions(family)
        now = before = known.counts.get(family.id, 0)
        for limit in sorted(limits(kinds), key=lambda one: -known.count(one.remaining)):
            count = known.count(limit.remaining)
            if now >= below * total or count <= max(now, tried.get((family.id, limit), 0)):
                continue
            tried[family.id, limit] = count
            found = lifted(limit, known.platform(limit.remaining), count)
            real = 0 if found is None else found.count
            sys.stderr.write(f"{family.id}: {now} -> {real} of {total}, {count} in the limit\n")
            if found is not None and real > now:
                now, entry = real, result(family, found)
                add_entry(journal, entry)
                known.add(family.id, real, entry)
        return now > before

    # Simpler ones first.
    families = sorted(
        (family for family in canonical_families() if solutions(family) <= most),
        key=lambda family: (solutions(family), _depth(family)),
    )
    while sum(map(try_all, families)):
        pass


def main() -> int:
    """Lift."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("journal", type=Path)
    parser.add_argument("--most", type=int, default=10_000)
    parser.add_argument("--below", type=float, default=1.0)
    arguments = parser.parse_args()
    lift(arguments.journal, arguments.most, arguments.below)
    return 0


if __name__ == "__main__":
    sys.exit(main())
