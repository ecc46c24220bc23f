"""Table 3: the maximal number of one-sided solutions of the 3D3A platforms (page 80)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from gspcli.catalogue.bounds import family_bounds
from gspcli.catalogue.constraints import constraint_facts
from gspcli.catalogue.kinds import KINDS_BY_NAME, Kind
from gspcli.catalogue.types import CLASSES, Family, families
from gspcli.paper.printed import Difference
from gspcli.records import dataclass
from gspcli.resources import data_json

Triple = tuple[Kind, Kind, Kind]


@dataclass(frozen=True, order=True)
class Entry:
    """One column of the table: a family of twenty types.

    Attributes
    ----------
    n1
        The maximal number of one-sided solutions.
    surfaces
        The three surfaces that meet, in the order P, S, C.
    distances
        The three distance kinds in canonical order.
    """

    n1: int
    surfaces: str
    distances: Triple

    @property
    def family(self) -> Family:
        """The family of the entry."""
        return Family(CLASSES[0], self.distances)

    def __str__(self) -> str:
        return " ".join(kind.short for kind in self.distances)


def compute() -> list[Entry]:
    """Return the table recomputed: all 56 triples of distance kinds, in catalogue order."""
    entries = []
    for family in families(CLASSES[0]):
        bound = family_bounds(family).table_3
        assert bound is not None, "every 3D3A family has an entry in Table 3"
        first, second, third = family.distances
        entries.append(Entry(bound.value, surfaces(family), (first, second, third)))
    return entries


def surfaces(family: Family) -> str:
    """Return the three surfaces under a fixed orientation, such as ``PSC`` (Proposition 6.4)."""
    letters = [constraint_facts(kind).surface or "" for kind in family.distances]
    return "".join(sorted(letters, key="PSC".index))


def printed() -> list[Entry]:
    """Return the table as printed, column by column."""
    return [
        Entry(group["n1"], group["surfaces"], _triple(column))
        for group in data_json("paper", "table3.json")["groups"]
        for column in zip(*(row.split() for row in group["rows"]), strict=True)
    ]


def _triple(names: tuple[str, ...]) -> Triple:
    first, second, third = sorted(KINDS_BY_NAME["D" + name] for name in names)
    return (first, second, third)


def differences() -> Iterator[Difference]:
    """Yield the wrong columns of the print, each with the column that is missing in its place."""
    ours, theirs = Counter(compute()), Counter(printed())
    missing = sorted((ours - theirs).elements())
    for wrong in sorted((theirs - ours).elements()):
        absent = next((e for e in missing if e.surfaces == wrong.surfaces), None)
        if absent is not None:
            missing.remove(absent)
        yield Difference(
            3, f"case {wrong.surfaces}", f"N1 = {wrong.n1}", str(wrong), str(absent or "no entry")
        )
    for absent in missing:
        yield Difference(3, f"case {absent.surfaces}", f"N1 = {absent.n1}", "no entry", str(absent))
