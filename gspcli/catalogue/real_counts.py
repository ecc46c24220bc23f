"""The numbers of real solutions that occur, each with a platform that has it.

The platforms lie on a straight line between two platforms: one with random numbers, which can be
drawn again from their seed, and the best witness of the family (`gspcli.catalogue.witnesses`). A
platform is recorded by its place on this line.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import groupby
from random import Random

from gspcli.catalogue.counts import mirrored
from gspcli.catalogue.kinds import Kind, Primitive
from gspcli.catalogue.types import Family, GspType
from gspcli.catalogue.witnesses import Witness, named_family, witness
from gspcli.errors import GspError
from gspcli.resources import data_path

FILE = ("witnesses", "counts.csv")
#: Random numbers are hundredths; distances up to this, angles in whole degrees.
_LONGEST = 200


@dataclass(frozen=True, slots=True, order=True)
class PlaceOnLine:
    """The place of a platform on a line between two platforms of a type.

    Attributes
    ----------
    real
        The number of different real solutions, with both sides of each DPH and DHP.
    number
        The number of the random platform at the beginning of the line.
    share
        The share of the line before the platform: a decimal between 0 and 1.
    """

    real: int
    number: int
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
    numbers = {place.real for place in _rows().get(own) or _rows().get(other) or ()}
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
        for place in _rows().get(_name(name), ()):
            if place.real == real:
                found = platform_at(Family(family.platform_class, name), place)
                return found if name == family.distances else found.exchanged
    message = (
        f"{family.id}: no platform with {real} real poses is recorded:"
        f" there are some with {spelled(real_counts(family)) or 'none'}"
    )
    raise GspError(message)


def recorded() -> Iterator[tuple[Family, tuple[PlaceOnLine, ...]]]:
    """Yield the records, one for each two mirrored families."""
    for name, places in _rows().items():
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


def _name(distances: tuple[Kind, ...]) -> str:
    return " ".join(kind.short for kind in distances)


@cache
def _rows() -> dict[str, tuple[PlaceOnLine, ...]]:
    """Return the places by the distances."""
    text = data_path(*FILE).read_text(encoding="utf-8")
    return {
        row["family"].partition(" ")[2]: tuple(map(PlaceOnLine.read, row["platforms"].split()))
        for row in csv.DictReader(text.splitlines())
    }
