"""Checks of an instance: six constraints, at most three angles, values in range."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.catalogue.types import CONSTRAINTS, MAX_ANGLES
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.primitives import Point
from gspcli.geometry.ranges import wrong_half_angle, wrong_scale, wrong_value

#: The error for an offset of a distance to a plane without a side.
ONE_SIDE = "expected one only with a side: it is added to the signed distance"


def expected(instance: Instance) -> Instance:
    """Return an argument if it is an instance; its numbers are not checked.

    Raises
    ------
    ArgumentError
        If it is not.
    """
    if not isinstance(instance, Instance):
        message = f"found a {type(instance).__name__}, expected an Instance: load reads one"
        raise ArgumentError(message, "instance")
    return instance


def real_array(given: Any, name: str) -> NDArray[np.float64]:
    """Return numbers as an array of doubles; complex ones must be real.

    Raises
    ------
    ArgumentError
        If they are no real numbers.
    """
    try:
        array = np.asarray(given)
        if array.dtype.kind == "c" and not array.imag.any():
            array = array.real
        if array.dtype.kind in "cUS":
            raise TypeError
        return array.astype(float)
    except (TypeError, ValueError):
        what = f"a {type(given).__name__}"
        if isinstance(given, np.ndarray) and given.dtype.kind == "c":
            what = "complex numbers"
        raise ArgumentError(f"found {what}, expected an array of real numbers", name) from None


def checked(instance: Instance) -> Instance:
    """Return an instance if it has six constraints, at most three angles and values in range.

    Raises
    ------
    ArgumentError
        Naming the first constraint, from 0, that is wrong.
    """
    rows = expected(instance).constraints
    for index, row in enumerate(rows):
        try:
            wrong = wrong_value(row.kind, row.value, instance.units.angle)
        except (ValueError, ArithmeticError):
            wrong = "which is no real number"
        if wrong:
            message = f"found {row.value}, {wrong}"
            raise ArgumentError(message, f"constraints[{index}].value")
        if row.limits and row.limits[0].value > row.limits[1].value:
            low, high = row.limits
            message = f"found {low} above {high}, expected (low, high)"
            raise ArgumentError(message, f"constraints[{index}].range")
        if row.side is not Side.BOTH and not row.kind.has_sides:
            message = f"found a side for {row.kind}, expected one only for DPH and DHP"
            raise ArgumentError(message, f"constraints[{index}].side")
        if row.offset is not None and row.kind.has_sides and row.side is Side.BOTH:
            message = f"found an offset for {row.kind}, {ONE_SIDE}"
            raise ArgumentError(message, f"constraints[{index}].offset")
        if row.scale is not None and (wrong := wrong_scale(row.scale)):
            message = f"found {row.scale}, {wrong}"
            raise ArgumentError(message, f"constraints[{index}].scale")
        for where, primitive in (("platform", row.platform), ("base", row.base)):
            cone = primitive.cone if isinstance(primitive, Point) else None
            if cone and (wrong := wrong_half_angle(cone.half_angle, instance.units.angle)):
                message = f"found {cone.half_angle}, {wrong}"
                raise ArgumentError(message, f"constraints[{index}].{where}.cone.half_angle")
            if cone and not any(
                other.kind is DPP and primitive == getattr(other, where) for other in rows
            ):
                message = "found a cone at a point without a leg (DPP), whose direction it limits"
                raise ArgumentError(message, f"constraints[{index}].{where}.cone")
    if len(rows) != CONSTRAINTS:
        message = f"found {len(rows)} constraints, expected exactly six"
        raise ArgumentError(message, "constraints")
    angles = sum(not row.kind.is_distance for row in rows)
    if angles > MAX_ANGLES:
        message = (
            f"found {angles} angles, expected at most three: "
            "three fix the orientation (Definition 2.1)"
        )
        raise ArgumentError(message, "constraints")
    if instance.dynamics is not None:
        _check_masses(instance)
    if instance.shapes is not None:
        from gspcli.geometry.shape_mistakes import refuse_mistakes

        refuse_mistakes(instance.shapes, rows)
    return instance


def _check_masses(instance: Instance) -> None:
    from gspcli.geometry.mass_mistakes import mistakes

    assert instance.dynamics is not None
    for place, message in mistakes(instance.dynamics, instance.constraints, instance.units.length):
        parts = [f"[{part}]" if isinstance(part, int) else f".{part}" for part in place]
        raise ArgumentError(message, "".join(parts)[1:])
