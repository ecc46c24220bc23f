"""Tables for people at a terminal, as wide as it is."""

from __future__ import annotations

import io
import sys
from collections.abc import Sequence
from typing import Any

import click

from gspcli.cli.output.table import Table, cell_text

_UNLIMITED_WIDTH = 100_000


def show(tables: Sequence[Table]) -> None:
    """Print tables on the terminal, leaving out columns that do not fit."""
    from rich.console import Console

    _print_tables(Console(file=sys.stdout), tables)


def render(tables: Sequence[Table]) -> str:
    """Return tables as text of any width, for a file or a pipe."""
    from rich.console import Console

    # Not printed to a pipe directly: rich would exit with 1 when the reader closes it.
    buffer = io.StringIO()
    _print_tables(Console(file=buffer, width=_UNLIMITED_WIDTH, color_system=None), tables)
    return buffer.getvalue()


def _print_tables(console: Any, tables: Sequence[Table]) -> None:
    from rich import box
    from rich.table import Table as RichTable
    from rich.text import Text

    for index, table in enumerate(tables):
        if index:
            console.print()
        if table.title:
            console.print(Text(table.title, style="bold"))
            console.print()
        cells = [[cell_text(row.get(c.key)) for c in table.columns] for row in table.rows]
        kept, left_out = _fitting(table, cells, console.width)
        if table.columns:
            grid = RichTable(
                box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, header_style="bold"
            )
            for position in kept:
                column = table.columns[position]
                grid.add_column(Text(column.heading), justify=column.align, no_wrap=True)
            if cells:
                # One tall row looks the same as many rows and is drawn three times as fast.
                grid.add_row(*(Text("\n".join(row[k] for row in cells)) for k in kept))
            console.print(grid)
            if table.notes:
                console.print()
        for note in table.notes:
            console.print(Text(note))
        if left_out:
            names = ", ".join(left_out)
            click.echo(f"(left out to fit the terminal: {names})", err=True)


def _fitting(table: Table, cells: list[list[str]], width: int) -> tuple[list[int], list[str]]:
    """Choose whole columns that fit: the last inessential ones go first."""
    from rich.cells import cell_len

    widths = [
        max([cell_len(column.heading), *(cell_len(row[position]) for row in cells)])
        for position, column in enumerate(table.columns)
    ]
    kept = list(range(len(table.columns)))
    left_out: list[int] = []
    for position in reversed(range(len(table.columns))):
        if sum(widths[k] + 2 for k in kept) <= width:
            break
        if not table.columns[position].essential:
            kept.remove(position)
            left_out.insert(0, position)
    return kept, [table.columns[position].heading for position in left_out]
