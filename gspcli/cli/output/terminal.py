"""Tables for people, of the width of the terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from itertools import zip_longest

import click

from gspcli.cli.colour import coloured
from gspcli.cli.output.cells import column_texts, printable
from gspcli.cli.output.layout import GAP, Grid, cell_width, folded, lay_out
from gspcli.cli.output.tables import Column, Table
from gspcli.cli.streams import say

_RULE = "─"


def folded_lines(text: str) -> str:
    """Return a text with lines broken at blanks to fit the terminal; continuations are indented."""
    import shutil
    import textwrap

    width = shutil.get_terminal_size().columns
    lines = []
    for line in text.splitlines():
        indent = " " * (len(line) - len(line.lstrip()) + 4)
        parts = textwrap.wrap(
            line,
            width,
            subsequent_indent=indent,
            break_long_words=False,
            break_on_hyphens=False,
            drop_whitespace=True,
        )
        lines += parts or [line]
    return "".join(f"{line}\n" for line in lines)


def show(tables: Sequence[Table]) -> None:
    """Print tables on the terminal, leaving out columns that do not fit."""
    import shutil

    width = shutil.get_terminal_size().columns
    for index, table in enumerate(tables):
        grid = lay_out(table, width)
        lines = _lines(table, grid, width, bold=coloured(sys.stdout))
        sys.stdout.write("\n" * (index > 0) + "".join(f"{line}\n" for line in lines))
        if grid is not None and grid.left_out:
            sys.stdout.flush()
            names = f"(left out to fit the terminal: {', '.join(grid.left_out)})"
            say("\n".join(folded(names, width)))


def render(tables: Sequence[Table]) -> str:
    """Return tables as text of any width, for a file or a pipe."""
    return "\n".join(
        "".join(f"{line}\n" for line in _lines(table, lay_out(table), None, bold=False))
        for table in tables
    )


def _lines(table: Table, grid: Grid | None, width: int | None, *, bold: bool) -> Iterator[str]:
    def emphasized(text: str) -> str:
        return click.style(text, bold=True) if bold else text

    groups = [
        map(emphasized, _prose(table.title, width) if table.title else ()),
        (part for line in table.summary for part in _prose(line, width)),
        _body(table, grid, width, emphasized) if table.columns else (),
        (part for note in table.notes for part in _prose(note, width)),
    ]
    between = False
    for lines in filter(None, map(list, groups)):
        if between:
            yield ""
        yield from lines
        between = True


def _body(
    table: Table, grid: Grid | None, width: int | None, emphasized: Callable[[str], str]
) -> Iterator[str]:
    if grid is None:
        yield from _records(table, width or 0)
        return
    heading, *others = _drawn(grid)
    yield from map(emphasized, heading.split("\n"))
    yield from others


def _prose(text: str, width: int | None) -> list[str]:
    lines = printable(text).split("\n")
    return lines if width is None else [part for line in lines for part in folded(line, width)]


def _drawn(grid: Grid) -> Iterator[str]:
    """Yield the headings (several lines in one text), a rule, and the rows."""
    headings = [
        folded(column.heading, width)
        for column, width in zip(grid.columns, grid.widths, strict=True)
    ]
    yield "\n".join(_joined(grid, headings))
    yield (_RULE * (sum(grid.widths) + GAP * (len(grid.widths) - 1)))
    prose = [k for k, column in enumerate(grid.columns) if column.fold]
    for row in zip(*grid.texts, strict=True):
        cells = [[text] for text in row]
        for k in prose:
            cells[k] = folded(row[k], grid.widths[k], grid.columns[k].fold)
        yield from _joined(grid, cells)


def _joined(grid: Grid, cells: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of cells that stand beside each other."""
    for line in zip_longest(*cells, fillvalue=""):
        parts = map(_flushed, line, grid.columns, grid.widths)
        yield (" " * GAP).join(parts).rstrip()


def _flushed(text: str, column: Column, width: int) -> str:
    blanks = " " * (width - cell_width(text))
    return blanks + text if column.align == "right" else text + blanks


def _records(table: Table, width: int) -> Iterator[str]:
    """Yield the cells that are not empty with their headings, an empty line between the rows.

    Numbers stand beside each other as long as there is room, texts have lines of their own.
    """
    texts = [column_texts(table, column) for column in table.columns]
    widest = [max(map(cell_width, cells), default=0) for cells in texts]
    for index, row in enumerate(zip(*texts, strict=True)):
        if index:
            yield ""
        line = ""
        for column, text, cells in zip(table.columns, row, widest, strict=True):
            if not text:
                continue
            if column.align == "left":
                yield from filter(None, [line.rstrip()])
                yield from folded(f"{column.heading}: {text}", width, column.fold or " ")
                line = ""
                continue
            entry = f"{column.heading} {text.rjust(cells)}"
            if line and cell_width(line + entry) > width:
                yield line.rstrip()
                line = ""
            line += entry + " " * GAP
        yield from filter(None, [line.rstrip()])
