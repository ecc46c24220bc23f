"""The degrees of constraints: as the paper writes them, of differences, and the lowest.

The equations are those of `gspcli.symbolic.constraint_equations`.
"""

from __future__ import annotations

from gspcli.catalogue.kinds import Kind
from gspcli.records import dataclass
from gspcli.symbolic.constraint_equations import (
    SymbolicEquation,
    equation,
)
from gspcli.symbolic.coordinate_systems import SYSTEMS, CoordinateSystem


@dataclass(frozen=True)
class LowestDegree:
    """The lowest degree of a constraint and the smallest coordinates in which it is reached.

    Attributes
    ----------
    degree
        The degree.
    coordinates
        The coordinates.
    equation
        The equation.
    """

    degree: int
    coordinates: CoordinateSystem
    equation: SymbolicEquation


def lowest_degree(kind: Kind, *, one_sided: bool = False) -> LowestDegree:
    """Search the coordinates for the lowest degree of a constraint; the smallest ones win."""
    best: LowestDegree | None = None
    for coordinates in SYSTEMS:
        found = equation(kind, coordinates.degrees, one_sided=one_sided)
        if found is not None and (best is None or found[1] < best.degree):
            best = LowestDegree(found[1], coordinates, found[0])
    assert best is not None, kind
    return best
