"""Count the solutions of Stewart platforms with shared joints, and record them in the data.

    python -m tools.data.coincident_counts [--check [--sample N]] [--groebner]

The six legs of a platform (six DPP) may share joints in many ways and still fix it. For each way
two platforms are counted: a random one, and one whose joints lie in a plane on each body. They are
counted modulo a random prime (docs/exact-counts.md). With --groebner they are counted by Gröbner
bases modulo two other primes instead, which share nothing with the package. J. C. Faugère, D.
Lazard, *Combinatorial classes of parallel manipulators*, 1995, treat the same classes.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np

from gspcli import dumps
from gspcli.catalogue.coincidence import Sharing, coincident_types, over_constraint
from gspcli.catalogue.kinds import DPP
from gspcli.catalogue.types import CONSTRAINTS, GspType
from gspcli.certification.counting import count_exactly
from gspcli.cli.streams import progress
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance
from gspcli.geometry.random_instances import random_instance
from tools.oracle import singular
from tools.oracle.homomorphisms import fields
from tools.oracle.quaternion_counts import count as groebner_count
from tools.recording import ROOT, csv_text, parser, report, sampled, save, sha256, versions

TARGET = ROOT / "tests" / "oracles" / "records" / "coincident-platforms.csv"
COMMAND = "python -m tools.data.coincident_counts"


def platforms() -> Iterator[tuple[Sharing, bool, Instance]]:
    """Yield the patterns that can fix the platform, spatial and planar, with an instance each."""
    for sharing in coincident_types(GspType.of((DPP,) * CONSTRAINTS)):
        if over_constraint(sharing.bonds) is not None:
            continue
        for planar in (False, True):
            rng = np.random.default_rng([SEED, sharing.index, planar])
            yield sharing, planar, random_instance(sharing.bonds, rng, planar=planar)[0]


def record(sharing: Sharing, planar: bool, instance: Instance) -> dict[str, object]:
    """Return the row of an instance."""
    count = count_exactly(instance)
    if not count.finite:
        message = f"{sharing.id}: infinitely many solutions"
        raise SystemExit(message)
    return {
        "id": sharing.id,
        "pattern": sharing.notation,
        "on_platform": len(sharing.platform_primitives),
        "on_base": len(sharing.base_primitives),
        "planar": int(planar),
        "dimension": 0,
        "complex": count.solutions,
        "distinct": count.distinct,
        "instance_sha256": sha256(dumps(instance)),
    }


def different_by_groebner(row: dict[str, str], instance: Instance) -> list[str]:
    """Return in what a row differs from Gröbner bases modulo two primes."""
    recorded = {key: int(row[key]) for key in ("complex", "distinct")} if row else {}
    found = {field.prime: groebner_count(instance, field) for field in islice(fields(instance), 2)}
    return [
        f"{TARGET.name}: {row.get('id')}: {recorded}, {counts} by Singular modulo {prime}"
        for prime, counts in found.items()
        if counts != {"dimension": 0, **recorded}
    ]


def compare_with_groebner(wanted: Sequence[tuple[Sharing, bool, Instance]]) -> int:
    """Compare recorded rows with Gröbner bases; return the exit code."""
    with TARGET.open(encoding="utf-8", newline="") as file:
        rows = {(row["id"], row["planar"]): row for row in csv.DictReader(file)}
    differences = [
        difference
        for sharing, planar, instance in progress(
            wanted, total=len(wanted), label="computing Gröbner bases"
        )
        for difference in different_by_groebner(
            rows.get((sharing.id, str(int(planar))), {}), instance
        )
    ]
    by = f"poses of {len(wanted)} platforms with shared joints by Singular {singular.version()}"
    return report(differences, by)


def main() -> int:
    """Count, and write or compare the record; return the exit code."""
    options = parser(__doc__, sample=True)
    options.add_argument("--groebner", action="store_true", help="compare with Gröbner bases")
    arguments = options.parse_args()
    wanted = list(platforms())
    if arguments.groebner:
        return compare_with_groebner(sampled(wanted, arguments.sample))
    table = [record(*p) for p in progress(wanted, total=len(wanted), label="counting solutions")]
    text = csv_text(table)
    manifest = {
        "command": COMMAND,
        "seed": SEED,
        "sha256": sha256(text),
        "versions": versions("python-flint", "numpy"),
    }
    document = json.dumps(manifest, indent=1) + "\n"
    return save(
        {TARGET: text, TARGET.with_suffix(".manifest.json"): document},
        check=arguments.check,
        confirmed=f"poses of {len(table)} platforms with shared joints",
    )


if __name__ == "__main__":
    sys.exit(main())
