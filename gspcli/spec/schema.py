"""The JSON Schema of instance files, for editors and other programs."""

from __future__ import annotations

import json
from typing import Any

from gspcli.spec.models import InstanceModel

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def json_schema() -> dict[str, Any]:
    """Return the schema of the parsed YAML.

    It states keys, arities and sorts of values. Only `gspcli.spec.load` checks conditions that need
    arithmetic or names (ranges of angles, zero directions, unknown primitives).
    """
    schema = InstanceModel.model_json_schema()
    schema["title"] = "gsp instance file"
    text = json.dumps({"$schema": DIALECT, **schema})
    result: dict[str, Any] = json.loads(text.replace("Model", ""))
    return result


def schema_text() -> str:
    """Return the schema as the text of a file."""
    return json.dumps(json_schema(), indent=2) + "\n"
