"""Count the solutions of Stewart platforms with shared joints, and record them in the data.

    python tools/build_coincident_counts.py [--check]

For each way in which the six legs of a platform (six DPP) may share joints and still fix it, a
random platform, and one whose joints lie in a plane on each body, are solved by Gröbner bases
modulo two primes, as the example instances are. Independent of the package's solvers.
J. C. Faugère, D. Lazard, *Combinatorial classes of parallel manipulators*, 1995, treat the same
classes. With ``--check`` the record is compared instead of written.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import io
import json
import platform as machine
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import sympy
from build_example_counts import FIRST_PRIME, count, singular_version

from gspcli import dumps
from gspcli.catalogue.coincidence import Sharing, coincident_types
from gspcli.catalogue.kinds import DPP
from gspcli.catalogue.overconstraint import over_constraint
from gspcli.catalogue.types import CONSTRAINTS, GspType
from gspcli.geometry.instance import Instance
from gspcli.solve.generate import random_instance

TARGET = Path(__file__).resolve().parents[1] / "data" / "verification" / "coincident-platforms.csv"
COMMAND = "python tools/build_coincident_counts.py"
SEED = 20031


def platforms() -> Iterator[tuple[Sharing, bool, Instance]]:
    """Yield the patterns that can fix the platform, spatial and planar, with an instance each."""
    for sharing in coincident_types(GspType.of((DPP,) * CONSTRAINTS)):
        if over_constraint(sharing.bonds) is not None:
            continue
        for planar in (False, True):
            rng = np.random.default_rng([SEED, sharing.index, planar])
            yield sharing, planar, random_instance(sharing.bonds, rng, planar=planar)[0]


def record(sharing: Sharing, planar: bool, instance: Instance) -> dict[str, object]:
    """Return the row of an instance: the same modulo two primes."""
    first, second = (count(instance, sympy.nextprime(FIRST_PRIME, k)) for k in (1, 2))
    if first != second:
        message = f"{sharing.id}: the primes disagree: {first}, {second}"
        raise SystemExit(message)
    return {
        "id": sharing.id,
        "pattern": sharing.notation,
        "on_platform": len(sharing.platform_primitives),
        "on_base": len(sharing.base_primitives),
        "planar": int(planar),
        **first,
        "instance_sha256": hashlib.sha256(dumps(instance).encode()).hexdigest(),
    }


def main() -> None:
    """Count, and write or compare the record."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="compare with the record")
    arguments = parser.parse_args()
    table = []
    for platform in platforms():
        table.append(record(*platform))
        print(table[-1], file=sys.stderr, flush=True)
    text = io.StringIO()
    writer = csv.DictWriter(text, list(table[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    if arguments.check:
        if TARGET.read_text(encoding="utf-8") != text.getvalue():
            sys.exit(f"{TARGET.name} does not hold these counts")
        return
    TARGET.parent.mkdir(parents=True, exist_ok=True)
    TARGET.write_text(text.getvalue(), encoding="utf-8")
    manifest = {
        "command": COMMAND,
        "seed": SEED,
        "sha256": hashlib.sha256(text.getvalue().encode()).hexdigest(),
        "versions": {
            "Singular": singular_version(),
            "numpy": np.__version__,
            "sympy": sympy.__version__,
            "python": machine.python_version(),
        },
    }
    document = json.dumps(manifest, indent=1) + "\n"
    TARGET.with_suffix(".manifest.json").write_text(document, encoding="utf-8")


if __name__ == "__main__":
    main()
