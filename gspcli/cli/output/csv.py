"""Tables for programs that read columns: full precision, without titles and notes."""

from __future__ import annotations

import csv
import io

from gspcli.cli.output.tables import Table

#: What is written as `repr` has it, and never needs quotation marks; floats with all their digits.
_NUMBERS = {float, int}
#: What the writer itself writes as `_cell` does.
_PLAIN = _NUMBERS | {str}


def render(table: Table) -> str:
    """Return a table as CSV."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    keys = [column.key for column in table.columns]
    writer.writerow(keys)
    columns = [[row.get(key) for row in table.rows] for key in keys]
    if all(_NUMBERS.issuperset(map(type, column)) for column in columns):
        # Long tables are of numbers alone; joined, they take two thirds of the writer's time.
        texts = [map(repr, column) for column in columns]
        buffer.writelines(f"{','.join(cells)}\n" for cells in zip(*texts, strict=True))
    else:
        writer.writerows(
            [cell if type(cell) in _PLAIN else _cell(cell) for cell in cells]
            for cells in zip(*columns, strict=True)
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
