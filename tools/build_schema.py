"""Write the JSON Schema of the instance file to the documentation.

python tools/build_schema.py
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from gspcli.spec.schema import json_schema

TARGET = Path(__file__).resolve().parents[1] / "docs" / "instance.schema.json"


def main() -> None:
    """Write the file."""
    TARGET.write_text(json.dumps(json_schema(), indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
