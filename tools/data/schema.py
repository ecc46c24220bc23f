"""Write the JSON Schema of instance files, which is shipped.

python -m tools.data.schema [--check]
"""

from __future__ import annotations

import json
import sys

from gspcli.spec.form_of_instance import json_schema
from tools.recording import ROOT, parser, save

TARGET = ROOT / "data" / "instance.schema.json"


def main() -> int:
    """Write or compare the file; return the exit code."""
    arguments = parser(__doc__).parse_args()
    text = json.dumps(json_schema(), indent=2) + "\n"
    return save({TARGET: text}, check=arguments.check, confirmed="schema of instance files")


if __name__ == "__main__":
    sys.exit(main())
