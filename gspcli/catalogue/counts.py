"""Generic counts: how many complex solutions almost every platform of a type has.

They follow from two theorems (docs/counts.md): `law` of `tools.atlas.intersection_numbers` computes
them.
`data/counts/` is the atlas's record of them, with how each was confirmed by counting the solutions
of random platforms.
The kinds of the angles make no difference, so there are as many counts as families: 896.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from functools import cache
from itertools import groupby
from random import Random

from gspcli.catalogue.kinds import KINDS_BY_NAME, Kind, Primitive
from gspcli.catalogue.types import CLASSES, CONSTRAINTS, Family, GspType, PlatformClass, families
from gspcli.errors import DataError, GspError
from gspcli.resources import data_path

FOLDER = "counts"
FAMILIES_FILE = "families.csv"


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
    """The generic counts of a type."""

    #: Number of complex solutions with the side of each DPH and DHP chosen, or left open.
    one_sided: int
    two_sided: int
    #: The methods that gave the same number for random platforms of the family.
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


def mirrored(distances: tuple[Kind, ...]) -> tuple[Kind, ...]:
    """Return the distances with platform and base exchanged, in canonical order."""
    return tuple(sorted(kind.mirrored for kind in distances))


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
        raise DataError(f"{FOLDER}/{FAMILIES_FILE} has no row for {error.args[0]}") from error


def _rows(name: str) -> list[dict[str, str]]:
    text = data_path(FOLDER, name).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


FILE = ("witnesses", "real.csv")


@dataclass(frozen=True, slots=True)
class Witness:
    """A platform with many real solutions."""

    #: The class and the distances.
    family: Family
    #: The number of different real solutions, with both sides of each DPH and DHP.
    real: int
    #: The numbers of each constraint as decimals: those of the platform's primitive, those of the
    #: base's, and the distance, or the angle of the directions in degrees. A point has its
    #: coordinates, a line or plane a point and a direction, and in an angle only the direction.
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
    return map(read_row, _witness_rows().values())


def _row(distances: tuple[Kind, ...]) -> dict[str, str] | None:
    rows = _witness_rows()
    return rows.get(_name(distances)) or rows.get(_name(mirrored(distances)))


def _name(distances: tuple[Kind, ...]) -> str:
    return " ".join(kind.short for kind in distances)


@cache
def _witness_rows() -> dict[str, dict[str, str]]:
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


REAL_COUNTS_FILE = ("witnesses", "counts.csv")
#: Random numbers are hundredths; distances up to this, angles in whole degrees.
_LONGEST = 200


@dataclass(frozen=True, slots=True, order=True)
class PlaceOnLine:
    """The place of a platform on a line between two platforms of a type."""

    #: The number of different real solutions, with both sides of each DPH and DHP.
    real: int
    #: The number of the random platform at the beginning of the line.
    number: int
    #: The share of the line before the platform: a decimal between 0 and 1.
    share: str

    def __str__(self) -> str:
        return f"{self.real}:{self.number}:{self.share}"

    @classmethod
    def read(cls, text: str) -> PlaceOnLine:
        """Return the place that `str` wrote."""
        real, number, share = text.split(":")
        return cls(int(real), int(number), share)


def real_counts(subject: GspType | Family) -> tuple[int, ...]:
    """Return the numbers of real solutions with a recorded platform, in ascending order.

    Each has a platform whose real solutions are proved to exist and to be different. As for the
    largest number (`best_real`), both sides of each DPH and DHP count, and others may occur.
    """
    own, other = _name(subject.distances), _name(mirrored(subject.distances))
    best = witness(Family(subject.platform_class, subject.distances))
    numbers = {place.real for place in _real_rows().get(own) or _real_rows().get(other) or ()}
    return tuple(sorted(numbers | ({best.real} if best is not None else set())))


def spelled(counts: tuple[int, ...]) -> str:
    """Return even numbers as text, ``0..40 48`` for 0, 2, 4, … 40 and 48."""
    parts: list[str] = []
    for _, run in groupby(enumerate(counts), lambda pair: pair[1] - 2 * pair[0]):
        first, *others = (count for _, count in run)
        parts += [f"{first}..{others[-1]}"] if len(others) > 1 else map(str, [first, *others])
    return " ".join(parts)


def witness_with(family: Family, real: int) -> Witness:
    """Return the recorded platform of a family with a number of real solutions.

    Raises
    ------
    GspError
        If no platform with this many is recorded.
    """
    best = witness(family)
    if best is not None and best.real == real:
        return best
    for name in dict.fromkeys((family.distances, mirrored(family.distances))):
        for place in _real_rows().get(_name(name), ()):
            if place.real == real:
                found = platform_at(Family(family.platform_class, name), place)
                return found if name == family.distances else found.exchanged
    raise GspError(
        f"{family.id}: no platform with {real} real poses is recorded:"
        f" there are some with {spelled(real_counts(family)) or 'none'}"
    )


def recorded_real_counts() -> Iterator[tuple[Family, tuple[PlaceOnLine, ...]]]:
    """Yield the records, one for each two mirrored families."""
    for name, places in _real_rows().items():
        yield named_family(name), places


def platform_at(family: Family, place: PlaceOnLine) -> Witness:
    """Return the platform at a place of a family that has a witness."""
    best = witness(family)
    if best is None:
        raise ValueError(family)
    share = Fraction(place.share)
    rows = []
    for start, end in zip(random_rows(family, place.number), best.rows, strict=True):
        numbers = ((1 - share) * a + share * Fraction(b) for a, b in zip(start, end, strict=True))
        rows.append(tuple(map(_decimal, numbers)))
    return Witness(family, place.real, tuple(rows))


def random_rows(family: Family, number: int) -> list[list[Fraction]]:
    """Return random numbers of a platform, in the order of `Witness.rows`.

    They depend on the family and the number only.
    """
    rng = Random(f"{family.id} {number}")
    rows = []
    for kind in family.distances:
        points = sum(_size(primitive) for primitive in (kind.platform, kind.base))
        row = [rng.randint(-100, 100) for _ in range(points)]
        rows.append([Fraction(n, 100) for n in (*row, rng.randint(1, _LONGEST))])
    for _ in range(family.platform_class.angles):
        row = [rng.randint(-100, 100) for _ in range(6)]
        rows.append([*(Fraction(n, 100) for n in row), Fraction(rng.randint(1, 179))])
    return rows


def _size(primitive: Primitive) -> int:
    return 3 if primitive is Primitive.POINT else 6


def _decimal(value: Fraction) -> str:
    """Return a fraction with a power of ten below as a decimal."""
    digits = 0
    while (value * 10**digits).denominator > 1:
        digits += 1
    whole = abs(value.numerator * 10**digits // value.denominator)
    text = str(whole).rjust(digits + 1, "0")
    head, tail = (text[:-digits], text[-digits:]) if digits else (text, "")
    return f"{'-' if value < 0 else ''}{head}{'.' + tail if tail else ''}"


@cache
def _real_rows() -> dict[str, tuple[PlaceOnLine, ...]]:
    """Return the places by the distances."""
    text = data_path(*REAL_COUNTS_FILE).read_text(encoding="utf-8")
    return {
        row["family"].partition(" ")[2]: tuple(map(PlaceOnLine.read, row["platforms"].split()))
        for row in csv.DictReader(text.splitlines())
    }
