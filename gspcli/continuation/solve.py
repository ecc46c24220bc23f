"""All solutions of a target system, with an account of every path."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from gspcli.continuation.solutions import SystemSolutions
from gspcli.continuation.systems import System
from gspcli.continuation.tracked_paths import track_all
from gspcli.continuation.tracker_options import DEFAULT, TrackerOptions
from gspcli.defaults import SEED


def solve_system(
    target: System,
    *,
    seed: int = SEED,
    jobs: int = 1,
    options: TrackerOptions = DEFAULT,
) -> SystemSolutions:
    """Return all isolated solutions of a system, and evidence of any others.

    Parameters
    ----------
    target
        The system.
    seed
        The seed of the random complex paths. Another seed gives the same set of solutions.
    jobs
        Threads. The result does not depend on them.
    options
        Settings of the first attempt; lost paths are tracked again with `CAREFUL` and `PARANOID`.

    Raises
    ------
    ValueError
        If more than three equations are of space a.
    """
    return next(solve_systems([target], seed=seed, jobs=jobs, options=options))


def solve_systems(
    targets: Iterable[System],
    *,
    seed: int = SEED,
    jobs: int = 1,
    options: TrackerOptions = DEFAULT,
) -> Iterator[SystemSolutions]:
    """Yield the solutions of many systems, in order, as they become known.

    Each result is that of `solve_system`. Consecutive systems of one structure are tracked
    together, which is quicker than a loop.
    """
    for tracked_paths in track_all(targets, seed=seed, jobs=jobs, options=options):
        yield tracked_paths.solutions()
