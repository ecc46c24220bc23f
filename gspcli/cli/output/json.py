"""Documents for programs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from gspcli.cli.output.tables import Table


def render(
    tables: Sequence[Table],
    document: object = None,
    schema: str = "",
    *,
    ascii_only: bool = False,
) -> str:
    """Return a document as JSON; without one the rows of the tables, with the name of a schema."""
    if document is None:
        rows = {table.part or "rows": [_row(table, row) for row in table.rows] for table in tables}
        document = {"schema": f"gsp.{schema}/1", **rows}
    return json.dumps(document, indent=2, ensure_ascii=ascii_only) + "\n"


def _row(table: Table, row: Mapping[str, Any]) -> dict[str, Any]:
    return {column.key: row.get(column.key) for column in table.columns}
