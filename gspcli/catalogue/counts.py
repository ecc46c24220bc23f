"""Generic counts: how many complex solutions almost every platform of a type has.

They are read from `data/counts/`, where the atlas records them with how each was established.
The kinds of the angles make no difference, so there are as many counts as families: 896.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cache
from math import comb

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.catalogue.types import CLASSES, CONSTRAINTS, Family, GspType, PlatformClass, families
from gspcli.errors import DataError
from gspcli.resources import data_path

FOLDER = "counts"
FAMILIES_FILE = "families.csv"
NUMBERS_FILE = "intersection-numbers.csv"
#: The families of quadrics in Study coordinates, in their canonical order.
LETTERS = "apqls"
#: The family of each kind of distance; the angles are of family a.
LETTER: dict[Kind, str] = {DPP: "s", DPL: "p", DLP: "q", DPH: "p", DHP: "q", DLL: "l"}
#: The kinds that are products of two quadrics of their family.
PRODUCTS = frozenset({DPL, DLP, DLL})


class Method(Enum):
    """How a generic count was established."""

    BOTH = "groebner+tracking"
    GROEBNER = "groebner"
    TRACKING = "tracking"
    LAW = "law"

    @property
    def meaning(self) -> str:
        """The method in a sentence."""
        return _MEANINGS[self]


_MEANINGS = {
    Method.BOTH: "Gröbner bases of random platforms modulo two primes, and as many poses of a "
    "random real platform proved to be different",
    Method.GROEBNER: "Gröbner bases of random platforms modulo two primes",
    Method.TRACKING: "so many poses of a random real platform proved to be different; no more by "
    "the law for products",
    Method.LAW: "not established for the platforms themselves, only by the law for products",
}


@dataclass(frozen=True, slots=True)
class Counts:
    """The generic counts of a type.

    Attributes
    ----------
    one_sided, two_sided
        Number of complex solutions with the side of each DPH and DHP chosen, or left open.
    established
        How.
    """

    one_sided: int
    two_sided: int
    established: Method

    def of(self, *, sides: int) -> int:
        """Return the one-sided count for 1, the two-sided one for 2."""
        return self.one_sided if sides == 1 else self.two_sided


def letters(distances: tuple[Kind, ...]) -> str:
    """Return the families of the six quadrics or products, in canonical order.

    >>> letters((DPP, DPL, DLP, DLL))
    'aapqls'
    """
    chosen = "".join(sorted((LETTER[kind] for kind in distances), key=LETTERS.index))
    return "a" * (CONSTRAINTS - len(distances)) + chosen


def mirrored(distances: tuple[Kind, ...]) -> tuple[Kind, ...]:
    """Return the distances with platform and base exchanged, in canonical order."""
    return tuple(sorted(kind.mirrored for kind in distances))


def swapped(families_of_quadrics: str) -> str:
    """Return the families after exchanging platform and base: p and q change places."""
    exchanged = families_of_quadrics.translate(str.maketrans("pq", "qp"))
    return "".join(sorted(exchanged, key=LETTERS.index))


def canonical(families_of_quadrics: str) -> str:
    """Return the families or what they are after the exchange, whichever has more p."""
    if families_of_quadrics.count("p") >= families_of_quadrics.count("q"):
        return families_of_quadrics
    return swapped(families_of_quadrics)


@cache
def intersection_numbers() -> dict[str, int]:
    """Return the 119 recorded intersection numbers by their families, such as ``appqls``."""
    return {row["families"]: int(row["number"]) for row in _rows(NUMBERS_FILE)}


def law(distances: tuple[Kind, ...]) -> int:
    """Return the one-sided count by the law: a factor 2 for each product of quadrics.

    >>> law((DPL, DPL, DLP))
    64
    """
    products = sum(kind in PRODUCTS for kind in distances)
    return int(2**products * intersection_numbers()[canonical(letters(distances))])


def study_bound(distances: tuple[Kind, ...]) -> int:
    """Return a proved ceiling for the one-sided count, often the count itself.

    It is an intersection number on a smooth compactification of the rigid motions in Study
    coordinates, on which angles are of class 2h, other constraints of class x, products 2x and
    one DPP 2x - 2h; the other DPP lose their quadratic term to the first. The powers h^k x^(6-k)
    are 64, 22, 6, 1. The proof is in docs/counts.md.

    >>> study_bound((DLL,) * 6) == 2**6 * 64
    True
    """
    angles = CONSTRAINTS - len(distances)
    products = sum(kind in PRODUCTS for kind in distances)
    power = 2 * (_power(angles) - _power(angles + 1)) if DPP in distances else _power(angles)
    return int(2 ** (angles + products) * power)


def _power(h: int) -> int:
    """Return the coefficient of t^(3-h) in 1 / ((1 - t)^4 (1 - 2t))."""
    return sum(comb(k + 3, 3) * 2 ** (3 - h - k) for k in range(4 - h))


def generic_counts(gsp_type: GspType) -> Counts:
    """Return the generic counts of a type; the kinds of its angles make no difference."""
    return _recorded()[gsp_type.distances]


def family_counts(family: Family) -> Counts:
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
def _recorded() -> dict[tuple[Kind, ...], Counts]:
    rows = {row["family"]: row for row in _rows(FAMILIES_FILE)}
    try:
        return {
            family.distances: Counts(
                int(row["one_sided"]), int(row["two_sided"]), Method(row["method"])
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
