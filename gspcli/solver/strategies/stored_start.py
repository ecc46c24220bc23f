"""Paths from solved platforms of the same structure, kept or shipped: the shortest first."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gspcli.continuation.shifts import FROM_START, LONG_STEPS, ends_from_start
from gspcli.continuation.start import start_system
from gspcli.solver.ledger import Ends
from gspcli.solver.problem import Problem
from gspcli.solver.reference_start import pursue_near, reference_start


def quick_paths(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of paths with fewer unknowns."""
    structure, given = problem.equations
    given = given.g[:, list(structure.order)]
    structure = structure.canonical()
    reference = reference_start(structure)
    ways = [(start_system(structure), FROM_START)]
    if reference is not None:
        ways.insert(0, (reference.start, LONG_STEPS))
    for start, options in ways:
        found = [ends_from_start(start, quadrics, options) for quadrics in given]
        ends = [points for points in found if points is not None]
        if len(ends) == len(found):
            yield Ends(np.array(ends), problem.frames)


def short_series(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of paths with products, whose series have few terms."""
    structure, given = problem.canonical
    if not structure.is_product.any():
        return
    from gspcli.continuation.parameter_homotopy import SHORT
    from gspcli.continuation.pursuit import pursue
    from gspcli.solver.strategies.careful_paths import ends_of

    seed, jobs = problem.seed, problem.jobs
    reference = reference_start(structure)
    if reference is not None:
        near = pursue_near(reference, given, seed=seed, jobs=jobs, options=SHORT)
        yield ends_of(problem, list(near))
    yield ends_of(problem, list(pursue(problem.systems, seed=seed, jobs=jobs, options=SHORT)))
