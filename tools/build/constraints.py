"""Derive equations, degrees and loci of the ten kinds of constraint and record them in the data.

    python -m tools.build.constraints [--check]

Every recorded degree is proved to be the lowest first.
"""

from __future__ import annotations

import json
import sys

from gspcli.catalogue.kinds import KINDS
from gspcli.symbolic.facts import constraint_facts, unproved_degrees
from tools.recording import ROOT, canonical_sha256, parser, report, save, versions

TARGET = ROOT / "data" / "constraints.json"
COMMAND = "python -m tools.build.constraints"


def main() -> int:
    """Build or check the record; return the exit code."""
    arguments = parser(__doc__).parse_args()
    constraints = [constraint_facts(kind) for kind in KINDS]
    if unproved := [line for kind in KINDS for line in unproved_degrees(kind)]:
        return report(unproved, "")
    manifest = {
        "command": COMMAND,
        "versions": versions("sympy"),
        "sha256": canonical_sha256(constraints),
    }
    text = json.dumps(
        {"manifest": manifest, "constraints": constraints}, indent=1, ensure_ascii=False
    )
    confirmed = f"{len(constraints)} kinds of constraint, each with its lowest degrees"
    return save({TARGET: text + "\n"}, check=arguments.check, confirmed=confirmed)


if __name__ == "__main__":
    sys.exit(main())
