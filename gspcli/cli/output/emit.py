"""A result on its way to the user: the format, then the place."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

from gspcli.cli.output import csv, json, latex, markdown, terminal
from gspcli.cli.output.files import write_whole
from gspcli.cli.output.options import Output
from gspcli.cli.output.table import Table


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
        write(output, json.render(tables, document))
    elif output.format == "csv":
        write(output, csv.render(tables))
    elif output.format == "markdown":
        write(output, markdown.render(tables))
    elif output.format == "latex":
        write(output, latex.render(tables))
    elif output.path is None and sys.stdout.isatty():
        terminal.show(tables)
    else:
        write(output, terminal.render(tables))


def write(output: Output, text: str) -> None:
    """Write finished text to standard output or, whole or not at all, to the file."""
    if output.path is None:
        sys.stdout.write(text)
    else:
        write_whole(output.path, text)
