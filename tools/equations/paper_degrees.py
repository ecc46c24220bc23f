"""The degrees of constraints as the paper writes them, and of differences of two constraints."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import sympy
from sympy import Expr, Matrix, Symbol

from gspcli.catalogue.kinds import Kind, Primitive
from tools.equations.constraint_equations import (
    DISTANCE,
    MOTIONS,
    RHO,
    CoordinateSystem,
    Vector,
    VectorFrame,
    angle_value,
    degree,
    equation,
    equations,
    setting,
)

#: Components for `written_equation`: special vectors could only lower the degree.
_COMPONENTS = {
    "Y": Matrix([2, 3, 5]),
    "X": Matrix([7, -3, 1]),
    "B": Matrix([1, 4, -2]),
    "A": Matrix([-5, 2, 3]),
    "v": Matrix([2, -1, 7]),
    "u": Matrix([3, 5, -1]),
}


def written_equation(
    kind: Kind, *, one_sided: bool = False, components: Mapping[str, Matrix] = _COMPONENTS
) -> Expr:
    """Return the paper's equation (Section 4) as a polynomial in the entries of R and T.

    It is to be zero; nothing in it is reduced by the equations of the rigid motions.
    """
    rotation, translation = MOTIONS.expressions["R"], MOTIONS.expressions["T"]
    where = setting(kind)

    def carried(vector: Vector) -> Matrix:
        column = components[str(vector.name)]
        return rotation * column if vector.frame is VectorFrame.PLATFORM else column

    offset = carried(where.platform.point) + translation - carried(where.base.point)
    axes = [carried(axis) for axis in where.axes]
    if not kind.is_distance:
        return axes[0].dot(axes[1]) - angle_value(kind)
    if kind.has_sides:
        above = 1 if kind.base is Primitive.PLANE else -1
        height = above * offset.dot(axes[0])
        return height - DISTANCE if one_sided else height**2 - DISTANCE**2
    if len(axes) == 1:
        moment = offset.cross(axes[0])
        return moment.dot(moment) - DISTANCE**2
    if len(axes) == 2:
        normal = axes[0].cross(axes[1])
        return offset.dot(normal) ** 2 - DISTANCE**2 * normal.dot(normal)
    return offset.dot(offset) - DISTANCE**2


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
