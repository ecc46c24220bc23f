"""Write the JSON Schema of instance files, which is shipped.

python -m tools.data.schema [--check]
"""

from __future__ import annotations

import json
import sys
from typing import Any

from gspcli.spec.models import InstanceModel
from tools.recording import ROOT, parser, save

TARGET = ROOT / "data" / "instance.schema.json"
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


def main() -> int:
    """Write or compare the file; return the exit code."""
    arguments = parser(__doc__).parse_args()
    text = json.dumps(json_schema(), indent=2) + "\n"
    return save({TARGET: text}, check=arguments.check, confirmed="schema of instance files")


if __name__ == "__main__":
    sys.exit(main())
