"""How results reach the user: one description of a table, five formats, files written whole."""

from __future__ import annotations

import csv
import errno
import io
import json
import os
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeVar

import click

from gspcli.errors import GspError

FORMATS = ("table", "csv", "json", "markdown", "latex")
_SUFFIXES = {
    ".csv": "csv",
    ".json": "json",
    ".md": "markdown",
    ".tex": "latex",
    ".txt": "table",
    ".svg": "svg",
    ".yaml": "yaml",
}
_UNLIMITED_WIDTH = 100_000

Function = TypeVar("Function", bound=Callable[..., Any])


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


@dataclass(frozen=True)
class Output:
    """Where the user wants a result and in which format.

    Attributes
    ----------
    format
        One of `FORMATS` (or the formats the command allows).
    path
        The file, or None for standard output.
    """

    format: str
    path: Path | None


def output_options(
    formats: Sequence[str] = FORMATS, default: str = "table"
) -> Callable[[Function], Function]:
    """Return a decorator that adds ``--format`` and ``-o``; the command gets ``output: Output``."""

    def decorate(function: Function) -> Function:
        def resolve(context: click.Context, _: click.Parameter, value: str | None) -> str | None:
            path = value
            if path == "-":
                path = None
            chosen = context.params.pop("format_", None)
            if chosen is None and path is not None:
                chosen = _SUFFIXES.get(Path(path).suffix.lower())
                if chosen not in formats:
                    known = ", ".join(s for s, name in _SUFFIXES.items() if name in formats)
                    message = f"no format known from {path!r}: use --format, or one of {known}"
                    raise click.BadParameter(message)
            if path is not None:
                check_writable(Path(path))
            context.params["output"] = Output(chosen or default, Path(path) if path else None)
            return None

        function = click.option(
            "-o",
            "--output",
            "output_file_",
            metavar="FILE",
            expose_value=False,
            callback=resolve,
            help="Write to FILE; its suffix gives the format.",
        )(function)
        return click.option(
            "--format",
            "format_",
            type=click.Choice(list(formats)),
            is_eager=True,
            help=f"Output format.  [default: {default}, or by the suffix of -o]",
        )(function)

    return decorate


def emit(
    output: Output,
    tables: Table | Sequence[Table],
    *,
    document: object = None,
    texts: Mapping[str, str] | None = None,
) -> None:
    """Write a result where and how the user wants it.

    Parameters
    ----------
    output
        From `output_options`.
    tables
        What to show in the formats made of tables.
    document
        The JSON document; the rows of the tables when None.
    texts
        Ready text for formats in which the command does not want tables.
    """
    tables = [tables] if isinstance(tables, Table) else list(tables)
    if texts and output.format in texts:
        write(output, texts[output.format])
    elif output.format == "json":
        if document is None:
            rows = [[_plain_row(table, row) for row in table.rows] for table in tables]
            document = rows[0] if len(rows) == 1 else rows
        write(output, json.dumps(document, indent=2, ensure_ascii=False) + "\n")
    elif output.format == "csv":
        write(output, "\n".join(_csv(table) for table in tables))
    elif output.format == "markdown":
        write(output, "\n".join(_markdown(table) for table in tables))
    elif output.format == "latex":
        write(output, "\n".join(_latex(table) for table in tables))
    else:
        _emit_tables(output, tables)


def write(output: Output, text: str) -> None:
    """Write finished text to standard output or, whole or not at all, to the file."""
    if output.path is None:
        sys.stdout.write(text)
    else:
        write_whole(output.path, text)


def check_writable(path: Path) -> None:
    """Complain of a place where no file can be written before the work, not after it.

    Raises
    ------
    GspError
        If the file is a folder, or cannot be made in its folder.
    """
    folder = path.resolve().parent
    if path.is_dir():
        code = errno.EISDIR
    elif not folder.is_dir():
        code = errno.ENOENT
    elif not os.access(folder, os.W_OK) and not _is_special(path):
        code = errno.EACCES
    else:
        return
    message = f"{path}: cannot be written: {os.strerror(code)}"
    raise GspError(message)


def _is_special(path: Path) -> bool:
    """Return whether a path is a device or a pipe, which cannot be replaced by a file."""
    return path.exists() and not path.is_file() and not path.is_dir()


def write_whole(path: Path, text: str) -> None:
    """Write a file so that it is never seen half-written; write to a device or a pipe as it is.

    Raises
    ------
    GspError
        If the file cannot be written.
    """
    if _is_special(path):
        with path.open("w", encoding="utf-8", newline="\n") as device:
            device.write(text)
        return
    # A link stays one.
    path = path.resolve()
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        message = f"{path}: cannot be written: {error.strerror}"
        raise GspError(message) from error
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
        mask = os.umask(0)
        os.umask(mask)
        Path(temporary).chmod(0o666 & ~mask)
        Path(temporary).replace(path)
    except OSError as error:
        Path(temporary).unlink(missing_ok=True)
        message = f"{path}: cannot be written: {error.strerror}"
        raise GspError(message) from error
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


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


def _plain_row(table: Table, row: Mapping[str, Any]) -> dict[str, Any]:
    return {column.key: row.get(column.key) for column in table.columns}


def _csv_cell(value: object) -> str:
    """Return a value for a machine: full precision, `true` and `false`."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return " ".join(_csv_cell(item) for item in value)
    return repr(value) if isinstance(value, float) else str(value)


def _csv(table: Table) -> str:
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    keys = [column.key for column in table.columns]
    writer.writerow(keys)
    writer.writerows([_csv_cell(row.get(key)) for key in keys] for row in table.rows)
    return buffer.getvalue()


def _markdown(table: Table) -> str:
    def line(cells: list[str]) -> str:
        return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"

    rules = ["---:" if column.align == "right" else "---" for column in table.columns]
    text = f"### {table.title}\n\n" if table.title else ""
    text += line([column.heading for column in table.columns])
    text += "|" + "|".join(rules) + "|\n"
    for row in table.rows:
        text += line([cell_text(row.get(column.key)) for column in table.columns])
    return text + "".join(f"\n{note}\n" for note in table.notes)


_LATEX_ESCAPES = str.maketrans(
    {
        "&": r"\&",
        "%": r"\%",
        "#": r"\#",
        "_": r"\_",
        "$": r"\$",
        "{": r"\{",
        "}": r"\}",
        "^": r"\textasciicircum{}",
        "~": r"\textasciitilde{}",
        "\\": r"\textbackslash{}",
        "√": r"$\surd$",
        "·": r"$\cdot$",
        "×": r"$\times$",
        "≤": r"$\le$",
        "²": r"\textsuperscript{2}",
        "ρ": r"$\rho$",
    }
)


def _latex(table: Table) -> str:
    def line(cells: list[str]) -> str:
        return " & ".join(cell.translate(_LATEX_ESCAPES) for cell in cells) + r" \\" + "\n"

    layout = "".join("r" if column.align == "right" else "l" for column in table.columns)
    text = f"% {table.title}\n" if table.title else ""
    text += rf"\begin{{tabular}}{{{layout}}}" + "\n\\toprule\n"
    text += line([column.heading for column in table.columns]) + "\\midrule\n"
    for row in table.rows:
        text += line([cell_text(row.get(column.key)) for column in table.columns])
    return text + "\\bottomrule\n\\end{tabular}\n"


def _emit_tables(output: Output, tables: Sequence[Table]) -> None:
    from rich.console import Console

    if output.path is None and sys.stdout.isatty():
        _print_tables(Console(file=sys.stdout), tables)
        return
    # Not to a pipe either: rich would exit with 1 when the reader closes it.
    buffer = io.StringIO()
    _print_tables(Console(file=buffer, width=_UNLIMITED_WIDTH, color_system=None), tables)
    write(output, buffer.getvalue())


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
