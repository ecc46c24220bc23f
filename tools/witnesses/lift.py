"""Lift platforms with many real solutions to types that have them in the limit.

For each family whose solutions are not all known to be real, take the best platforms of its simpler
families (`tools.witnesses.limits`). Go from there to platforms of the family, as long as better
ones are found.
"""

from __future__ import annotations

import numpy as np

from gspcli.catalogue.kinds import DHP, DPH, DPP
from gspcli.catalogue.types import Family
from gspcli.geometry.quaternions import pose_from_study
from gspcli.reality.platforms import Platforms
from gspcli.reality.solved_platforms import Solved
from tools.witnesses.known import Known, canonical_families, kinds_of, quickly_solved, solutions
from tools.witnesses.limits import Limit, limits

#: How far away far points are, in units of the size of the set of places.
_REACHES = tuple(3.0 * 2.5**k for k in range(12))


def lifted(limit: Limit, known: Platforms, wanted: int) -> Solved | None:
    """Return the platform with the most real poses near a simpler one, or one with ``wanted``."""
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


def lift(known: Known, most: int, below: float) -> None:
    """Go through the families until nothing gets better.

    Families with more than `most` solutions are left out, and those of which not less than a share
    `below` is known to be real.
    """
    tried: dict[tuple[str, Limit], int] = {}

    def try_all(family: Family) -> bool:
        before = known.counts.get(family.id, 0)
        for limit in sorted(limits(kinds_of(family)), key=lambda one: -known.count(one.remaining)):
            count, now = known.count(limit.remaining), known.counts.get(family.id, 0)
            is_new = count > max(now, tried.get((family.id, limit), 0))
            if is_new and known.is_open(family, below):
                tried[family.id, limit] = count
                found = lifted(limit, known.platform(limit.remaining), count)
                known.improve(family, found, f", {count} in the limit")
        return known.counts.get(family.id, 0) > before

    # Simpler ones first.
    families = sorted(
        (family for family in canonical_families() if solutions(family) <= most),
        key=lambda family: (solutions(family), _depth(family)),
    )
    while sum(map(try_all, families)):
        pass
