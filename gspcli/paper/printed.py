"""The printed tables, and differences of printed and computed entries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gspcli.records import dataclass
from gspcli.resources import data_json

#: A row of Table 1 or 2: from column names to exact numbers as text, such as ``1/(1-sqrt(5))``.
Row = dict[str, str]


@dataclass(frozen=True)
class Difference:
    """An entry of a table that the paper prints differently from what is computed.

    Attributes
    ----------
    table
        The number of the table.
    row, column
        The place: the solution and the unknown, or the case and the column of Table 3.
    printed, computed
        The two entries.
    uncertain
        The reason why the print cannot be read with certainty; empty if it can.
    """

    table: int
    row: str
    column: str
    printed: str
    computed: str
    uncertain: str = ""

    def __str__(self) -> str:
        return (
            f"Table {self.table}, {self.row}, {self.column}: "
            f"printed {self.printed}, computed {self.computed}"
        )


def read_table(number: int) -> list[Row]:
    """Return Table 1 or Table 2 as printed."""
    data = data_json("paper", f"table{number}.json")
    return [dict(zip(data["columns"], row, strict=True)) for row in data["rows"]]


def differences_from(number: int, computed: Sequence[Row]) -> Iterator[Difference]:
    """Yield the numbers of a printed table that are not exactly the computed ones."""
    from gspcli.symbolic.examples import equal_numbers

    doubts = {
        (doubt["row"], doubt["column"]): doubt["note"]
        for doubt in data_json("paper", f"table{number}.json")["uncertain"]
    }
    rows = zip(read_table(number), computed, strict=True)
    for place, (theirs, ours) in enumerate(rows, start=1):
        for column, value in theirs.items():
            if not equal_numbers(value, ours[column]):
                doubt = doubts.get((place, column), "")
                yield Difference(number, f"solution {place}", column, value, ours[column], doubt)
