"""The degrees of constraints: as the paper writes them, of differences, and the lowest.

The equations are those of `gspcli.symbolic.constraint_equations`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import sympy
from sympy import Expr, Symbol

from gspcli.catalogue.kinds import Kind
from gspcli.records import dataclass
from gspcli.symbolic.constraint_equations import (
    SymbolicEquation,
    equation,
    equations,
    setting,
    written_equation,
)
from gspcli.symbolic.coordinate_systems import MOTIONS, SYSTEMS, CoordinateSystem
from gspcli.symbolic.forms import RHO, degree


def difference_degree(kind: Kind, weights: Mapping[str, int]) -> int | None:
    """Return the degree of the difference of two constraints of a kind.

    It is lower than that of one constraint if their leading forms agree for any geometry: |T|² for
    DPP (the argument of Theorem 5.3).
    """
    degrees = (degree(form, weights) for form in _differences(kind))
    return min((d for d in degrees if d is not None), default=None)


@cache
def _differences(kind: Kind) -> tuple[Expr, ...]:
    """Return the differences of two constraints of a kind with different geometry."""
    differences = []
    for candidate in equations(kind):
        form = candidate.left - candidate.right
        renamed = form.xreplace(
            {symbol: Symbol(f"{symbol}'") for symbol in form.free_symbols if symbol != RHO}
        )
        differences.append(sympy.expand(form - renamed))
    return tuple(differences)


def paper_degree(kind: Kind, coordinates: CoordinateSystem, *, one_sided: bool = False) -> int:
    """Return the degree of the equation as the paper writes it (Section 4, Proposition 4.1).

    The paper writes every constraint in R and T and reads off the degree, except DPP, which it
    first rewrites in U and, in Mourrain's coordinates, ρ (equations (5) and (6)).
    """
    if not setting(kind).directions:
        found = equation(kind, coordinates.degrees)
        assert found is not None, coordinates
        return found[1]
    written = written_equation(kind, one_sided=one_sided)
    return int(sympy.Poly(written, *MOTIONS.symbols).total_degree())


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
