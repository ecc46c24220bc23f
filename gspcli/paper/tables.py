"""Tables 1 to 3, recomputed and as printed, and where they differ.

Table 1 has the eight rotations of Example 6.2 with three angles of π/3 (page 76), Table 2 the eight
positions of P1 in Example 6.8 (page 79), and Table 3 the maximal number of one-sided solutions of
the 3D3A platforms (page 80).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from gspcli.catalogue.bounds import family_bounds
from gspcli.catalogue.constraints import constraint_facts
from gspcli.catalogue.kinds import KINDS_BY_NAME, Kind
from gspcli.catalogue.types import CLASSES, Family, families
from gspcli.errors import ArgumentError
from gspcli.records import dataclass
from gspcli.resources import data_json
from gspcli.wording import counted, shortened

if TYPE_CHECKING:
    import pandas as pd

#: A row of Table 1 or 2: from column names to exact numbers as text, such as ``1/(1-sqrt(5))``.
Row = dict[str, str]


@dataclass(frozen=True)
class Difference:
    """An entry of a table that the paper prints differently from what is computed."""

    #: The number of the table.
    table: int
    #: The place: the solution and the unknown, or the case and the column of Table 3.
    row: str
    column: str
    #: The two entries.
    printed: str
    computed: str
    #: The reason why the print cannot be read with certainty; empty if it can.
    uncertain: str = ""

    def __str__(self) -> str:
        return (
            f"Table {self.table}, {self.row}, {self.column}: "
            f"printed {self.printed}, computed {self.computed}"
        )


def printed_table(number: int) -> list[Row]:
    """Return Table 1 or Table 2 as printed."""
    data = data_json("paper", f"table{number}.json")
    return [dict(zip(data["columns"], row, strict=True)) for row in data["rows"]]


def table_1() -> list[Row]:
    """Return the eight rotations in exact radicals, derived, in the order of the print."""
    from gspcli.symbolic.examples import example_6_2_rotations

    return [
        {f"r{i + 1}{j + 1}": str(rotation[i, j]) for i in range(3) for j in range(3)}
        for rotation in example_6_2_rotations()
    ]


def table_2(r1: int = 6, r2: int = 4, r3: int = 5) -> list[Row]:
    """Return the eight points in exact radicals, derived, in the order of the print.

    The distances are those of equation (17). The print shows what they would be with the
    second and third exchanged: ``table_2(6, 5, 4)``.
    """
    from gspcli.symbolic.examples import example_6_8_points

    points = example_6_8_points(r1, r2, r3)
    return [{name: str(x) for name, x in zip("xyz", point, strict=True)} for point in points]


def differences(number: int, computed: Sequence[Row]) -> Iterator[Difference]:
    """Yield the numbers of a printed table that are not exactly the computed ones."""
    from gspcli.symbolic.examples import equal_numbers

    doubts = {
        (doubt["row"], doubt["column"]): doubt["note"]
        for doubt in data_json("paper", f"table{number}.json")["uncertain"]
    }
    rows = zip(printed_table(number), computed, strict=True)
    for place, (theirs, ours) in enumerate(rows, start=1):
        for column, value in theirs.items():
            if not equal_numbers(value, ours[column]):
                doubt = doubts.get((place, column), "")
                yield Difference(number, f"solution {place}", column, value, ours[column], doubt)


Triple = tuple[Kind, Kind, Kind]


@dataclass(frozen=True, order=True)
class Entry:
    """One column of the table: a family of twenty types."""

    #: The maximal number of one-sided solutions.
    n1: int
    #: The three surfaces that meet, in the order P, S, C.
    surfaces: str
    #: The three distance kinds in canonical order.
    distances: Triple

    @property
    def family(self) -> Family:
        """The family of the entry."""
        return Family(CLASSES[0], self.distances)

    def __str__(self) -> str:
        return " ".join(kind.short for kind in self.distances)


def table_3() -> list[Entry]:
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


def printed_table_3() -> list[Entry]:
    """Return the table as printed, column by column."""
    return [
        Entry(group["n1"], group["surfaces"], _triple(column))
        for group in data_json("paper", "table3.json")["groups"]
        for column in zip(*(row.split() for row in group["rows"]), strict=True)
    ]


def _triple(names: tuple[str, ...]) -> Triple:
    first, second, third = sorted(KINDS_BY_NAME["D" + name] for name in names)
    return (first, second, third)


def differences_3() -> Iterator[Difference]:
    """Yield the wrong columns of the print, each with the column that is missing in its place."""
    ours, theirs = Counter(table_3()), Counter(printed_table_3())
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


def erratum_of(difference: Difference) -> str | None:
    """Return the key of the erratum that explains a difference of a table, or None."""
    if difference.table == 1 and (difference.row, difference.column) == ("solution 8", "r21"):
        return "table-1-sign"
    if difference.table == 2 and difference.column in "xy":
        return "table-2-exchanged"
    if difference.table == 3 and difference.row in ("case PSS", "case CCC"):
        return "table-3-columns"
    return None


_TITLES = {
    1: "Table 1: the eight rotations of Example 6.2, three angles of π/3",
    2: "Table 2: the eight positions of P1 in Example 6.8, distances 6, 4, 5",
    3: "Table 3: maximal numbers N1 of one-sided solutions of the 3D3A platforms",
}


@dataclass(frozen=True)
class Comparison:
    """One table, as computed and as printed.

    Attributes
    ----------
    number
        The number of the table.
    title
        The content.
    columns
        The keys of the rows.
    computed, printed
        The rows.
    differences
        Entries that differ.
    """

    number: int
    title: str
    columns: tuple[str, ...]
    computed: list[dict[str, Any]]
    printed: list[dict[str, Any]]
    differences: tuple[Difference, ...]

    @property
    def unexplained(self) -> tuple[Difference, ...]:
        """The differences that no erratum explains."""
        return tuple(d for d in self.differences if erratum_of(d) is None)

    def __repr__(self) -> str:
        rows, different = counted(len(self.computed), "row"), len(self.differences)
        return f"<Comparison of Table {self.number}: {rows}, {different} printed differently>"

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as computed (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.computed, columns=list(self.columns))

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data, as one of the ``tables`` of ``gsp.table/1``."""
        return {
            "table": self.number,
            "title": self.title,
            "computed": self.computed,
            "printed": self.printed,
            "differences": [
                asdict(difference) | {"erratum": erratum_of(difference)}
                for difference in self.differences
            ],
        }


def table(number: int) -> Comparison:
    """Recompute a table of the paper and compare it with the print.

    Parameters
    ----------
    number
        1, 2 or 3.

    Raises
    ------
    ArgumentError
        If there is no table with this number.
    """
    if number not in _TITLES:
        raise ArgumentError(
            f"found {shortened(str(number))}, expected one of the tables 1, 2 and 3", "number"
        )
    if number == 3:
        return Comparison(
            number,
            _TITLES[number],
            ("n1", "surfaces", "distances"),
            _entries(table_3()),
            _entries(printed_table_3()),
            tuple(differences_3()),
        )
    printed, computed = printed_table(number), {1: table_1, 2: table_2}[number]()
    return Comparison(
        number,
        _TITLES[number],
        ("solution", *printed[0]),
        _numbered(computed),
        _numbered(printed),
        tuple(differences(number, computed)),
    )


def _numbered(rows: list[dict[str, str]]) -> list[dict[str, Any]]:
    return [{"solution": number, **row} for number, row in enumerate(rows, start=1)]


def _entries(entries: list[Entry]) -> list[dict[str, Any]]:
    return [
        {"n1": entry.n1, "surfaces": entry.surfaces, "distances": str(entry)} for entry in entries
    ]
