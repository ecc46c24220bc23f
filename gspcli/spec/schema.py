"""The line of an instance file that names its JSON Schema (`tools/data/schema.py` writes it)."""

from __future__ import annotations

#: Under this name the schema is shipped in `data/`, and stands beside the files of users.
FILE_NAME = "instance.schema.json"
SCHEMA_LINE = "# yaml-language-server: $schema="
#: The first line of a file that editors check with the schema beside it.
EDITOR_LINE = f"{SCHEMA_LINE}{FILE_NAME}\n"


def beside_schema(text: str) -> str:
    """Return the text of a shipped file for another folder, where the schema is beside it."""
    return text.replace(f"{SCHEMA_LINE}../{FILE_NAME}\n", EDITOR_LINE, 1)
