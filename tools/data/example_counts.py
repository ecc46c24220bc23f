"""Count the complex solutions of the shipped instances and record them.

    python -m tools.data.example_counts [--check [--sample N]] [NAME ...]
    python -m tools.data.example_counts --check --groebner [--sample N] [NAME ...]

The complex counts are the package's own, modulo random primes (docs/exact-counts.md): `proved` says
whether that of the solutions with multiplicity holds for every prime. Of infinitely many the
dimension is recorded. Of the real platforms the same is counted with random values, too: the count
of the geometry.

With --groebner the record is compared with Gröbner bases by Singular modulo two other primes. They
are independent of the package's solvers, its counts and its statements of the constraints
(`quaternion_counts`); what holds between square roots, sines and cosines of an instance holds
modulo these primes, too (`homomorphisms`).

The real poses are those that the package's solver finds; `certified` says how many of the distinct
solutions are proved, with whether they are real, by interval arithmetic. Where a number is known
otherwise, both must agree.
"""

from __future__ import annotations

import json
import sys
from itertools import islice
from pathlib import Path
from typing import Any

from gspcli.certification.counting import (
    ExactCount,
    count_exactly,
    count_geometry,
    dimension_exactly,
)
from gspcli.cli.streams import progress
from gspcli.geometry.instance import Instance
from gspcli.resources import INSTANCE_FOLDERS
from gspcli.solver.api import solve
from gspcli.spec import load
from tools.oracle import singular
from tools.oracle.homomorphisms import fields
from tools.oracle.quaternion_counts import count as groebner_count
from tools.recording import ROOT, parser, report, sampled, save, sha256, versions

EXAMPLES, PLATFORMS = FOLDERS = tuple(ROOT / "data" / name for name in INSTANCE_FOLDERS)
RECORD = "expected.json"
COMMAND = "python -m tools.data.example_counts"

#: Real poses known from elsewhere: how many, and from where.
KNOWN: dict[str, tuple[int, str]] = {
    "example-6.8": (64, "the paper: Tables 1 and 2"),
    "dietmaier": (40, "P. Dietmaier 1998"),
    "no-real-pose": (0, "the triangle inequality, in the comment of the file"),
    "figure-2": (32, "4 real rotations, each with one real position for each choice of 3 signs"),
    "figure-3": (4, "2 real normals, 2 real turns, one position; in the comment of the file"),
    "fixture-3-2-1": (4, "2 real normals, 2 real turns, one position"),
}


def counts(path: Path) -> dict[str, Any]:
    """Return the record of one file."""
    instance = load(path)
    count = count_exactly(instance)
    own = _distinct_and_multiple(count)
    if not count.finite:
        own["dimension"], _ = dimension_exactly(instance)
    record = {
        "sha256": sha256(path.read_bytes()),
        "type": instance.type.id,
        **own,
        "proved": count.error == 0,
    }
    if path.parent == PLATFORMS:
        record["geometry"] = _distinct_and_multiple(count_geometry(instance))
    if count.finite:
        record |= real_poses(path, instance, record)
    return record


def _distinct_and_multiple(count: ExactCount) -> dict[str, Any]:
    if count.solutions is None:
        return {"dimension": None}
    if count.distinct is None or count.spurious is None or count.spurious_distinct is None:
        message = "distinct solutions were not counted"
        raise SystemExit(message)
    return {
        "dimension": 0,
        "complex": count.solutions - count.spurious,
        "distinct": count.distinct - count.spurious_distinct,
    }


def different_by_groebner(path: Path, record: dict[str, Any]) -> list[str]:
    """Return in what a record differs from what Gröbner bases modulo two primes give."""
    instance = load(path)
    differences = []
    for field in islice(fields(instance), 2):
        compared = {"": (groebner_count(instance, field), record)}
        if "geometry" in record:
            geometry = groebner_count(instance, field, generic=True)
            compared[" of the geometry"] = geometry, record["geometry"]
        for name, (found, recorded) in compared.items():
            known = {key: recorded.get(key) for key in found}
            if known != found:
                differences.append(
                    f"{path.parent.name}/{RECORD}: {path.stem}: counts{name}: {known}, "
                    f"{found} by Singular modulo {field.prime}"
                )
    return differences


def real_poses(path: Path, instance: Instance, exact: dict[str, Any]) -> dict[str, Any]:
    """Return the record of the real poses of an instance with finitely many.

    Of a platform for which the solver finds another number of poses nothing is recorded: its
    real poses are then not known. Of an example that is a failure.
    """
    name = path.stem
    found = solve(instance).counts
    if found.found != exact["distinct"]:
        if path.parent == PLATFORMS:
            return {}
        message = f"{name}: {found.found} poses found, {exact['distinct']} counted"
        raise SystemExit(message)
    record: dict[str, Any] = {"real": found.real, "certified": found.certified}
    if name in KNOWN:
        real, source = KNOWN[name]
        if real != found.real:
            message = f"{name}: the solver finds {found.real} real poses, but {real} by {source}"
            raise SystemExit(message)
        record["real_known_from"] = source
    return record


def main() -> int:
    """Compute the counts and write or compare the records; return the exit code."""
    options = parser(__doc__, sample=True)
    options.add_argument("--groebner", action="store_true", help="compare with Gröbner bases")
    options.add_argument("names", nargs="*", help="instance files (default: all)")
    arguments = options.parse_args()
    files = {path.stem: path for folder in FOLDERS for path in sorted(folder.glob("*.yaml"))}
    wanted = [name for name in files if name in arguments.names or not arguments.names]
    wanted = sampled(wanted, arguments.sample if arguments.check else None)
    records = {folder: _recorded(folder) for folder in FOLDERS}
    if arguments.groebner:
        bases = progress(wanted, total=len(wanted), label="computing Gröbner bases")
        differences = [
            difference
            for name in bases
            for difference in different_by_groebner(
                files[name], records[files[name].parent].get(name, {})
            )
        ]
        by = f"Singular {singular.version()}"
        return report(differences, f"counts of {len(wanted)} of {len(files)} files by {by}")
    for folder, entries in records.items():
        for name in [name for name in entries if files.get(name, folder).parent != folder]:
            del entries[name]
    for name in progress(wanted, total=len(wanted), label="counting solutions"):
        records[files[name].parent][name] = counts(files[name])
    documents = {
        folder / RECORD: {
            "manifest": {"command": COMMAND, "versions": versions("python-flint")},
            "examples": dict(sorted(entries.items())),
        }
        for folder, entries in records.items()
    }
    return save(
        {
            path: json.dumps(document, indent=1, ensure_ascii=False) + "\n"
            for path, document in documents.items()
        },
        check=arguments.check,
        confirmed=f"complex and real poses of {len(wanted)} of {len(files)} instance files",
    )


def _recorded(folder: Path) -> dict[str, Any]:
    path = folder / RECORD
    if not path.exists():
        return {}
    recorded: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))["examples"]
    return recorded


if __name__ == "__main__":
    sys.exit(main())
