"""Tables 1 and 2 as printed: columns of exact numbers, one row a solution."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from gspcli.resources import data_json

#: A row: from column names to exact numbers as text, such as ``1/(1-sqrt(5))``.
Row = dict[str, str]


@dataclass(frozen=True)
class Difference:
    """A number that the paper prints differently from what is computed.

    Attributes
    ----------
    row
        The number of the solution, from 1, as in the paper.
    column
        The name of the unknown.
    printed, computed
        The two exact numbers.
    uncertain
        Why the reading of the print is not beyond doubt; empty if it is.
    """

    row: int
    column: str
    printed: str
    computed: str
    uncertain: str = ""


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
                yield Difference(place, column, value, ours[column], doubt)
