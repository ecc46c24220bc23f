"""Tables for pages in Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from gspcli.cli.output.cells import column_texts, printable
from gspcli.cli.output.tables import Table


def render(tables: Sequence[Table]) -> str:
    """Return tables in Markdown, with their titles, summaries and notes."""
    return "\n".join(filter(None, map(_markdown, tables)))


def _markdown(table: Table) -> str:
    title = f"### {printable(table.title)}\n" if table.title else ""
    paragraphs = [title, *map(_paragraph, table.summary), _grid(table)]
    return "\n".join(filter(None, [*paragraphs, *map(_paragraph, table.notes)]))


def _paragraph(line: str) -> str:
    return f"{printable(line)}\n"


def _grid(table: Table) -> str:
    if not table.columns:
        return ""
    rules = ["---:" if column.align == "right" else "---" for column in table.columns]
    text = _line([column.heading for column in table.columns])
    text += "|" + "|".join(rules) + "|\n"
    cells = [column_texts(table, column) for column in table.columns]
    return text + "".join(map(_line, zip(*cells, strict=True)))


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"
