"""Tables for programs that read columns: full precision, no words for people."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

from gspcli.cli.output.table import Table


def render(tables: Sequence[Table]) -> str:
    """Return tables as CSV, with an empty line between them."""
    return "\n".join(_csv(table) for table in tables)


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
