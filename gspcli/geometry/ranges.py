"""The ranges of the values of each kind of constraint, and of the half angles of cones."""

from __future__ import annotations

import math
from fractions import Fraction

from gspcli.catalogue.kinds import Kind
from gspcli.geometry.instance import AngleUnit
from gspcli.geometry.numbers import Number

#: A quarter turn in each unit; the one in radians is only rounded.
_QUARTER = {AngleUnit.DEGREE: 90, AngleUnit.RADIAN: math.pi / 2}
#: Below this part of a quarter turn rounding does not matter.
_WELL_WITHIN = 0.999
_QUARTER_TEXT = {AngleUnit.DEGREE: ("90", "180"), AngleUnit.RADIAN: ("pi/2", "pi")}


def turns(value: Number, unit: AngleUnit) -> Fraction | float:
    """Return an angle in quarter turns, exactly if it is a rational number of degrees."""
    exact = value.fraction
    if exact is not None and unit is AngleUnit.DEGREE:
        return exact / 90
    quarters = value.value / _QUARTER[unit]
    # acos(-1) and pi are the same number with different roundings.
    near = round(quarters)
    return near if math.isclose(quarters, near, rel_tol=4e-16) else quarters


def wrong_value(kind: Kind, value: Number, unit: AngleUnit) -> str:
    """Return what is wrong with the value of a constraint, or nothing.

    A distance is at least zero. The angle of two lines or two planes is that of their directions
    or normals, between 0 and 180 degrees. The angle of a line and a plane is between -90 and 90,
    positive if the line's direction points to the side of the plane's normal (Section 4).
    """
    if kind.is_distance:
        return "expected a distance of at least 0" if value.value < 0 else ""
    if 0 < value.value < _QUARTER[unit] * _WELL_WITHIN:
        return ""
    quarter, half = _QUARTER_TEXT[unit]
    quarters = turns(value, unit)
    if kind.platform is kind.base:
        if not 0 <= quarters <= 2:
            return f"expected an angle of {kind.short} from 0 to {half} ({unit.value})"
    elif not -1 <= quarters <= 1:
        return f"expected an angle of {kind.short} from -{quarter} to {quarter} ({unit.value})"
    return ""


def wrong_scale(scale: Number) -> str:
    """Return what is wrong with the scale of the values of a constraint, or nothing."""
    if -1 < scale.value < 1:
        return ""
    return "expected a number between -1 and 1: readings are multiplied by 1 + scale"


def value_range(kind: Kind, unit: AngleUnit) -> tuple[float, float]:
    """Return the least and the greatest value of a kind, planes signed, angles in their unit."""
    if kind.is_distance:
        return (-math.inf if kind.has_sides else 0.0), math.inf
    quarter = float(_QUARTER[unit])
    return (0.0, 2 * quarter) if kind.platform is kind.base else (-quarter, quarter)


def wrong_half_angle(value: Number, unit: AngleUnit) -> str:
    """Return what is wrong with the half angle of a cone, or nothing."""
    if 0 < turns(value, unit) < 2:
        return ""
    return f"expected a half angle above 0 and below {_QUARTER_TEXT[unit][1]} ({unit.value})"
