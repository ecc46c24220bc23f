"""Paths from the stored start system of a structure, or from a solved platform of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gspcli.certification.equations.mirror_images import with_mirror_images
from gspcli.solver.ends import Ends
from gspcli.solver.problem import Problem

if TYPE_CHECKING:
    from gspcli.continuation.quadrics import ComplexArray
    from gspcli.continuation.start import StartSystem
    from gspcli.continuation.systems import Structure
    from gspcli.continuation.tracked_paths import TrackedPaths
    from gspcli.continuation.tracker_options import TrackerOptions


def reduced_paths(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of paths with fewer unknowns, of equations without products."""
    from gspcli.continuation.reduced_homotopy import ends_from_start
    from gspcli.solver.starts.platform_starts import planar_starts

    structure, given = problem.equations
    targets, structure = given.g[:, list(structure.order)], structure.canonical()
    for start in planar_starts(problem.arrangement.normalized):
        if (planar := _planar_ends(problem, start, targets[0])) is not None:
            yield Ends(planar[None, None], problem.frames, has_directions=True)
    for start, options in _ways(problem, structure):
        found = [ends_from_start(start, quadrics, options) for quadrics in targets]
        ends = [points for points in found if points is not None]
        if len(ends) == len(found):
            yield Ends(np.array(ends)[None], problem.frames, has_directions=True)


def _planar_ends(problem: Problem, start: StartSystem, target: ComplexArray) -> ComplexArray | None:
    """Return the ends of paths from a planar platform: of one of each pair of mirror images."""
    from gspcli.continuation.reduced_homotopy import ends_from_start
    from gspcli.continuation.tracker_options import SHORT_STEPS

    if not problem.has_mirror_images:
        return ends_from_start(start, target, SHORT_STEPS)
    half = replace(start, points=start.points[: len(start.points) // 2])
    ends = ends_from_start(half, target, SHORT_STEPS)
    return None if ends is None else with_mirror_images(ends)


def _ways(problem: Problem, structure: Structure) -> Iterator[tuple[StartSystem, TrackerOptions]]:
    """Yield where reduced paths begin, and how long their steps are."""
    from gspcli.continuation.start import start_system
    from gspcli.continuation.tracker_options import FROM_START, LONG_STEPS
    from gspcli.solver.starts.platform_starts import structure_start

    if (start := structure_start(structure, problem.starts)) is not None:
        yield start, LONG_STEPS
    yield start_system(structure), FROM_START


def short_series(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of paths of products, with series of few terms."""
    from gspcli.continuation.tracked_paths import track_all
    from gspcli.continuation.tracker_options import SHORT

    if not problem.equations[0].is_product.any():
        return
    seed, jobs = problem.seed, problem.jobs
    yield ends_of(problem, list(track_all(problem.systems, seed=seed, jobs=jobs, options=SHORT)))


def careful_paths(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of all paths, followed with all the care that double precision allows."""
    yield ends_of(problem, problem.tracked)


def ends_of(problem: Problem, tracked: Sequence[TrackedPaths]) -> Ends:
    """Return the ends of paths for each choice of sides."""
    return Ends(np.stack([paths.first().points for paths in tracked])[None], problem.frames)
