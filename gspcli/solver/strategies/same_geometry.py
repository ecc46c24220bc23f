"""Paths from a solved platform of the same geometry, along which only the values change."""

from __future__ import annotations

from collections.abc import Iterator

from gspcli.solver.ends import Ends
from gspcli.solver.problem import Problem
from gspcli.solver.strategies.kept_geometry import kept_geometry


def same_geometry(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of paths from a start of the geometry, and its far poses, where it is kept."""
    geometry = kept_geometry(problem)
    # Where it has fewer poses than its type, its count is what says that these are all.
    if geometry is not None and (
        geometry.found == problem.expected or problem.geometry_count is not None
    ):
        yield geometry.quick_ends(problem.values)


def from_nearest(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of paths to sets of values, each from the nearest start."""
    if problem.start is not None:
        yield problem.start.quick_ends(problem.values, problem.jobs)


def by_short_steps(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of paths from the geometry's own start, with short steps."""
    start = problem.start
    ends = None if start is None else start.short_ends(problem.values, problem.jobs)
    if ends is not None:
        yield ends


def by_careful_steps(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of paths of the equations in all unknowns, from the geometry's own start."""
    if problem.start is not None:
        yield problem.start.careful_ends(problem.values, problem.jobs)
