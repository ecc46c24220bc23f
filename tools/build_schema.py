"""Write the JSON Schema of the instance file to the documentation.

python tools/build_schema.py [--check]
"""

from __future__ import annotations

import json
import sys

from recording import ROOT, parser, save

sys.path.insert(0, str(ROOT))

from gspcli.spec.schema import json_schema

TARGET = ROOT / "docs" / "instance.schema.json"


def main() -> int:
    """Write or compare the file; return the exit code."""
    arguments = parser(__doc__).parse_args()
    text = json.dumps(json_schema(), indent=2) + "\n"
    return save({TARGET: text}, check=arguments.check, confirmed="schema of instance files")


if __name__ == "__main__":
    sys.exit(main())
