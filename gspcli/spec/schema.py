"""The JSON Schema of instance files, for editors and other programs."""

from __future__ import annotations

import json
from typing import Any

DIALECT = "https://json-schema.org/draft/2020-12/schema"
#: Under this name the schema is shipped in `data/`, and stands beside the files of users.
FILE_NAME = "instance.schema.json"
_LINE = "# yaml-language-server: $schema="
#: The first line of a file that editors check with the schema beside it.
EDITOR_LINE = f"{_LINE}{FILE_NAME}\n"


def json_schema() -> dict[str, Any]:
    """Return the schema of the parsed YAML.

    It states keys, arities and sorts of values. Only `gspcli.spec.load` checks conditions that need
    arithmetic or names (ranges of angles, zero directions, unknown primitives).
    """
    from gspcli.spec.models import InstanceModel

    schema = InstanceModel.model_json_schema()
    schema["title"] = "gsp instance file"
    text = json.dumps({"$schema": DIALECT, **schema})
    result: dict[str, Any] = json.loads(text.replace("Model", ""))
    return result


def schema_text() -> str:
    """Return the schema as the text of a file."""
    return json.dumps(json_schema(), indent=2) + "\n"


def is_editor_line(line: str) -> bool:
    """Whether a line of a file tells editors where the schema is."""
    return line.startswith(_LINE)


def beside_schema(text: str) -> str:
    """Return the text of a shipped file for another folder, where the schema is beside it."""
    return text.replace(f"{_LINE}../{FILE_NAME}\n", EDITOR_LINE, 1)
