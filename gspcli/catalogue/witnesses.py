"""The best known numbers of real solutions, with the platforms that have them.

They are read from `data/witnesses/`: lower bounds of the largest number of real solutions, each
with a platform, in exact decimals, whose real solutions have been proved to exist. The kinds of
the angles make no difference, and a platform with its bodies exchanged serves the mirrored
family.
"""

from __future__ import annotations

import csv
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
        How many different real solutions it has, with both sides of each DPH and DHP.
    rows
        The numbers of each constraint as decimals: those of the platform's primitive, those of
        the base's (a point; for lines and planes and a direction; for angles the direction
        only), and the distance, or the angle of the directions in degrees.
    """

    family: Family
    real: int
    rows: tuple[tuple[str, ...], ...]

    @property
    def exchanged(self) -> Witness:
        """The same with platform and base exchanged."""
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


def best_real(gsp_type: GspType) -> int | None:
    """Return the largest number of real solutions known for a type; None if none is recorded.

    It counts both sides of each DPH and DHP, as two-sided generic counts do. The largest
    possible number may be larger, up to the generic count.
    """
    found = witness(gsp_type.family)
    return None if found is None else found.real


def witness(family: Family) -> Witness | None:
    """Return the best known platform of a family; None if none is recorded."""
    return recorded().get(family.distances)


@cache
def recorded() -> dict[tuple[Kind, ...], Witness]:
    """Return all recorded witnesses, those with the bodies exchanged included."""
    text = data_path(*FILE).read_text(encoding="utf-8")
    found: dict[tuple[Kind, ...], Witness] = {}
    for row in csv.DictReader(text.splitlines()):
        one = read_row(row)
        found[one.family.distances] = one
        other = mirrored(one.family.distances)
        if other not in found:
            found[other] = one.exchanged
    return found


def read_row(row: dict[str, str]) -> Witness:
    """Return the witness in a row of the file."""
    _, *kinds = row["family"].split()
    distances = tuple(KINDS_BY_NAME["D" + kind] for kind in kinds)
    family = Family(PlatformClass(len(distances), CONSTRAINTS - len(distances)), distances)
    rows = tuple(tuple(numbers.split()) for numbers in row["numbers"].split(";"))
    return Witness(family, int(row["real"]), rows)
