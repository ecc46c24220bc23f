"""The sensors that are compared by default."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import BODIES, Body
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point, Vector
from gspcli.sensing.sensor_kinds import (
    AXES,
    CoordinateSensor,
    Inclinometer,
    JointSensor,
    LegSensor,
    Sensor,
    SensorPoint,
)
from gspcli.ties import definite_sign

Array = NDArray[np.float64]

#: Digits of coordinates relative to the size of the platform, and decimals of directions.
_DIGITS, _DECIMALS = 3, 4
#: Points within this part of their size are on a line, or at the centre, and give no direction.
_FLAT = 1e-9


def candidates(instance: Instance, up: Vector | None = None) -> list[Sensor]:
    """Return the sensors that can be added to an instance.

    They are

    - legs between points of the platform and of the base that no constraint joins;
    - legs to and from a point above the middle of either body, by half the size of the platform;
    - the coordinates of the middle of the platform's points;
    - two angles of each joint of a leg, about axes in the plane of the joints: one away from their
      middle, and one across;
    - an inclinometer.

    Parameters
    ----------
    instance
        The platform; points that no constraint uses are ends of legs, too.
    up
        The vertical in the base; z if None.
    """
    arrangement = Arrangement.of(instance)
    found: list[Sensor] = list(_legs(instance))
    found += _raised_legs(instance, arrangement)
    middle = SensorPoint(
        "platform", position=_rounded(arrangement.platform_centre, arrangement.extent)
    )
    found += [CoordinateSensor(axis, middle) for axis in AXES.values()]
    for body in BODIES:
        found += _joints(instance, arrangement, body)
    return [*found, Inclinometer(up or AXES["z"])]


def points_of(instance: Instance, body: Body) -> dict[Vector, SensorPoint]:
    """Return the different points of a body."""
    places: dict[Vector, SensorPoint] = {}
    for row in instance.constraints:
        geometry, name = getattr(row, body), getattr(row, f"{body}_name")
        if isinstance(geometry, Point):
            place = (
                SensorPoint(body, name) if name else SensorPoint(body, position=geometry.position)
            )
            places.setdefault(geometry.position, place)
    for where, name, geometry in instance.further:
        if where == body and isinstance(geometry, Point):
            places.setdefault(geometry.position, SensorPoint(body, name))
    return places


def _legs(instance: Instance) -> Iterator[LegSensor]:
    legs = {
        (row.platform.position, row.base.position)
        for row in instance.constraints
        if row.kind is DPP
    }
    for here, platform in points_of(instance, "platform").items():
        for there, base in points_of(instance, "base").items():
            if (here, there) not in legs:
                yield LegSensor(platform, base)


def normal_of(points: Array) -> Array | None:
    """Return the unit normal of the plane nearest to points, shape (n, 3); None on a line.

    Its largest component is positive.
    """
    if len(points) < 3:
        return None
    _, sizes, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    if sizes[1] <= _FLAT * sizes[0]:
        return None
    return definite_sign(axes[2])


def body_normal(instance: Instance, body: Body) -> Array | None:
    """Return `normal_of` the points of a body that constraints use."""
    rows = [getattr(row, body) for row in instance.constraints]
    return normal_of(np.array([one.point for one in rows if isinstance(one, Point)]).reshape(-1, 3))


def _raised_legs(instance: Instance, arrangement: Arrangement) -> Iterator[LegSensor]:
    """Yield the legs from a point above the middle of one body to the points of the other."""
    centres = {"platform": arrangement.platform_centre, "base": arrangement.base_centre}
    for body in BODIES:
        normal = body_normal(instance, body)
        if normal is None:
            continue
        raised = centres[body] + arrangement.extent / 2 * normal
        place = SensorPoint(body, position=_rounded(raised, arrangement.extent))
        other: Body = "base" if body == "platform" else "platform"
        for end in points_of(instance, other).values():
            yield LegSensor(place, end) if body == "platform" else LegSensor(end, place)


def _joints(instance: Instance, arrangement: Arrangement, body: Body) -> Iterator[JointSensor]:
    normal = body_normal(instance, body)
    if normal is None:
        return
    centre = arrangement.platform_centre if body == "platform" else arrangement.base_centre
    for k, row in enumerate(instance.constraints):
        if row.kind is not DPP:
            continue
        way = getattr(row, body).point - centre
        way = way - (way @ normal) * normal
        length = np.linalg.norm(way)
        if length > _FLAT * arrangement.extent:
            away = way / length
            for axis in (away, np.cross(normal, away)):
                yield JointSensor(k, body, _direction(axis), _direction(normal))


def _rounded(point: Array, size: float) -> Vector:
    decimals = _DIGITS - math.floor(math.log10(size)) if size else _DIGITS
    x, y, z = (Number.of(round(value, decimals) + 0.0) for value in point.tolist())
    return x, y, z


def _direction(unit: Array) -> Vector:
    x, y, z = (Number.of(round(value, _DECIMALS) + 0.0) for value in unit.tolist())
    return x, y, z
