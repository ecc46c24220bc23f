"""Constraints that are several equations over the real numbers, and one over the complex ones.

Points at distance zero, a point on a line, and parallel directions are one equation each in the
paper (Section 4): a sum of squares, or the end of the range of a cosine. Over the complex numbers
it takes away one degree of freedom, over the reals two or three.
"""

from __future__ import annotations

from dataclasses import replace

from gspcli.catalogue.kinds import AHH, AHL, ALH, ALL, DHP, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.instance import AngleUnit, Constraint
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Vector

#: Angles, in degrees, at which two directions are parallel.
_STRAIGHT = {ALL: ("0", "180"), ALH: ("90",), AHL: ("90",), AHH: ("0", "180")}
_RIGHT = {AngleUnit.DEGREE: Number.of(90), AngleUnit.RADIAN: Number.of("pi/2")}
_ZERO, _ONE = Number.of(0), Number.of(1)
_AXES: tuple[Vector, ...] = ((_ONE, _ZERO, _ZERO), (_ZERO, _ONE, _ZERO), (_ZERO, _ZERO, _ONE))


def real_statement(row: Constraint, unit: AngleUnit) -> list[Constraint]:
    """Return the equations of a constraint for real poses, except the sense of a direction."""
    zero = row.value.fraction == 0
    if row.kind is DPP and zero:
        return [_of_zero(row, DPH, axis) for axis in _AXES]
    if row.kind is DPL and zero:
        return [_of_zero(row, DPH, normal) for normal in _normals(_direction(row.base))]
    if row.kind is DLP and zero:
        return [_of_zero(row, DHP, normal) for normal in _normals(_direction(row.platform))]
    if not row.kind.is_distance and _exactly(row.value, unit) in _STRAIGHT[row.kind]:
        platform = Line(row.platform.position, _direction(row.platform))
        return [
            replace(row, kind=ALL, platform=platform, base=base, value=_RIGHT[unit])
            for base in (Line(row.base.position, n) for n in _normals(_direction(row.base)))
        ]
    return [row]


def _exactly(value: Number, unit: AngleUnit) -> str:
    """Return an angle of 0, 90 or 180 degrees in degrees, and others in any form."""
    text = str(value)
    return text if unit is AngleUnit.DEGREE else {"pi": "180", "pi / 2": "90"}.get(text, text)


def _of_zero(row: Constraint, kind: Kind, normal: Vector) -> Constraint:
    """Return the distance zero from a plane through the point or the line of a constraint."""
    if kind is DPH:
        return replace(row, kind=kind, base=Plane(row.base.position, normal))
    return replace(row, kind=kind, platform=Plane(row.platform.position, normal))


def _direction(geometry: Geometry) -> Vector:
    if isinstance(geometry, Line):
        return geometry.direction
    if isinstance(geometry, Plane):
        return geometry.normal
    message = "a point has no direction"
    raise TypeError(message)


def _normals(direction: Vector) -> list[Vector]:
    """Return two independent vectors normal to a direction: its products with two axes."""
    largest = max(range(3), key=lambda k: abs(direction[k].value))
    i, j = (largest + 1) % 3, (largest + 2) % 3
    normals = []
    for k, other in ((i, j), (j, i)):
        normal = [_ZERO] * 3
        normal[largest], normal[k] = _negated(direction[k]), direction[largest]
        normal[other] = _ZERO
        normals.append((normal[0], normal[1], normal[2]))
    return normals


def _negated(number: Number) -> Number:
    exact = number.fraction
    return Number("neg", (number,)) if exact is None else Number.of(-exact)
