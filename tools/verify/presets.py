"""How many paths each preset of the tracker loses, of random platforms (docs/path-tracking.md).

    python -m tools.verify.presets [--count N] [--record]

A path is lost if it does not arrive, or arrives where another one does. Rounding differs between
processors, and so do the last of these numbers.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.names import parse_type
from gspcli.continuation import tracker_options
from gspcli.continuation.endpoints import random_start
from gspcli.continuation.reduced_homotopy import ends_from_start
from gspcli.continuation.start import start_system
from gspcli.continuation.systems import System
from gspcli.continuation.tracker import PathStatus, track
from gspcli.defaults import SEED
from gspcli.geometry.random_instances import random_instance
from gspcli.solver.problem import Problem
from tools.recording import ROOT, save, with_section

PAGE = ROOT / "docs" / "path-tracking.md"
TYPES = ("6PP", "6D PP PP PH PH HP HP", "6PL", "6D PP PP PL PL LP LL", "DPL DLP DLP DHP DLL ALL")
#: The presets, what follows paths with them, and the types without products alone (True).
PRESETS = {
    "DEFAULT": ("all unknowns", False),
    "CAREFUL": ("all unknowns", False),
    "PARANOID": ("all unknowns", False),
    "SHORT": ("all unknowns", False),
    "FROM_START": ("fewer unknowns", True),
    "LONG_STEPS": ("fewer unknowns", True),
    "VALUE_STEPS": ("fewer unknowns", True),
    "SHORT_STEPS": ("fewer unknowns", True),
}
#: Study points of norm one with a larger cosine are the same.
_SAME = 1 - 1e-10


def lost(points: NDArray[np.complex128]) -> int:
    """Return how many of the ends (n, 8) are missing or another path's, too."""
    known = points[np.isfinite(points).all(axis=1)]
    known = known / np.linalg.norm(known, axis=1, keepdims=True)
    alike = np.abs(known.conj() @ known.T) > _SAME
    # The first of those that are alike is kept.
    repeated = int((np.tril(alike, -1)).any(axis=1).sum())
    return len(points) - len(known) + repeated


def ends(problem: Problem, preset: str) -> NDArray[np.complex128] | None:
    """Return the ends of all paths to a platform, (n, 8); None if its equations are not reduced."""
    options, reduced = getattr(tracker_options, preset), PRESETS[preset][1]
    given = problem.systems[0].canonical()
    structure = given.structure
    start = start_system(structure)
    if reduced:
        return ends_from_start(start, given.coefficients.g, options)
    balanced, _ = given.coefficients.balanced()
    target = System(structure, balanced.normalized())
    results = track(random_start(start, SEED, 0), target, start.points, options=options)
    points: NDArray[np.complex128] = results.points[0].copy()
    points[results.status[0] != PathStatus.REGULAR] = np.nan
    return points


def rows(count: int) -> Iterable[str]:
    """Yield a row for each preset, in Markdown."""
    yield "| preset | equations | paths | lost | of a million |"
    yield "|---|---|---:|---:|---:|"
    for preset, (equations, reduced) in PRESETS.items():
        total = missing = 0
        for name in TYPES:
            # Platforms with fewer unknowns have fewer paths.
            for k in range(20 * count if reduced else count):
                instance, _ = random_instance(parse_type(name), np.random.default_rng(k))
                problem = Problem(instance)
                if reduced and not problem.is_reducible:
                    continue
                found = ends(problem, preset)
                if found is not None:
                    total, missing = total + len(found), missing + lost(found)
        share = f"{1e6 * missing / total:.0f}" if missing else f"below {1e6 / total:.0f}"
        yield f"| `{preset}` | {equations} | {total} | {missing} | {share} |"


def main() -> int:
    """Print the table, and write it into the page if that is asked for."""
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("--count", type=int, default=100, help="platforms of each type")
    arguments.add_argument("--record", action="store_true", help="write the page")
    given = arguments.parse_args()
    table = "\n".join(rows(given.count))
    print(table)
    if not given.record:
        return 0
    page = with_section(PAGE, "presets", table)
    return save({PAGE: page}, check=False, confirmed="table of presets")


if __name__ == "__main__":
    raise SystemExit(main())
