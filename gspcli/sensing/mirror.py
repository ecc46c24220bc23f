"""Mirror modes: two poses of planar bodies at which constraints and sensors agree, proved exactly.

**Theorem.** Let the points of the platform lie in a plane H and those of the base in a plane B.
Let s be the reflection of the platform's space in H, t that of the base's in B, and for a pose g (a
proper motion from the one to the other) ``g' = t g s``. Then g' is a proper motion, too, and each
point p of H and each point b of B have the same distance at g and at g'.

*Proof.* g' is a product of a proper and two improper motions, so it is proper. s(p) = p and
t(b) = b, so that ``|g'(p) - b| = |t(g(s(p))) - t(b)| = |g(p) - b|``, because t is an isometry. ∎

So if all constraints are such distances and g is an assembly mode, g' is one, too; it differs from
g unless g maps H onto B. The reflection also keeps a line that lies in the plane or is
perpendicular to it, and a plane that is perpendicular to it. A sensor between kept primitives has
the same reading at g and g', for every pose: no accuracy lets it distinguish the two.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.instance import Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Point, Vector, as_array
from gspcli.geometry.ranges import turns
from gspcli.geometry.signs import sign_of
from gspcli.records import dataclass
from gspcli.sensing.sensor_kinds import (
    CoordinateSensor,
    Inclinometer,
    JointSensor,
    LegSensor,
    Sensor,
    ValueSensor,
)

Array = NDArray[np.float64]

#: Points whose triangle has less than this part of the largest possible area lie on a line.
_FLAT = 1e-9


@dataclass(frozen=True)
class ExactPlane:
    """A plane through points of a body, exactly.

    Attributes
    ----------
    point, normal
        A point of it, and a normal of any length, in the frame of the body.
    """

    point: Vector
    normal: Vector

    def contains(self, point: Vector) -> bool:
        """Return whether a point lies in the plane; true only if that is proved."""
        return _is_zero(_dot(self.normal, _minus(point, self.point)))

    def parity(self, vector: Vector) -> int:
        """Return 1 if the reflection keeps a vector, -1 if it reverses it, 0 otherwise.

        The first two results are proved.
        """
        if _is_zero(_dot(self.normal, vector)):
            return 1
        return -1 if all(map(_is_zero, _cross(self.normal, vector))) else 0

    def keeps(self, geometry: Geometry) -> int:
        """Return the sign of a primitive's direction if the reflection keeps the primitive, else 0.

        The results 1 and -1 are proved; the result for a kept point is 1.
        """
        inside = self.contains(geometry.position)
        if isinstance(geometry, Point):
            return int(inside)
        parity = self.parity(geometry.vector)
        needed = 1 if isinstance(geometry, Line) else -1
        return parity if parity != needed or inside else 0

    def reflection(self) -> tuple[Array, Array]:
        """Return S and c in floating point, such that x becomes S x + c, shapes (3, 3), (3,)."""
        normal = as_array(self.normal)
        normal = normal / np.linalg.norm(normal)
        S = np.eye(3) - 2 * np.outer(normal, normal)
        return S, 2 * (normal @ as_array(self.point)) * normal


@dataclass(frozen=True)
class Mirror:
    """The planes in which both bodies can be reflected without changing any constraint.

    Attributes
    ----------
    platform, base
        The planes.
    """

    platform: ExactPlane
    base: ExactPlane

    def keeps(self, sensor: Sensor, instance: Instance) -> bool:
        """Return whether a sensor is proved to read the same at each pose and its mirror pose."""
        match sensor:
            case LegSensor():
                return self.platform.contains(sensor.platform.exact(instance)) and (
                    self.base.contains(sensor.base.exact(instance))
                )
            case CoordinateSensor():
                return self.platform.contains(sensor.platform.exact(instance)) and (
                    self.base.parity(sensor.direction) == 1
                )
            case JointSensor():
                # Both directions in which the angle is measured must be kept.
                plane = self.platform if sensor.body == "platform" else self.base
                return plane.parity(sensor.axis) == -1
            case Inclinometer() | ValueSensor():
                return False

    def image(self, R: Array, T: Array) -> tuple[Array, Array]:
        """Return the mirror poses of poses, ``(..., 3, 3), (..., 3)``."""
        (S, c), (W, d) = self.platform.reflection(), self.base.reflection()
        # x = W (R (S y + c) + T) + d.
        return W @ R @ S, (R @ c + T) @ W.T + d


def mirror_of(instance: Instance) -> Mirror | None:
    """Return the mirror of an instance; None if none is proved.

    The points of each body must lie in one plane, exactly, and not on a line.
    """
    planes = []
    for body in ("platform", "base"):
        primitives = [getattr(row, body) for row in instance.constraints]
        plane = plane_of([one.position for one in primitives if isinstance(one, Point)])
        if plane is None:
            return None
        planes.append(plane)
    platform, base = planes
    unit = instance.units.angle
    for row in instance.constraints:
        here, there = platform.keeps(row.platform), base.keeps(row.base)
        quarters = None if row.kind.is_distance else turns(row.value, unit)
        if not (here and there and _is_kept(row, here * there, quarters)):
            return None
    return Mirror(platform, base)


def _is_kept(row: Constraint, sign: int, quarters: Fraction | float | None) -> bool:
    """Return whether a constraint between kept primitives is the same for the mirror pose.

    Parameters
    ----------
    row
        The constraint.
    sign
        -1 if the reflections reverse one of two directions.
    quarters
        The value of an angle, in quarter turns.
    """
    if row.kind.has_sides:
        return sign == 1 or row.side is Side.BOTH or row.value.fraction == 0
    if quarters is None:
        return True
    right = 1 if type(row.platform) is type(row.base) else 0
    return sign == 1 or quarters == right


def plane_of(points: Sequence[Vector]) -> ExactPlane | None:
    """Return the only plane that contains points; None if it is not proved to exist."""
    numbers = np.array([as_array(point) for point in points]).reshape(-1, 3)
    if len(numbers) < 3:
        return None
    ways = numbers - numbers[0]
    far = int(np.linalg.norm(ways, axis=1).argmax())
    areas = np.linalg.norm(np.cross(ways[far], ways), axis=1)
    third = int(areas.argmax())
    if areas[third] <= _FLAT * (ways[far] @ ways[far]):
        return None
    first, second = (_minus(points[k], points[0]) for k in (far, third))
    plane = ExactPlane(points[0], _cross(first, second))
    return plane if all(map(plane.contains, points)) else None


def _operation(symbol: str, a: Number, b: Number) -> Number:
    """Return a sum, difference or product; rational results and those with zero are simplified."""
    if symbol == "*" and 0 in (a.fraction, b.fraction):
        return _ZERO
    if symbol != "*" and b.fraction == 0:
        return a
    number = Number(symbol, (a, b))
    return number if number.fraction is None else Number("rational", (number.fraction,))


_ZERO = Number.of(0)


def _minus(a: Vector, b: Vector) -> Vector:
    x, y, z = (_operation("-", p, q) for p, q in zip(a, b, strict=True))
    return x, y, z


def _dot(a: Vector, b: Vector) -> Number:
    products = [_operation("*", p, q) for p, q in zip(a, b, strict=True)]
    return _operation("+", _operation("+", products[0], products[1]), products[2])


def _cross(a: Vector, b: Vector) -> Vector:
    x, y, z = (
        _operation("-", _operation("*", a[i - 2], b[i - 1]), _operation("*", a[i - 1], b[i - 2]))
        for i in range(3)
    )
    return x, y, z


def _is_zero(number: Number) -> bool:
    """Return whether a number is zero; true only if that is proved."""
    return sign_of(number) == 0
