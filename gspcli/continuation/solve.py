"""All solutions of a target system, with an account of every path."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from gspcli.continuation.solutions import SystemSolutions
from gspcli.continuation.systems import System
from gspcli.continuation.tracked_paths import track_all
from gspcli.continuation.tracker_options import DEFAULT, TrackerOptions
from gspcli.defaults import SEED


def solve_systems(
    targets: Iterable[System],
    *,
    seed: int = SEED,
    jobs: int = 1,
    options: TrackerOptions = DEFAULT,
) -> Iterator[SystemSolutions]:
    """Yield the solutions of many systems, in order, as they become known.

    Each result has all isolated solutions, and evidence of any others. Consecutive systems of one
    structure are tracked together, which is quicker than a loop. Lost paths are tracked again with
    `CAREFUL` and `PARANOID`. Another seed gives the same solutions.
    """
    for tracked_paths in track_all(targets, seed=seed, jobs=jobs, options=options):
        yield tracked_paths.solutions()
