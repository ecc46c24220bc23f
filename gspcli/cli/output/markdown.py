"""Tables for pages in Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from gspcli.cli.output.table import Table, cell_text


def render(tables: Sequence[Table]) -> str:
    """Return tables in Markdown, with their titles and notes."""
    return "\n".join(_markdown(table) for table in tables)


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
