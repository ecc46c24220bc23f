"""One description of a table for all formats."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

from gspcli.records import dataclass

#: Digits of a number in a table for people, unless the column or the width says otherwise.
DIGITS = 6


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    key
        The key in the rows, and the heading in CSV and JSON.
    title
        The heading for people; the key when empty.
    align
        Side to which the cells are flushed.
    essential
        Whether the column stays when a terminal is too narrow for all of them.
    minor
        On a narrow terminal columns with the largest number are omitted first, of several with the
        same number the last. With a negative number the column is omitted only if it does not fit
        with fewer digits.
    fold
        After what a cell may go on in the next line: a blank in prose, a comma and a blank in
        lists; empty for cells that stay in one line.
    aligned
        Whether the numbers of the column have the same number of decimals, so that the points
        stand under each other.
    decimals
        This many decimals for each number, for any width; None for what `aligned` says.
    size
        A typical number. In tables for people a number far below it is a rounding error, and shown
        as zero. Otherwise one processor would show zero and another one 1e-17.
    """

    key: str
    title: str = ""
    align: Literal["left", "right"] = "left"
    essential: bool = False
    minor: int = 0
    fold: str = ""
    aligned: bool = False
    decimals: int | None = None
    size: float = 0.0

    @property
    def heading(self) -> str:
        """The heading for people."""
        return self.title or self.key


@dataclass(frozen=True)
class Table:
    """Rows to show.

    Attributes
    ----------
    columns
        The columns in the order of the page.
    rows
        A mapping from column keys to values for each row; missing and None are empty cells.
    title
        A heading above the table.
    notes
        Lines below the table, for people only.
    summary
        Lines between the title and the table that state the result. With CSV they go to standard
        error.
    part
        What `--part` calls the table, where a command shows several.
    """

    columns: Sequence[Column]
    rows: Sequence[Mapping[str, Any]]
    title: str = ""
    notes: Sequence[str] = ()
    summary: Sequence[str] = ()
    part: str = ""

    def converted(self, convert: Callable[[str], str]) -> Table:
        """Return the table with all its texts converted; what columns are called in CSV stays."""

        def cell(value: object) -> object:
            if isinstance(value, (list, tuple)):
                return [cell(part) for part in value]
            return convert(value) if isinstance(value, str) else value

        return replace(
            self,
            columns=[replace(one, title=convert(one.heading)) for one in self.columns],
            rows=[{key: cell(value) for key, value in row.items()} for row in self.rows],
            title=convert(self.title),
            notes=list(map(convert, self.notes)),
            summary=list(map(convert, self.summary)),
        )


def pose_columns(keys: Sequence[str], length: float) -> list[Column]:
    """Return the columns of poses.

    Parameters
    ----------
    keys
        Three of the position, then four of the quaternion.
    length
        A typical length of the platform.
    """
    sizes = [length] * 3 + [1.0] * 4
    return [
        Column(key, align="right", essential=True, aligned=True, size=size)
        for key, size in zip(keys, sizes, strict=True)
    ]
