"""Build `data/start-systems/`: solved generic systems of the 119 families of six quadrics.

Every family is solved by monodromy from several seeds, each from its own random system and point;
all seeds must find the same number of solutions and each passes a trace test. The first seed's
solutions are tracked to the systems that are stored. The same command gives the same bytes.

    python tools/build_start_systems.py --output data/start-systems
"""

from __future__ import annotations

import argparse
import hashlib
import json
import platform
import sys
import time
from pathlib import Path

import numpy as np

from gspcli.continuation.monodromy import (
    SolvedFamily,
    move,
    random_phases,
    random_quadrics,
    solve_family,
)
from gspcli.continuation.quadrics import LETTERS, ComplexArray
from gspcli.continuation.start import canonical_families, distinct, generic_factors, pack_points
from gspcli.continuation.systems import EQUATIONS

SEEDS = (1, 2, 3)


def stored_factors(seed: int) -> ComplexArray:
    """Return random quadrics in single precision: first and second, by equation and letter."""
    rng = np.random.default_rng([seed, 0])
    rows = [[random_quadrics(LETTERS, rng) for _ in range(EQUATIONS)] for _ in range(2)]
    return np.array(rows).astype(np.complex64)


def solutions_of_stored(
    families: str, solved: SolvedFamily, factors: ComplexArray, rng: np.random.Generator
) -> ComplexArray:
    """Track the solutions of a solved system to the stored system of its family."""
    target = generic_factors(factors.astype(np.complex128), families)[0]
    for _ in range(5):
        start = solved.quadrics * random_phases(rng, EQUATIONS, 1)
        ends = move(start, target, solved.points)
        if len(ends) == len(solved.points) and distinct(ends):
            return ends
    message = f"{families}: solutions lost on the way to the stored system"
    raise SystemExit(message)


def main() -> None:
    """Solve, compare, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, required=True)
    folder: Path = parser.parse_args().output
    began = time.monotonic()
    factors = stored_factors(SEEDS[0])
    counts: dict[str, int] = {}
    points, loops = [], 0
    for number, families in enumerate(canonical_families()):
        solved = [solve_family(families, np.random.default_rng([s, number + 1])) for s in SEEDS]
        found = [len(s.points) for s in solved]
        if len(set(found)) != 1:
            message = f"{families}: the seeds {SEEDS} disagree: {found}"
            raise SystemExit(message)
        rng = np.random.default_rng([SEEDS[0], number + 1, 1])
        counts[families] = found[0]
        points.append(pack_points(solutions_of_stored(families, solved[0], factors, rng)))
        loops += sum(s.loops for s in solved)
    folder.mkdir(parents=True, exist_ok=True)
    np.save(folder / "factors.npy", factors)
    np.save(folder / "points.npy", np.concatenate(points))
    manifest = {
        "what": "generic systems of six quadrics on the Study quadric with all their solutions",
        "command": "python tools/build_start_systems.py --output data/start-systems",
        "seeds": list(SEEDS),
        "agreement": "every seed gave every count; every trace test had a defect below 1e-8",
        "versions": {"numpy": np.__version__, "python": platform.python_version()},
        "sha256": {
            name: hashlib.sha256((folder / name).read_bytes()).hexdigest()
            for name in ("factors.npy", "points.npy")
        },
        "solutions": sum(counts.values()),
        "counts": counts,
    }
    text = json.dumps(manifest, indent=1) + "\n"
    (folder / "manifest.json").write_text(text, encoding="utf-8")
    sys.stderr.write(
        f"{len(counts)} families, {sum(counts.values())} solutions, {loops} loops, "
        f"{time.monotonic() - began:.0f} s\n"
    )


if __name__ == "__main__":
    main()
