"""Write a result in the format and to the place asked for."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import click

from gspcli.cli.output.files import write_whole
from gspcli.cli.output.options import Output
from gspcli.cli.output.tables import Table
from gspcli.cli.streams import lacking, representable, say
from gspcli.errors import GspError
from gspcli.wording import listed


def emit(
    output: Output,
    tables: Table | Sequence[Table],
    *,
    document: object = None,
    schema: str = "",
    texts: Mapping[str, str] | None = None,
) -> None:
    """Write a result to the place and in the format asked for.

    Parameters
    ----------
    output
        From `output_options`.
    tables
        What to show in the formats made of tables.
    document
        The JSON document; when None, the rows of the tables, each table under its part's name.
    schema
        What the schema of that document is called, as ``enumerate`` for ``gsp.enumerate/1``.
    texts
        Ready text for formats in which the command has no tables.
    """
    # A format is imported when it is needed: start-up is most of the time of many commands.
    tables = [tables] if isinstance(tables, Table) else list(tables)
    if output.part is not None:
        tables = [*_of_part(tables, output.part)]
    limited = output.path is None and lacking(sys.stdout)
    if limited:
        # Before the layout, since an escaped character is longer.
        tables = [table.converted(lambda text: representable(text, sys.stdout)) for table in tables]
    if texts and output.format in texts:
        write(output, texts[output.format])
    elif output.format == "json":
        from gspcli.cli.output import json

        write(output, json.render(tables, document, schema, ascii_only=limited))
    elif output.format == "csv":
        _emit_csv(output, [table for table in tables if table.columns])
    elif output.format == "markdown":
        from gspcli.cli.output import markdown

        write(output, markdown.render(tables))
    elif output.format == "latex":
        from gspcli.cli.output import latex

        write(output, latex.render(tables))
    else:
        from gspcli.cli.output import terminal

        if output.path is None and sys.stdout.isatty():
            terminal.show(tables)
        else:
            write(output, terminal.render(tables))


def _of_part(tables: Sequence[Table], part: str) -> Sequence[Table]:
    """Return the tables of a part.

    Raises
    ------
    GspError
        If there is none: an empty answer would say that there is nothing in it.
    """
    found = [table for table in tables if table.part == part]
    if not found:
        there = listed([table.part for table in tables if table.part], "and")
        message = f"--part {part}: there is no such table in this answer, which has {there}"
        raise GspError(message)
    return found


def _emit_csv(output: Output, tables: Sequence[Table]) -> None:
    """Write one table, or each of several to a file of its own."""
    from gspcli.cli.output import csv

    if len(tables) > 1 and output.path is None:
        parts = ", ".join(table.part for table in tables)
        message = f"CSV holds one table: choose --part of {parts}, or -o FILE.csv for a file each"
        raise click.UsageError(message)
    for table in tables:
        place = output
        if len(tables) > 1:
            assert output.path is not None
            place = replace(output, path=_named(output.path, table.part))
            say(f"{place.path}: written")
        write(place, csv.render(table))
        for line in table.summary:
            say(line)


def _named(path: Path, part: str) -> Path:
    """Return the file of a part: poses.csv and digits give poses-digits.csv."""
    return path.with_name(f"{path.stem}-{part}{path.suffix}")


def write(output: Output, content: str | bytes) -> None:
    """Write finished text or data to standard output or, whole or not at all, to the file."""
    if output.path is not None:
        write_whole(output.path, content)
    elif isinstance(content, bytes):
        sys.stdout.buffer.write(content)
    elif output.format == "html" and lacking(sys.stdout):
        # A page states its own encoding.
        sys.stdout.buffer.write(content.encode())
    else:
        sys.stdout.write(content)
