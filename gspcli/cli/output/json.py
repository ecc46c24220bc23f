"""Documents for programs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from gspcli.cli.output.table import Table


def render(tables: Sequence[Table], document: object = None) -> str:
    """Return a document as JSON; the rows of the tables if there is none."""
    if document is None:
        rows = [[_plain_row(table, row) for row in table.rows] for table in tables]
        document = rows[0] if len(rows) == 1 else rows
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def _plain_row(table: Table, row: Mapping[str, Any]) -> dict[str, Any]:
    return {column.key: row.get(column.key) for column in table.columns}
