"""Tables for programs that read columns: full precision, no words for people."""

from __future__ import annotations

import csv
import io

from gspcli.cli.output.tables import Table

#: What the writer itself writes as `_cell` does; floats with all their digits.
_PLAIN = {float, int, str}


def render(table: Table) -> str:
    """Return a table as CSV."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    keys = [column.key for column in table.columns]
    writer.writerow(keys)
    writer.writerows(
        [cell if type(cell) in _PLAIN else _cell(cell) for cell in map(row.get, keys)]
        for row in table.rows
    )
    return buffer.getvalue()


def _cell(value: object) -> str:
    """Return a value for a machine: full precision, `true` and `false`."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return " ".join(_cell(item) for item in value)
    return repr(value) if isinstance(value, float) else str(value)
