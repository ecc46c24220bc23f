"""Derive equations, degrees and loci of the ten kinds of constraint and record them in the data.

    python tools/build_constraints.py [--check]

Every recorded degree is proved to be the lowest before it is written. With ``--check`` the record
is compared instead of written.
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
from pathlib import Path

import sympy
from build_varieties import digest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from gspcli.catalogue.kinds import KINDS
from gspcli.symbolic.facts import constraint_facts, unproved_degrees

TARGET = Path(__file__).resolve().parents[1] / "data" / "constraints.json"
COMMAND = "python tools/build_constraints.py"


def main() -> int:
    """Build or check the record; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare with the record")
    arguments = parser.parse_args()
    constraints = [constraint_facts(kind) for kind in KINDS]
    unproved = [line for kind in KINDS for line in unproved_degrees(kind)]
    if unproved:
        print("\n".join(unproved), file=sys.stderr)
        return 1
    if arguments.check:
        recorded = json.loads(TARGET.read_text(encoding="utf-8"))["constraints"]
        if recorded != constraints:
            print(f"{TARGET.name} differs from the derivation", file=sys.stderr)
            return 1
        print(f"{TARGET.name}: {len(constraints)} kinds confirmed")
        return 0
    manifest = {
        "command": COMMAND,
        "versions": {"sympy": sympy.__version__, "python": platform.python_version()},
        "sha256": digest(constraints),
    }
    text = json.dumps(
        {"manifest": manifest, "constraints": constraints}, indent=1, ensure_ascii=False
    )
    TARGET.write_text(text + "\n", encoding="utf-8")
    for facts in constraints:
        print(facts["kind"], facts["lowest"])
    return 0


if __name__ == "__main__":
    sys.exit(main())
