"""The paper's tables, recomputed and compared with the print."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from gspcli.errors import ArgumentError
from gspcli.paper import table1, table2, table3
from gspcli.paper.errata import erratum_of
from gspcli.paper.printed import Difference
from gspcli.records import dataclass
from gspcli.wording import counted, shortened

if TYPE_CHECKING:
    import pandas as pd

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
        message = f"found {shortened(str(number))}, expected one of the tables 1, 2 and 3"
        raise ArgumentError(message, "number")
    if number == 3:
        return Comparison(
            number,
            _TITLES[number],
            ("n1", "surfaces", "distances"),
            _entries(table3.compute()),
            _entries(table3.printed()),
            tuple(table3.differences()),
        )
    module = {1: table1, 2: table2}[number]
    printed = module.printed()
    return Comparison(
        number,
        _TITLES[number],
        ("solution", *printed[0]),
        _numbered(module.compute()),
        _numbered(printed),
        tuple(module.differences()),
    )


def _numbered(rows: list[dict[str, str]]) -> list[dict[str, Any]]:
    return [{"solution": number, **row} for number, row in enumerate(rows, start=1)]


def _entries(entries: list[table3.Entry]) -> list[dict[str, Any]]:
    return [
        {"n1": entry.n1, "surfaces": entry.surfaces, "distances": str(entry)} for entry in entries
    ]
