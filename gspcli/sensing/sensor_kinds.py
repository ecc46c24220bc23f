"""The kinds of sensors, and their readings at a pose.

The text of a sensor, ``leg P7 B7`` (see `gspcli.sensing.notation`), is its ``str``. Readings are in
the units of the instance. A sensor contains only names and exact numbers, so it has the same
meaning on a platform whose cranks have turned.
"""

from __future__ import annotations

from typing import ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, DPP, Kind
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Bodies
from gspcli.geometry.coordinates import Body
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import measured
from gspcli.geometry.primitives import Geometry, Point, Vector, as_array, unit_vectors, vector
from gspcli.geometry.quaternions import apply, cross, dot
from gspcli.geometry.tolerances import MEASURED_PARALLEL_SINE
from gspcli.records import dataclass

Array = NDArray[np.float64]
Unit = Literal["length", "angle"]

#: The axes of a frame as directions, by their names.
AXES = {"x": vector(1, 0, 0), "y": vector(0, 1, 0), "z": vector(0, 0, 1)}


@dataclass(frozen=True)
class SensorPoint:
    """A point of a body.

    Attributes
    ----------
    body
        ``platform`` or ``base``.
    name
        The name of a point in the instance file, or empty.
    position
        The coordinates in the frame of the body where there is no name.
    """

    body: Body
    name: str = ""
    position: Vector | None = None

    def __str__(self) -> str:
        return self.name or vector_text(self.exact(None))

    def exact(self, instance: Instance | None) -> Vector:
        """Return the coordinates."""
        if self.position is not None:
            return self.position
        assert instance is not None
        point = instance.named(self.body)[self.name]
        assert isinstance(point, Point)
        return point.position

    def at(self, instance: Instance) -> Array:
        """Return the coordinates in floating point, shape (3,)."""
        return as_array(self.exact(instance))

    def primitive(self, instance: Instance) -> Geometry:
        """Return what has the name, which may be a line or a plane, or else the point."""
        if self.position is not None:
            return Point(self.position)
        return instance.named(self.body)[self.name]


def vector_text(numbers: Vector) -> str:
    """Return the text of a vector in a sensor."""
    return f"({', '.join(map(str, numbers))})"


def direction_text(direction: Vector) -> str:
    """Return the text of a direction in a sensor; an axis has its name."""
    return next((name for name, axis in AXES.items() if axis == direction), vector_text(direction))


def usual_zero(axis: Vector) -> Vector:
    """Return the default direction from which angles about an axis are measured."""
    return AXES["z" if axis[0].value or axis[1].value else "x"]


@dataclass(frozen=True)
class LegSensor:
    """The distance of a point of the platform from one of the base: a seventh leg.

    Attributes
    ----------
    platform, base
        The ends of the leg.
    """

    platform: SensorPoint
    base: SensorPoint
    kind: ClassVar[str] = "leg"
    unit: ClassVar[Unit] = "length"

    @property
    def group(self) -> str:
        """The group of the sensor, by the sorts of its points."""
        return "leg" if self.platform.name and self.base.name else "leg to a point"

    def __str__(self) -> str:
        return f"leg {self.platform} {self.base}"

    def read(self, instance: Instance, R: Array, T: Array) -> Array:
        """Return its length at poses, ``(..., 3, 3), (..., 3) -> (..., 1)``."""
        way = apply(R, self.platform.at(instance)) + T - self.base.at(instance)
        return np.asarray(np.linalg.norm(way, axis=-1, keepdims=True))

    def apart(self, instance: Instance, a: Array, b: Array) -> Array:
        """Return the difference of readings, ``(..., 1), (..., 1) -> (...)``."""
        del instance
        return np.abs(a - b)[..., 0]


@dataclass(frozen=True)
class CoordinateSensor:
    """A coordinate of a point of the platform in the base, or its part along a direction.

    Attributes
    ----------
    direction
        A vector of the base, of any length.
    platform
        The point.
    """

    direction: Vector
    platform: SensorPoint
    kind: ClassVar[str] = "coordinate"
    group: ClassVar[str] = "coordinate"
    unit: ClassVar[Unit] = "length"

    def __str__(self) -> str:
        return f"coordinate {direction_text(self.direction)} {self.platform}"

    def read(self, instance: Instance, R: Array, T: Array) -> Array:
        """Return the coordinate at poses, ``(..., 3, 3), (..., 3) -> (..., 1)``."""
        place = apply(R, self.platform.at(instance)) + T
        return np.asarray(place @ unit_vectors([self.direction])[0])[..., None]

    def apart(self, instance: Instance, a: Array, b: Array) -> Array:
        """Return the difference of readings, ``(..., 1), (..., 1) -> (...)``."""
        del instance
        return np.abs(a - b)[..., 0]


@dataclass(frozen=True)
class JointSensor:
    """The angle of a leg's joint about an axis of its body: an encoder on a universal joint.

    In a view along the axis, the leg (from this joint to its other end) is turned by this angle
    from the direction ``zero``.

    Attributes
    ----------
    leg
        The index of the leg, a DPP, from 0.
    body
        The body of the joint.
    axis, zero
        Vectors of this body, not parallel.
    """

    leg: int
    body: Body
    axis: Vector
    zero: Vector
    kind: ClassVar[str] = "joint"
    group: ClassVar[str] = "joint"
    unit: ClassVar[Unit] = "angle"

    def __str__(self) -> str:
        text = f"joint {self.leg + 1} {self.body} about {direction_text(self.axis)}"
        usual = usual_zero(self.axis)
        return text if self.zero == usual else f"{text} from {direction_text(self.zero)}"

    def read(self, instance: Instance, R: Array, T: Array) -> Array:
        """Return the angle at poses, ``(..., 3, 3), (..., 3) -> (..., 1)``."""
        row = instance.constraints[self.leg]
        assert row.kind is DPP
        leg = apply(R, as_array(row.platform.position)) + T - as_array(row.base.position)
        if self.body == "platform":
            leg = -apply(np.swapaxes(R, -1, -2), leg)
        axis, zero = unit_vectors([self.axis, self.zero])
        zero = zero - (zero @ axis) * axis
        zero /= np.linalg.norm(zero)
        angle = np.arctan2(leg @ np.cross(axis, zero), leg @ zero)
        return np.asarray(angle)[..., None] / instance.units.angle.in_radians

    def apart(self, instance: Instance, a: Array, b: Array) -> Array:
        """Return the angle between readings, ``(..., 1), (..., 1) -> (...)``."""
        turn = 2 * np.pi / instance.units.angle.in_radians
        difference = np.abs(a - b)[..., 0] % turn
        return np.asarray(np.minimum(difference, turn - difference))


@dataclass(frozen=True)
class Inclinometer:
    """The tilt of the platform against the vertical: the direction of up in its frame.

    The readings are two angles, rx and ry. From a position with a vertical z axis the platform is
    turned about its z axis by any angle, then about its y axis by ry, then about its x axis by rx
    (``ZYX``).

    Attributes
    ----------
    up
        The vertical in the base, a vector of any length.
    """

    up: Vector
    kind: ClassVar[str] = "inclinometer"
    group: ClassVar[str] = "inclinometer"
    unit: ClassVar[Unit] = "angle"

    def __str__(self) -> str:
        return "inclinometer" + ("" if self.up == AXES["z"] else f" {direction_text(self.up)}")

    def read(self, instance: Instance, R: Array, T: Array) -> Array:
        """Return rx and ry at poses, ``(..., 3, 3), (..., 3) -> (..., 2)``."""
        del T
        up = apply(np.swapaxes(R, -1, -2), unit_vectors([self.up])[0])
        x, y, z = np.moveaxis(up, -1, 0)
        angles = np.stack((np.arctan2(y, z), np.arctan2(-x, np.hypot(y, z))), axis=-1)
        return np.asarray(angles / instance.units.angle.in_radians)

    def apart(self, instance: Instance, a: Array, b: Array) -> Array:
        """Return the angle between the verticals of readings, ``(..., 2), (..., 2) -> (...)``."""
        unit = instance.units.angle.in_radians
        first, second = verticals(a * unit), verticals(b * unit)
        normal = cross(first, second)
        angle = np.arctan2(np.sqrt(dot(normal, normal)), dot(first, second))
        return np.asarray(angle / unit)


@dataclass(frozen=True)
class ValueSensor:
    """What a seventh constraint would measure: a distance or an angle of any of the ten kinds.

    Distances to planes are signed: positive on the side to which the normal points.

    Attributes
    ----------
    measured
        The kind of constraint.
    platform, base
        Its primitives.
    """

    measured: Kind
    platform: SensorPoint
    base: SensorPoint

    @property
    def kind(self) -> str:
        """``distance`` or ``angle``."""
        return "distance" if self.measured.is_distance else "angle"

    @property
    def group(self) -> str:
        """The group of the sensor."""
        return self.kind

    @property
    def unit(self) -> Unit:
        """The unit of its readings."""
        return "length" if self.measured.is_distance else "angle"

    def __str__(self) -> str:
        return f"{self.kind} {self.platform} {self.base}"

    def read(self, instance: Instance, R: Array, T: Array) -> Array:
        """Return the value at poses, ``(..., 3, 3), (..., 3) -> (..., 1)``."""
        (y, u), (x, v) = (
            _point_and_direction(place.primitive(instance)) for place in (self.platform, self.base)
        )
        bodies = Bodies((self.measured,), y[None], x[None], u[None], v[None])
        values = measured(bodies, R, T)
        if self.measured is DLL:
            values = np.abs(values)
        unit = 1.0 if self.measured.is_distance else instance.units.angle.in_radians
        return np.asarray(values / unit)

    def apart(self, instance: Instance, a: Array, b: Array) -> Array:
        """Return the difference of readings, ``(..., 1), (..., 1) -> (...)``."""
        del instance
        return np.abs(a - b)[..., 0]


Sensor: TypeAlias = LegSensor | CoordinateSensor | JointSensor | Inclinometer | ValueSensor
KINDS = ("leg", "coordinate", "joint", "inclinometer", "distance", "angle")
#: The groups in tables: legs between named points are separate from those to other points.
GROUPS = ("leg", "leg to a point", "coordinate", "joint", "inclinometer", "distance", "angle")


def checked_joint(instance: Instance, sensor: JointSensor) -> JointSensor:
    """Return the sensor of a joint if there is that joint, and its axis and zero have an angle.

    Raises
    ------
    ArgumentError
        If there is no such leg, or the directions are parallel.
    """
    legs = [k + 1 for k, row in enumerate(instance.constraints) if row.kind is DPP]
    if sensor.leg + 1 not in legs:
        known = ", ".join(map(str, legs)) or "none here"
        message = f"found constraint {sensor.leg + 1}, expected a leg (DPP): {known}"
        raise ArgumentError(message)
    normal = np.cross(*unit_vectors([sensor.axis, sensor.zero]))
    if np.linalg.norm(normal) < MEASURED_PARALLEL_SINE:
        message = "found an axis along the direction of zero: give another after from"
        raise ArgumentError(message)
    return sensor


def _point_and_direction(geometry: Geometry) -> tuple[Array, Array]:
    """Return a point of a primitive, and its unit direction or normal, zero of a point."""
    direction = np.zeros(3) if isinstance(geometry, Point) else geometry.unit
    return as_array(geometry.position), direction


def verticals(angles: Array) -> Array:
    """Return the direction of up in the platform from rx and ry in radians, (..., 2)."""
    rx, ry = angles[..., 0], angles[..., 1]
    return np.stack((-np.sin(ry), np.cos(ry) * np.sin(rx), np.cos(ry) * np.cos(rx)), axis=-1)
