"""What the values of constraints may be, and which values are special."""

from __future__ import annotations

import math
from fractions import Fraction

from gspcli.catalogue.kinds import DLL, DLP, DPL, DPP, Kind
from gspcli.geometry.instance import AngleUnit, Constraint, Instance
from gspcli.geometry.numbers import Number

#: A quarter turn in each unit; the one in radians is only rounded.
_QUARTER = {AngleUnit.DEGREE: 90, AngleUnit.RADIAN: math.pi / 2}
_QUARTER_TEXT = {AngleUnit.DEGREE: ("90", "180"), AngleUnit.RADIAN: ("pi/2", "pi")}


def _turns(value: Number, unit: AngleUnit) -> Fraction | float:
    """Return an angle in quarter turns, exactly if it is a rational number of degrees."""
    exact = value.fraction
    if exact is not None and unit is AngleUnit.DEGREE:
        return exact / 90
    turns = value.value / _QUARTER[unit]
    # acos(-1) and pi are the same number however it is rounded.
    return round(turns) if math.isclose(turns, round(turns), rel_tol=4e-16) else turns


def wrong_value(kind: Kind, value: Number, unit: AngleUnit) -> str:
    """Return what is wrong with the value of a constraint, or nothing.

    A distance is at least zero. The angle of two lines or two planes (of their directions or
    normals) is between 0 and 180 degrees, that of a line and a plane between -90 and 90: positive
    if the line's direction points to the side of the plane's normal (Section 4).
    """
    if kind.is_distance:
        return "expected a distance of at least 0" if value.value < 0 else ""
    quarter, half = _QUARTER_TEXT[unit]
    turns = _turns(value, unit)
    if kind.platform is kind.base:
        if not 0 <= turns <= 2:
            return f"expected an angle of {kind.short} from 0 to {half} ({unit.value})"
    elif not -1 <= turns <= 1:
        return f"expected an angle of {kind.short} from -{quarter} to {quarter} ({unit.value})"
    return ""


def equations(constraint: Constraint, unit: AngleUnit) -> int:
    """Return how many equations a constraint really is: its valence (Section 2), mostly one.

    Distance 0 makes two points equal (three equations) and puts a point on a line (two); lines or
    planes that are parallel, and a line perpendicular to a plane, are two equations.
    """
    kind = constraint.kind
    if kind.is_distance:
        if constraint.value.value != 0:
            return 1
        return {DPP: 3, DPL: 2, DLP: 2}.get(kind, 1)
    turns = _turns(constraint.value, unit)
    special = (0, 2) if kind.platform is kind.base else (-1, 1)
    return 2 if turns in special else 1


def remarks(instance: Instance) -> list[tuple[int, str]]:
    """Return what is unusual about an instance: constraint indices from 0 and a sentence each."""
    found: list[tuple[int, str]] = []
    for index, constraint in enumerate(instance.constraints):
        kind, value = constraint.kind, constraint.value
        count = equations(constraint, instance.units.angle)
        if count > 1:
            message = (
                f"{kind.name} with value {value} is {count} equations, not one (Section 2): "
                "the solution set need not be finite, or the count lower"
            )
            found.append((index, message))
        elif kind.is_distance and value.value == 0:
            if kind.has_sides:
                message = f"{kind.name} with value 0 has no sides: both are the same solutions"
                found.append((index, message))
            elif kind is DLL:
                message = "DLL with value 0: the lines meet, every solution is a double one"
                found.append((index, message))
    return found
