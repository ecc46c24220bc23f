"""Write the JSON Schema of instance files, which is shipped.

python -m tools.build.schema [--check]
"""

from __future__ import annotations

import sys

from gspcli.spec.schema import schema_text
from tools.recording import ROOT, parser, save

TARGET = ROOT / "data" / "instance.schema.json"


def main() -> int:
    """Write or compare the file; return the exit code."""
    arguments = parser(__doc__).parse_args()
    return save(
        {TARGET: schema_text()}, check=arguments.check, confirmed="schema of instance files"
    )


if __name__ == "__main__":
    sys.exit(main())
