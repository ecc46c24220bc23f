"""Paths from a solved platform of the same geometry: only the values move; far poses hardly do."""

from __future__ import annotations

from collections.abc import Iterator

from gspcli.solver.kept_geometry import kept_geometry
from gspcli.solver.ledger import Ends
from gspcli.solver.problem import Problem


def same_geometry(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of paths from a start of the geometry, and its far poses, where it is kept."""
    geometry = kept_geometry(problem)
    # Where it has fewer poses than its type, its count is what says that these are all.
    if geometry is not None and (
        geometry.found == problem.expected or problem.geometry_count is not None
    ):
        points, unit = geometry.quick_ends(problem.arrangement.values[None], 1)
        ends = geometry.ends(points, unit)
        yield Ends(ends.points[0], ends.frames, ends.far, ends.local)
