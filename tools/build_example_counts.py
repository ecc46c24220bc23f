"""Count the complex solutions of the shipped instances by Gröbner bases and record them.

    python tools/build_example_counts.py [--check [--sample N]] [NAME ...]

The complex counts (`quaternion_counts`) are independent of the package's solvers and of its
statements of the constraints (`gspcli.geometry.constraint_polynomials`); two primes must agree.
What holds between square roots, sines and cosines of an instance holds modulo these primes, too
(`homomorphisms`). Of the real platforms the same is also counted with random values: the count of
the geometry.

The real poses are those that the package's solver finds; `certified` says how many of the distinct
solutions are proved, with whether they are real, by interval arithmetic. That the list is complete
rests on the count modulo primes, which is evidence and no proof over the rationals; a proved bound
that equals it (`gsp check`) makes it one. Where a number is known otherwise, both must agree.
"""

from __future__ import annotations

import hashlib
import json
import platform
import sys
from itertools import islice
from pathlib import Path
from typing import Any

import singular
import sympy
from homomorphisms import fields
from quaternion_counts import count
from recording import ROOT, parser, sampled, save

sys.path.insert(0, str(ROOT))

from gspcli.cli.progress_bars import progress
from gspcli.geometry.instance import Instance
from gspcli.resources import INSTANCE_FOLDERS
from gspcli.solver.api import solve
from gspcli.spec import load

EXAMPLES, PLATFORMS = FOLDERS = tuple(ROOT / "data" / name for name in INSTANCE_FOLDERS)
RECORD = "expected.json"
COMMAND = "python tools/build_example_counts.py"

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
    """Return the record of one file: the same modulo two primes."""
    instance = load(path)
    results: dict[int, dict[str, int]] = {}
    geometry: dict[int, dict[str, int]] = {}
    for field in islice(fields(instance), 2):
        results[field.prime] = count(instance, field)
        if path.parent == PLATFORMS:
            geometry[field.prime] = count(instance, field, generic=True)
    first = _agreeing(path, results)
    record = {
        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "type": instance.type.id,
        **first,
        "primes": list(results),
    }
    if geometry:
        record["geometry"] = _agreeing(path, geometry)
    if first["dimension"] == 0:
        record |= real_poses(path, instance, first)
    return record


def _agreeing(path: Path, results: dict[int, dict[str, int]]) -> dict[str, int]:
    first, second = results.values()
    if first != second:
        message = f"{path.name}: the primes disagree: {results}"
        raise SystemExit(message)
    return first


def real_poses(path: Path, instance: Instance, exact: dict[str, int]) -> dict[str, Any]:
    """Return the record of the real poses of an instance with finitely many.

    Of a platform for which the solver finds another number of poses nothing is recorded: its
    real poses are then not known. Of an example that is a failure.
    """
    name = path.stem
    found = solve(instance).counts
    if found.found != exact["distinct"]:
        if path.parent == PLATFORMS:
            return {}
        message = f"{name}: {found.found} poses found, {exact['distinct']} by the Gröbner basis"
        raise SystemExit(message)
    record = {"real": found.real, "certified": found.certified}
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
    options.add_argument("names", nargs="*", help="instance files (default: all)")
    arguments = options.parse_args()
    files = {path.stem: path for folder in FOLDERS for path in sorted(folder.glob("*.yaml"))}
    wanted = [name for name in files if name in arguments.names or not arguments.names]
    wanted = sampled(wanted, arguments.sample if arguments.check else None)
    records = {folder: _recorded(folder) for folder in FOLDERS}
    for folder, entries in records.items():
        for name in [name for name in entries if files.get(name, folder).parent != folder]:
            del entries[name]
    for name in progress(wanted, total=len(wanted), label="counting solutions"):
        records[files[name].parent][name] = counts(files[name])
    versions = {
        "Singular": singular.version(),
        "sympy": sympy.__version__,
        "python": platform.python_version(),
    }
    documents = {
        folder / RECORD: {
            "manifest": {"command": COMMAND, "versions": versions},
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
