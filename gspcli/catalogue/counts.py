"""Generic counts: how many complex solutions almost every platform of a type has.

They follow from two theorems (docs/counts.md): `law` computes them. `data/counts/` is the
atlas's record of them, with how each was confirmed by counting the solutions of random platforms.
The kinds of the angles make no difference, so there are as many counts as families: 896.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cache

from gspcli.catalogue.intersection_numbers import intersection_number
from gspcli.catalogue.kinds import Kind
from gspcli.catalogue.types import CLASSES, CONSTRAINTS, Family, GspType, PlatformClass, families
from gspcli.errors import DataError
from gspcli.resources import data_path

FOLDER = "counts"
FAMILIES_FILE = "families.csv"
NUMBERS_FILE = "intersection-numbers.csv"
#: The spaces of quadrics in Study coordinates, in their canonical order.
LETTERS = "apqls"


class Method(Enum):
    """The way in which a generic count was confirmed."""

    GROEBNER = "groebner"
    TRACKING = "tracking"
    TRACE = "trace"

    @property
    def meaning(self) -> str:
        """The method in a phrase."""
        return _MEANINGS[self]


_MEANINGS = {
    Method.GROEBNER: "Gröbner bases of random platforms modulo two primes",
    Method.TRACKING: "as many poses of a random real platform proved to be different",
    Method.TRACE: "a trace test of these poses that one less would not pass",
}


@dataclass(frozen=True, slots=True)
class GenericCounts:
    """The generic counts of a type.

    Attributes
    ----------
    one_sided, two_sided
        Number of complex solutions with the side of each DPH and DHP chosen, or left open.
    confirmed
        The methods that gave the same number for random platforms of the family.
    """

    one_sided: int
    two_sided: int
    confirmed: tuple[Method, ...]

    @property
    def established(self) -> str:
        """The proof and the confirmations of the counts, in a sentence."""
        proved = "proved (docs/counts.md)"
        phrases = "; ".join(method.meaning for method in self.confirmed)
        return f"{proved}, and confirmed by {phrases}" if phrases else proved

    def of(self, *, sides: int) -> int:
        """Return the one-sided count for 1, the two-sided one for 2."""
        return self.one_sided if sides == 1 else self.two_sided


def letters(distances: tuple[Kind, ...]) -> str:
    """Return the spaces of the six quadrics or products, in canonical order.

    >>> from gspcli.catalogue.kinds import DLL, DLP, DPL, DPP
    >>> letters((DPP, DPL, DLP, DLL))
    'aapqls'
    """
    chosen = "".join(sorted((kind.space for kind in distances), key=LETTERS.index))
    return "a" * (CONSTRAINTS - len(distances)) + chosen


def mirrored(distances: tuple[Kind, ...]) -> tuple[Kind, ...]:
    """Return the distances with platform and base exchanged, in canonical order."""
    return tuple(sorted(kind.mirrored for kind in distances))


def law(distances: tuple[Kind, ...]) -> int:
    """Return the one-sided count by its proof: a factor 2 for each product of quadrics.

    >>> from gspcli.catalogue.kinds import DLP, DPL
    >>> law((DPL, DPL, DLP))
    64
    """
    products = sum(kind.is_product for kind in distances)
    return int(2**products * intersection_number(letters(distances)))


def generic_counts(gsp_type: GspType) -> GenericCounts:
    """Return the generic counts of a type; the kinds of its angles make no difference."""
    return _recorded()[gsp_type.distances]


def family_counts(family: Family) -> GenericCounts:
    """Return the generic counts that all types of a family share."""
    return _recorded()[family.distances]


def family_of(distances: tuple[Kind, ...]) -> Family:
    """Return the family with the given distances, in canonical order."""
    angles = CONSTRAINTS - len(distances)
    return Family(PlatformClass(len(distances), angles), distances)


def all_families() -> Iterator[Family]:
    """Yield the 896 families in catalogue order."""
    for platform_class in CLASSES:
        yield from families(platform_class)


@cache
def _recorded() -> dict[tuple[Kind, ...], GenericCounts]:
    rows = {row["family"]: row for row in _rows(FAMILIES_FILE)}
    try:
        return {
            family.distances: GenericCounts(
                int(row["one_sided"]),
                int(row["two_sided"]),
                tuple(map(Method, row["confirmed"].split("+") if row["confirmed"] else [])),
            )
            for family in all_families()
            for row in [rows[family.id]]
        }
    except KeyError as error:
        message = f"{FOLDER}/{FAMILIES_FILE} has no row for {error.args[0]}"
        raise DataError(message) from error


def _rows(name: str) -> list[dict[str, str]]:
    text = data_path(FOLDER, name).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))
