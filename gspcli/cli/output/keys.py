"""The meanings of the keys of JSON and the columns of CSV of a command (``--keys``)."""

from __future__ import annotations

from collections.abc import Iterator

from gspcli.cli.output.tables import Column, Table
from gspcli.resources import data_json

_MEANING = Column("meaning", essential=True, fold=" ")


def meanings(command: str) -> Iterator[Table]:
    """Yield the tables of keys and columns of a command.

    Parameters
    ----------
    command
        Its words without ``gsp``, as ``atlas summary``.
    """
    for form in data_json("keys", f"{command.replace(' ', '-')}.json"):
        keys = [dict(zip(("key", "type", "meaning"), row, strict=True)) for row in form["keys"]]
        columns = (Column("key", essential=True), Column("type", fold=" "), _MEANING)
        yield Table(columns, keys, f"JSON {form['schema']}", part="keys")
        if form["columns"]:
            cells = [dict(zip(("column", "meaning"), row, strict=True)) for row in form["columns"]]
            yield Table((Column("column", essential=True), _MEANING), cells, "CSV", part="columns")
