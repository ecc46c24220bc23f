"""One description of a table for all formats."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import zip_longest
from pathlib import Path

import click

from gspcli.cli.result import DIGITS, Field, Result, column_texts
from gspcli.cli.streams import coloured, printable, say
from gspcli.errors import GspError
from gspcli.records import dataclass
from gspcli.wording import listed, named

#: Blanks between two columns.
GAP = 2
#: Digits that are tried when the essential columns do not fit, before records are.
_FEWER_DIGITS = (5, 4, 3)
#: Prose is folded to this width before a column is left out.
_COMFORTABLE = 24


@dataclass(frozen=True)
class Grid:
    """Columns beside each other."""

    #: Those shown, with their widths in cells of the terminal.
    columns: Sequence[Field]
    widths: Sequence[int]
    #: The cells of each of them, from top to bottom.
    texts: Sequence[Sequence[str]]
    #: Headings of the columns for which there is no room.
    left_out: Sequence[str] = ()


def lay_out(table: Result, width: int | None = None) -> Grid | None:
    """Choose the layout of a table for a width; None is unlimited.

    Tried in this order: all columns; headings, then prose, folded at blanks; without the columns
    with the largest `minor`; prose as narrow as its words; fewer digits. Columns whose `minor` is
    negative are omitted only if they do not fit with four digits either.
    """
    measured = cache(partial(_Measured, table))
    if width is None:
        return measured(DIGITS).grid(measured(DIGITS).natural)
    important = [k for k, column in enumerate(table.columns) if column.minor < 0]
    tries: list[tuple[int, list[int]]] = [(digits, []) for digits in (DIGITS, *_FEWER_DIGITS)]
    if important:
        tries[:0] = [(digits, important) for digits in (DIGITS, *_FEWER_DIGITS[:2])]
    for digits, kept in tries:
        found = measured(digits)
        for widths in found.attempts(width, kept, every=digits == DIGITS):
            if sum(widths.values()) + GAP * (len(widths) - 1) <= width:
                return found.grid(widths)
    return None


class _Measured:
    """The cells of a table with some number of digits, and their widths."""

    def __init__(self, table: Result, digits: int) -> None:
        self.table = table
        self.texts = [column_texts(table, column, digits) for column in table.columns]
        cells = [max(map(cell_width, texts), default=0) for texts in self.texts]
        headings = [column.heading for column in table.columns]
        self.natural = dict(enumerate(map(max, cells, map(cell_width, headings))))
        #: With headings folded, and prose as well.
        self.folded = dict(enumerate(map(max, cells, map(_longest, headings))))
        self.narrowest = {
            k: max([_longest(headings[k]), *(_longest(t, column.fold) for t in self.texts[k])])
            if column.fold
            else folded
            for (k, folded), column in zip(self.folded.items(), table.columns, strict=True)
        }

    def grid(self, widths: dict[int, int]) -> Grid:
        columns = self.table.columns
        return Grid(
            [columns[k] for k in widths],
            list(widths.values()),
            [self.texts[k] for k in widths],
            [column.heading for k, column in enumerate(columns) if k not in widths],
        )

    def attempts(
        self, width: int, important: Sequence[int], *, every: bool
    ) -> Iterator[dict[int, int]]:
        """Yield widths of columns by their positions, the best first; not all of them fit."""
        columns = self.table.columns
        comfortable = {
            k: max(narrowest, min(self.folded[k], _COMFORTABLE))
            for k, narrowest in self.narrowest.items()
        }
        kept = list(range(len(columns)))
        dispensable = sorted(
            (k for k in kept if not columns[k].essential and k not in important),
            key=lambda k: (-columns[k].minor, -k),
        )[: len(kept) - 1]
        if every:
            yield self.natural
            yield self.folded
            yield self._squeezed(kept, comfortable, width)
            for k in dispensable:
                # Half of the coordinates of a point, or of the values, say nothing.
                same = [j for j in dispensable if columns[j].meaning == columns[k].meaning != ""]
                kept = [j for j in kept if j not in (k, *same)]
                yield self._squeezed(kept, comfortable, width)
        else:
            kept = [k for k in kept if k not in dispensable]
        yield self._squeezed(kept, self.narrowest, width)

    def _squeezed(self, kept: list[int], narrowest: dict[int, int], width: int) -> dict[int, int]:
        """Return the widths after columns of prose are narrowed to fit, the widest first."""
        widths = {k: self.folded[k] for k in kept}
        excess = sum(widths.values()) + GAP * (len(widths) - 1) - width
        while excess > 0 and (able := [k for k in kept if widths[k] > narrowest[k]]):
            widths[max(able, key=widths.__getitem__)] -= 1
            excess -= 1
        return widths


def cell_width(text: str) -> int:
    """Return how many cells of a terminal a text takes."""
    if text.isascii():
        return len(text)
    from rich.cells import cell_len

    return cell_len(text)


def _longest(text: str, separator: str = " ") -> int:
    return max(map(cell_width, _pieces(text, separator)))


def _pieces(text: str, separator: str) -> list[str]:
    """Return what a text is made of, without the blanks between."""
    *pieces, last = text.split(separator)
    return [piece + separator.rstrip(" ") for piece in pieces] + [last]


def folded(text: str, width: int, separator: str = " ") -> list[str]:
    """Return a text in lines of at most a width, broken after separators only.

    Its indentation is kept. A piece longer than the width has a line of its own, and is whole.
    """
    pieces = _pieces(text.lstrip(" "), separator)
    indent = " " * (len(text) - len(text.lstrip(" ")))
    lines = [indent + pieces[0]]
    for piece in pieces[1:]:
        longer = f"{lines[-1]} {piece}"
        if cell_width(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(indent + piece)
    return lines


_RULE = "─"


def show(tables: Sequence[Result]) -> None:
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


def text_of_tables(tables: Sequence[Result]) -> str:
    """Return tables as text of any width, for a file or a pipe."""
    return "\n".join(
        "".join(f"{line}\n" for line in _lines(table, lay_out(table), None, bold=False))
        for table in tables
    )


def _lines(table: Result, grid: Grid | None, width: int | None, *, bold: bool) -> Iterator[str]:
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
    table: Result, grid: Grid | None, width: int | None, emphasized: Callable[[str], str]
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
        parts = []
        for text, column, width in zip(line, grid.columns, grid.widths, strict=True):
            blanks = " " * (width - cell_width(text))
            parts.append(blanks + text if column.align == "right" else text + blanks)
        yield (" " * GAP).join(parts).rstrip()


def _records(table: Result, width: int) -> Iterator[str]:
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


@dataclass(frozen=True)
class Output:
    """Where a result goes and in which format."""

    #: One of `FORMATS` (or the formats the command allows).
    format: str
    #: The file, or None for standard output.
    path: Path | None
    #: The one table that is asked for, None for all.
    part: str | None = None
    #: Whether files that are read, or beside that of `-o`, may be replaced.
    force: bool = False

    def beside(self, path: Path) -> Output:
        """Return the place of a file that `-o` does not name: one that exists is not replaced."""
        from gspcli.cli.files import check_writable

        check_writable(path)
        if path != self.path and not self.force and path.is_file():
            with path.open("rb") as file:
                # What gsp has written says so at its beginning.
                if not re.search(rb"gsp (export|\d)", file.read(200)):
                    wrong = "it is beside the file of -o: --force replaces it"
                    raise GspError(f"{named(path)}: {wrong}")
        return replace(self, path=path)


def emit(
    output: Output,
    tables: Result | Sequence[Result],
    *,
    document: object = None,
    texts: Mapping[str, str] | None = None,
) -> None:
    """Write a result to the place and in the format asked for."""
    results = [tables] if isinstance(tables, Result) else list(tables)
    tables = [table for result in results for table in result.tables]
    if output.part is not None:
        parts = [table.part for table in tables if table.part]
        tables = [table for table in tables if table.part == output.part]
        if not tables:
            there = f"there is no such table in this answer, which has {listed(parts, 'and')}"
            raise GspError(f"--part {output.part}: {there}")
    if texts and output.format in texts:
        write(output, texts[output.format])
    elif output.format == "json":
        if document is None:
            document = next((table for table in tables if table.schema), results[0]).document()
        write(output, json.dumps(document, indent=2, ensure_ascii=False) + "\n")
    elif output.format == "csv":
        _emit_csv(output, [table for table in tables if table.columns])
    elif output.format in ("markdown", "latex"):
        from gspcli.cli.formats import latex, markdown

        write(output, markdown(tables) if output.format == "markdown" else latex(tables))
    else:
        if output.path is None and sys.stdout.isatty():
            show(tables)
        else:
            write(output, text_of_tables(tables))


def _emit_csv(output: Output, tables: Sequence[Result]) -> None:
    """Write one table, or each of several to a file of its own."""
    if len(tables) > 1 and output.path is None:
        parts = ", ".join(table.part for table in tables)
        raise click.UsageError(
            f"CSV holds one table: choose --part of {parts}, or -o FILE.csv for a file each"
        )
    from gspcli.cli.formats import csv_text

    places = [output]
    if len(tables) > 1 and output.path is not None:
        # poses.csv and digits give poses-digits.csv.
        stem, suffix = output.path.stem, output.path.suffix
        places = [
            output.beside(output.path.with_name(f"{stem}-{table.part}{suffix}")) for table in tables
        ]
    for table, place in zip(tables, places, strict=True):
        if len(tables) > 1:
            say(f"{place.path}: written")
        write(place, csv_text(table))
        for line in table.summary:
            say(line)


def write(output: Output, content: str | bytes) -> None:
    """Write finished text or data to standard output or, whole or not at all, to the file."""
    if output.path is not None:
        from gspcli.cli.files import write_whole

        write_whole(output.path, content)
    elif isinstance(content, bytes):
        sys.stdout.buffer.write(content)
    else:
        sys.stdout.write(content)
