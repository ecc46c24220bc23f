"""Count the solutions of Stewart platforms with shared joints, and record them in the data.

    python tools/build_coincident_counts.py [--check]

For each way in which the six legs of a platform (six DPP) may share joints and still fix it, a
random platform, and one whose joints lie in a plane on each body, are solved by Gröbner bases
modulo two primes, as the example instances are. Independent of the package's solvers.
J. C. Faugère, D. Lazard, *Combinatorial classes of parallel manipulators*, 1995, treat the same
classes.
"""

from __future__ import annotations

import hashlib
import json
import platform as machine
import sys
from collections.abc import Iterator
from itertools import islice

import numpy as np
import singular
import sympy
from homomorphisms import fields
from quaternion_counts import count
from recording import ROOT, csv_text, parser, save

sys.path.insert(0, str(ROOT))

from gspcli import dumps
from gspcli.catalogue.coincidence import Sharing, coincident_types
from gspcli.catalogue.kinds import DPP
from gspcli.catalogue.overconstraint import over_constraint
from gspcli.catalogue.types import CONSTRAINTS, GspType
from gspcli.cli.progress_bars import progress
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance
from gspcli.solver.generate import random_instance

TARGET = ROOT / "data" / "verification" / "coincident-platforms.csv"
COMMAND = "python tools/build_coincident_counts.py"


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
    first, second = (count(instance, field) for field in islice(fields(instance), 2))
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


def main() -> int:
    """Count, and write or compare the record; return the exit code."""
    arguments = parser(__doc__).parse_args()
    wanted = list(platforms())
    table = [record(*p) for p in progress(wanted, total=len(wanted), label="counting solutions")]
    text = csv_text(table)
    manifest = {
        "command": COMMAND,
        "seed": SEED,
        "sha256": hashlib.sha256(text.encode()).hexdigest(),
        "versions": {
            "Singular": singular.version(),
            "numpy": np.__version__,
            "sympy": sympy.__version__,
            "python": machine.python_version(),
        },
    }
    document = json.dumps(manifest, indent=1) + "\n"
    return save(
        {TARGET: text, TARGET.with_suffix(".manifest.json"): document},
        check=arguments.check,
        confirmed=f"poses of {len(table)} platforms with shared joints",
    )


if __name__ == "__main__":
    sys.exit(main())
