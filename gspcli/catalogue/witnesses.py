"""The largest known numbers of real solutions, with a platform for each.

They are read from `data/witnesses/`: lower bounds of the largest number of real solutions, each
with a platform, in exact decimals, whose real solutions have been proved to exist. The kinds of
the angles make no difference, and a platform with its bodies exchanged serves the mirrored
family.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from gspcli.catalogue.counts import mirrored
from gspcli.catalogue.kinds import KINDS_BY_NAME, Kind, Primitive
from gspcli.catalogue.types import CONSTRAINTS, Family, GspType, PlatformClass
from gspcli.resources import data_path

FILE = ("witnesses", "real.csv")


@dataclass(frozen=True, slots=True)
class Witness:
    """A platform with many real solutions.

    Attributes
    ----------
    family
        The class and the distances.
    real
        The number of different real solutions, with both sides of each DPH and DHP.
    rows
        The numbers of each constraint as decimals: those of the platform's primitive, those of
        the base's, and the distance, or the angle of the directions in degrees. A point has its
        coordinates, a line or plane a point and a direction, and in an angle only the direction.
    """

    family: Family
    real: int
    rows: tuple[tuple[str, ...], ...]

    @property
    def exchanged(self) -> Witness:
        """The witness with platform and base exchanged."""
        kinds = self.family.distances
        distances = mirrored(kinds)
        rows = []
        for kind, row in zip(kinds, self.rows, strict=False):
            cut = 3 if kind.platform is Primitive.POINT else 6
            rows.append((kind.mirrored, (*row[cut:-1], *row[:cut], row[-1])))
        rows.sort(key=lambda pair: pair[0])
        turned = [(*row[3:6], *row[:3], row[6]) for row in self.rows[len(kinds) :]]
        return Witness(
            Family(self.family.platform_class, distances),
            self.real,
            (*(row for _, row in rows), *turned),
        )


def best_real(subject: GspType | Family) -> int | None:
    """Return the largest number of real solutions known for a type; None if none is recorded.

    It counts both sides of each DPH and DHP, as two-sided generic counts do. The largest
    possible number may be larger, up to the generic count.
    """
    row = _row(subject.distances)
    return None if row is None else int(row["real"])


def witness(family: Family) -> Witness | None:
    """Return the best known platform of a family; None if none is recorded."""
    row = _row(family.distances)
    if row is None:
        return None
    found = read_row(row)
    return found if found.family == family else found.exchanged


def recorded() -> Iterator[Witness]:
    """Yield the recorded witnesses, one for each two mirrored families."""
    return map(read_row, _rows().values())


def _row(distances: tuple[Kind, ...]) -> dict[str, str] | None:
    rows = _rows()
    return rows.get(_name(distances)) or rows.get(_name(mirrored(distances)))


def _name(distances: tuple[Kind, ...]) -> str:
    return " ".join(kind.short for kind in distances)


@cache
def _rows() -> dict[str, dict[str, str]]:
    """Return the rows of the file by the distances."""
    text = data_path(*FILE).read_text(encoding="utf-8")
    rows = csv.DictReader(text.splitlines())
    return {row["family"].partition(" ")[2]: row for row in rows}


def named_family(distances: str) -> Family:
    """Return the family with distances in short, as ``PP PL LL``."""
    kinds = tuple(KINDS_BY_NAME["D" + kind] for kind in distances.split())
    return Family(PlatformClass(len(kinds), CONSTRAINTS - len(kinds)), kinds)


def read_row(row: dict[str, str]) -> Witness:
    """Return the witness in a row of the file."""
    family = named_family(row["family"].partition(" ")[2])
    rows = tuple(tuple(numbers.split()) for numbers in row["numbers"].split(";"))
    return Witness(family, int(row["real"]), rows)
