"""Platforms from rows of kind, primitives and value, solved."""

from __future__ import annotations

from typing import Any

from gspcli.catalogue.kinds import KINDS_BY_NAME
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Point, vector
from gspcli.solver import SolveResult, solve

ORIGIN, X, Y, Z = (vector(*v) for v in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)))
P = Point(ORIGIN)


def at(x: object, y: object, z: object) -> Point:
    return Point(vector(x, y, z))


def solved(*rows: tuple[Any, ...]) -> SolveResult:
    constraints = tuple(
        Constraint(KINDS_BY_NAME[kind], platform, base, Number.of(value), *rest)
        for kind, platform, base, value, *rest in rows
    )
    result = solve(Instance(constraints, Units("m", AngleUnit.DEGREE)))
    assert int(result.multiplicity.sum()) == result.account.found
    return result


def angles(value: float) -> tuple[tuple[Any, ...], ...]:
    """The angles of Example 6.2: three orthogonal lines each; eight rotations for 60 degrees."""
    return tuple(("ALL", Line(ORIGIN, d), Line(ORIGIN, d), value) for d in (Z, Y, X))


def cylinders(*radii: float) -> tuple[tuple[Any, ...], ...]:
    return tuple(("DPL", P, Line(ORIGIN, d), r) for d, r in zip((Z, Y, X), radii, strict=True))


def spheres(*rows: tuple[Point, float]) -> tuple[tuple[Any, ...], ...]:
    return tuple(("DPP", P, centre, radius) for centre, radius in rows)
