"""One description of a table for all formats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal


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
    """

    key: str
    title: str = ""
    align: Literal["left", "right"] = "left"
    essential: bool = False

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
        The columns, the most important first: the last ones are left out first.
    rows
        A mapping from column keys to values for each row; missing and None are empty cells.
    title
        A heading above the table.
    notes
        Lines below the table, for people only.
    """

    columns: Sequence[Column]
    rows: Sequence[Mapping[str, Any]]
    title: str = ""
    notes: Sequence[str] = field(default=())


def cell_text(value: object) -> str:
    """Return a value as people read it in a table."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        return " ".join(cell_text(item) for item in value)
    return str(value).replace("\n", " ")
