"""Paths from a solved platform of the same geometry: only the values move."""

from __future__ import annotations

from collections.abc import Iterator

from gspcli.solver.kept_geometry import kept_geometry
from gspcli.solver.ledger import Ends
from gspcli.solver.problem import Problem


def same_geometry(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of paths from a start of the geometry, where one is kept."""
    geometry = kept_geometry(problem)
    if geometry is not None:
        points, unit = geometry.quick_ends(problem.arrangement.values[None], 1)
        yield Ends(points.reshape(len(geometry.choices), -1, 8), geometry.frames(unit))
