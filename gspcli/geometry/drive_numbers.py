"""The cranks, slides and driven values of an instance as arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.coordinates import BODIES
from gspcli.geometry.instance import Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, Point, Slide, as_array
from gspcli.geometry.readings import factors, offsets

Array = NDArray[np.float64]


class Driven(NamedTuple):
    """A point of a constraint that has a crank or a slide."""

    body: str
    point: Point
    name: str
    drive: Crank | Slide


class ThickArm(NamedTuple):
    """The arm of a crank, from the axis to the point of a constraint."""

    body: str
    point: Point
    name: str
    diameter: Number


def driven_points(row: Constraint) -> list[Driven]:
    """Return the points of a constraint that have cranks or slides."""
    return [
        Driven(body, point, getattr(row, f"{body}_name"), point.drive)
        for body in BODIES
        if isinstance(point := getattr(row, body), Point) and point.drive is not None
    ]


def is_driven(instance: Instance) -> bool:
    """Return whether a point of a constraint has a crank or a slide."""
    return any(driven_points(row) for row in instance.constraints)


def arms_of(instance: Instance) -> dict[int, ThickArm]:
    """Return the arms whose diameter is stated, by the index of the constraint."""
    return {
        k: ThickArm(one.body, one.point, one.name, one.drive.diameter)
        for k, row in enumerate(instance.constraints)
        for one in driven_points(row)
        if isinstance(one.drive, Crank) and one.drive.diameter is not None
    }


def shares_drives(instance: Instance) -> bool:
    """Return whether points of two constraints ride on one carriage or arm."""
    motors = [
        (one.body, one.point.partner or one.name or k)
        for k, row in enumerate(instance.constraints)
        for one in driven_points(row)
    ]
    return len(set(motors)) < len(motors)


class _Motor(NamedTuple):
    """What is kept of one drive, as q: lengths and radians; offset and factor are of readings."""

    unit: float
    low: float
    high: float
    tolerance: float
    offset: float
    factor: float


#: The fields of `Drives` that come from those of `_Motor`.
_MOTOR = ("units", "low", "high", "tolerances", "offsets", "factors")


def drive_numbers(instance: Instance) -> dict[str, Any]:
    """Return the fields of `gspcli.geometry.drives.Drives` by their names.

    Raises
    ------
    ArgumentError
        If both points of a constraint have drives.
    """
    rows = instance.constraints
    found: dict[tuple[str, str], tuple[str, str, _Motor]] = {}
    index, driven, on_platform = [], np.zeros(len(rows), bool), np.zeros(len(rows), bool)
    middle, across, beside = np.zeros((3, len(rows), 3))
    arms, rods = np.ones(len(rows)), np.full(len(rows), np.nan)
    motors = _motors_of_values(instance)
    radians = instance.units.angle.in_radians
    for k, row in enumerate(rows):
        one = _only(k, driven_points(row))
        if one is None:
            key = ("", str(k + 1))
            found[key] = (str(k + 1), "value", motors[k])
            middle[k] = as_array(row.base.position)
        else:
            owner, sort = one.point.partner or one.name or str(k + 1), one.drive.sort
            key = (one.body, owner)
            unit = radians if sort == "crank" else 1.0
            found.setdefault(key, (f"{sort}.{owner}", sort, _motor(one.drive, unit)))
            driven[k], on_platform[k] = True, one.body == BODIES[0]
            rods[k] = row.value.value
            middle[k], across[k], beside[k] = _place(one.point, one.drive)
            arms[k] = np.linalg.norm(beside[k])
        index.append(list(found).index(key))
    names, sorts, kept = zip(*found.values(), strict=True)
    return {
        "names": names,
        "sorts": sorts,
        "index": np.array(index),
        "driven": driven,
        "on_platform": on_platform,
        **dict(zip(_MOTOR, np.array(kept).T, strict=True)),
        "middle": middle,
        "across": across,
        "beside": beside,
        "arms": arms,
        "rods": rods,
    }


def _only(k: int, found: list[Driven]) -> Driven | None:
    if len(found) > 1:
        names = " and ".join(one.name or "a point" for one in found)
        message = f"constraint {k + 1} has drives at both ends ({names}), expected one"
        raise ArgumentError(message)
    return found[0] if found else None


def _place(point: Point, drive: Crank | Slide) -> tuple[Array, Array, Array]:
    """Return the middle of a circle and its two radii, or a point and the direction of a rail."""
    if isinstance(drive, Slide):
        return point.point, np.zeros(3), drive.unit
    centre = as_array(drive.centre)
    arm = point.point - centre
    height = (drive.unit @ arm) * drive.unit
    return centre + height, arm - height, np.cross(drive.unit, arm - height)


def _motor(drive: Crank | Slide, unit: float) -> _Motor:
    low, high = (-np.inf, np.inf) if drive.limits is None else (x.value for x in drive.limits)
    off = np.nan if drive.tolerance is None else drive.tolerance.value
    offset = 0.0 if drive.offset is None else drive.offset.value
    factor = 1.0 if drive.scale is None else 1 + drive.scale.value
    return _Motor(unit, low * unit, high * unit, off * unit, offset, factor)


def _motors_of_values(instance: Instance) -> list[_Motor]:
    """Return the drives of constraints whose values are driven; signed on a chosen side."""
    found = []
    corrections = zip(offsets(instance), factors(instance), strict=True)
    for row, (offset, factor) in zip(instance.constraints, corrections, strict=True):
        unit = 1.0 if row.kind.is_distance else instance.units.angle.in_radians
        low, high = (-np.inf, np.inf) if row.limits is None else (x.value for x in row.limits)
        if row.side is Side.NEGATIVE:
            low, high = -high, -low
        off = np.nan if row.tolerance is None else row.tolerance.value
        found.append(_Motor(unit, low * unit, high * unit, off * unit, offset, factor))
    return found
