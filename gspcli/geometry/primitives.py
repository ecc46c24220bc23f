"""Points, lines and planes with exact coordinates, and what moves points."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Primitive
from gspcli.errors import ArgumentError
from gspcli.geometry import numbers
from gspcli.geometry.numbers import Number, Real
from gspcli.geometry.quaternions import dot
from gspcli.records import dataclass
from gspcli.wording import shown

Vector = tuple[Number, Number, Number]
_EXACT = [Number, Number, Number]
Array = NDArray[np.float64]
#: Types that are accepted as a vector.
Components: TypeAlias = "Sequence[Real] | Array"


def vector(x: Real, y: Real, z: Real) -> Vector:
    """Return an exact vector from three numbers of any accepted kind (`Number.of`)."""
    return (Number.of(x), Number.of(y), Number.of(z))


def exact_vector(components: Components, where: str = "") -> Vector:
    """Return an exact vector from a sequence of three numbers.

    Parameters
    ----------
    components
        A list, a tuple or an array of shape (3,), of what `Number.of` takes.
    where
        The name of the vector in errors.

    Raises
    ------
    ArgumentError
        If the argument is no sequence of three numbers.
    """
    if type(components) is tuple and [type(part) for part in components] == _EXACT:
        return components
    values = components.tolist() if isinstance(components, np.ndarray) else components
    if not isinstance(values, Sequence) or isinstance(values, str):
        found = shown(values) if isinstance(values, str) else f"a {type(components).__name__}"
        raise ArgumentError(f"found {found}, expected three numbers [x, y, z]", where)
    if len(values) != 3:
        raise ArgumentError(f"found {len(values)} entries, expected three numbers [x, y, z]", where)
    x, y, z = (Number.of(value, f"{where}[{k}]") for k, value in enumerate(values))
    return x, y, z


def exact_direction(components: Components, where: str = "") -> Vector:
    """Return an exact vector that is not zero; otherwise as `exact_vector`."""
    exact = exact_vector(components, where)
    if not any(number.value for number in exact):
        raise ArgumentError(
            "found the zero vector, expected a direction: any nonzero vector", where
        )
    return exact


def as_array(exact: Vector) -> Array:
    """Return a vector in floating point, shape (3,)."""
    return np.array([number.value for number in exact])


def unit_vectors(exact: Sequence[Vector]) -> Array:
    """Return the unit vectors along vectors, shape (n, 3)."""
    vectors = np.array([[number.value for number in one] for one in exact])
    # Vectors are scaled first, so that the norm of a tiny or huge one neither under- nor overflows.
    vectors /= np.abs(vectors).max(axis=1, keepdims=True)
    return np.asarray(vectors / np.sqrt(dot(vectors, vectors))[:, None])


class _Along:
    """What has a direction."""

    @property
    def vector(self) -> Vector:
        """A nonzero vector along it, of any length."""
        raise NotImplementedError

    @cached_property
    def unit(self) -> Array:
        """The unit vector along it, shape (3,)."""
        return np.asarray(unit_vectors([self.vector])[0])


class _Placed:
    """What has a position: the point, or a point of the line or the plane."""

    position: Vector

    @cached_property
    def point(self) -> Array:
        """The position in floating point, shape (3,), in length units."""
        return as_array(self.position)


@dataclass(frozen=True, init=False)
class Cone(_Along):
    """The cone within which a joint can tilt, fixed in the body of the joint.

    The direction of each leg (DPP), from this joint to the joint at its other end, makes at most
    the half angle with the axis.

    Attributes
    ----------
    axis
        A nonzero vector in the frame of the body, of any length.
    half_angle
        In the angle unit of the instance, above 0 and below 180 degrees.
    """

    axis: Vector
    half_angle: Number

    def __init__(self, axis: Components, half_angle: Real) -> None:
        object.__setattr__(self, "axis", exact_direction(axis, "axis"))
        object.__setattr__(self, "half_angle", Number.of(half_angle, "half_angle"))

    @property
    def vector(self) -> Vector:
        """The axis."""
        return self.axis


class Motor(_Along):
    """What the drives of points have in common: a range, and readings that differ from values.

    The value q of a drive is an angle or a length, zero where the point is stated.
    """

    #: The least and the greatest value, in the unit of the instance, or None.
    limits: tuple[Number, Number] | None
    #: The largest error of the value, or None.
    tolerance: Number | None
    #: The value is a reading (of a file, a table or an encoder) times ``1 + scale``, plus
    #: ``offset``; None stands for zero. `limits` are values, not readings.
    offset: Number | None
    scale: Number | None

    def _state(
        self,
        limits: Sequence[Real] | None,
        tolerance: Real | None,
        offset: Real | None,
        scale: Real | None,
    ) -> None:
        ends = None if limits is None else tuple(Number.of(x, "limits") for x in limits)
        if ends is not None and len(ends) != 2:
            raise ArgumentError(f"found {len(ends)} numbers, expected two", "limits")
        object.__setattr__(self, "limits", ends)
        for name, value in (("tolerance", tolerance), ("offset", offset), ("scale", scale)):
            exact = None if value is None else Number.of(value, name)
            object.__setattr__(self, name, exact)

    def value_of(self, reading: Number) -> Number:
        """Return the value of a reading, exactly."""
        return numbers.value_of(reading, self.scale, self.offset)

    def reading_of(self, value: Number) -> Number:
        """Return the reading at a value, exactly."""
        return numbers.reading_of(value, self.scale, self.offset)


@dataclass(frozen=True, init=False)
class Crank(Motor):
    """The arm of a rotary motor, which turns a point about an axis.

    Attributes
    ----------
    centre
        A point of the axis.
    axis
        A nonzero vector along it; positive angles turn by the right-hand rule.
    limits, tolerance, offset, scale
        As in `Motor`, in the unit of angles.
    diameter
        Of the arm, a cylinder with round ends from the axis to the point, or None.
    """

    centre: Vector
    axis: Vector
    limits: tuple[Number, Number] | None = None
    tolerance: Number | None = None
    offset: Number | None = None
    scale: Number | None = None
    diameter: Number | None = None
    sort: ClassVar[Literal["crank"]] = "crank"

    def __init__(
        self,
        centre: Components,
        axis: Components,
        limits: Sequence[Real] | None = None,
        tolerance: Real | None = None,
        offset: Real | None = None,
        scale: Real | None = None,
        diameter: Real | None = None,
    ) -> None:
        object.__setattr__(self, "centre", exact_vector(centre, "centre"))
        object.__setattr__(self, "axis", exact_direction(axis, "axis"))
        self._state(limits, tolerance, offset, scale)
        exact = None if diameter is None else Number.of(diameter, "diameter")
        object.__setattr__(self, "diameter", exact)

    @property
    def vector(self) -> Vector:
        """The axis."""
        return self.axis

    def moved(self, point: Array, angle: float) -> Array:
        """Return a point, shape (3,), turned by an angle in radians."""
        centre = as_array(self.centre)
        return self.turned(point - centre, angle, centre)

    def turned(self, vector: Array, angle: float, start: Array | float = 0.0) -> Array:
        """Return a vector, shape (3,), turned by an angle in radians, and added to a point."""
        along = (self.unit @ vector) * self.unit
        turning = np.cos(angle) * (vector - along)
        across = np.sin(angle) * np.cross(self.unit, vector)
        return np.asarray(start + along + turning + across)


@dataclass(frozen=True, init=False)
class Slide(Motor):
    """The carriage of a rail, which moves a point along a line.

    Attributes
    ----------
    direction
        A nonzero vector along the rail, of any length; positive values move along it.
    limits, tolerance, offset, scale
        As in `Motor`, in the unit of length.
    """

    direction: Vector
    limits: tuple[Number, Number] | None = None
    tolerance: Number | None = None
    offset: Number | None = None
    scale: Number | None = None
    sort: ClassVar[Literal["slide"]] = "slide"

    def __init__(
        self,
        direction: Components,
        limits: Sequence[Real] | None = None,
        tolerance: Real | None = None,
        offset: Real | None = None,
        scale: Real | None = None,
    ) -> None:
        object.__setattr__(self, "direction", exact_direction(direction, "direction"))
        self._state(limits, tolerance, offset, scale)

    @property
    def vector(self) -> Vector:
        """The direction."""
        return self.direction

    def moved(self, point: Array, length: float) -> Array:
        """Return a point, shape (3,), moved along the rail."""
        return np.asarray(point + length * self.unit)


@dataclass(frozen=True, init=False)
class Point(_Placed):
    """A point.

    Attributes
    ----------
    position
        Coordinates in the frame of the body; three numbers of any kind are made exact.
    cone
        The cone of the legs at this point, or None. It restricts motions, as ranges of values do.
        It turns with the arm of a crank.
    crank
        The arm that turns the point, or None. The position is that at the angle zero.
    slide
        The carriage that moves the point along a rail, or None. The position is that at zero.
    partner
        The name of the point of the same body whose arm or carriage moves this point, too; empty if
        it has its own. `crank` or `slide` is then the partner's.

    Examples
    --------
    >>> Point([0, 0.1, "sqrt(3)/2"]).position[1].fraction
    Fraction(1, 10)
    """

    position: Vector
    cone: Cone | None = None
    crank: Crank | None = None
    slide: Slide | None = None
    partner: str = ""
    primitive = Primitive.POINT

    def __init__(
        self,
        position: Components,
        cone: Cone | None = None,
        crank: Crank | None = None,
        slide: Slide | None = None,
        partner: str = "",
    ) -> None:
        if crank is not None and slide is not None:
            raise ArgumentError("found a crank and a slide, expected at most one of them", "slide")
        object.__setattr__(self, "position", exact_vector(position, "position"))
        object.__setattr__(self, "cone", cone)
        object.__setattr__(self, "crank", crank)
        object.__setattr__(self, "slide", slide)
        object.__setattr__(self, "partner", partner)

    @property
    def drive(self) -> Crank | Slide | None:
        """What moves the point, or None."""
        return self.slide if self.crank is None else self.crank

    def moved(self, value: float) -> Point:
        """Return the point after its drive has moved, without a drive; its cone turns with it.

        Parameters
        ----------
        value
            The value of the drive, in radians or units of length.
        """
        drive = self.drive
        if drive is None:
            return self
        cone = self.cone
        if cone is not None and isinstance(drive, Crank):
            cone = Cone(drive.turned(cone.unit, value), cone.half_angle)
        return Point(drive.moved(self.point, value), cone)


@dataclass(frozen=True, init=False)
class Line(_Placed, _Along):
    """An oriented line.

    Attributes
    ----------
    position
        A point on the line.
    direction
        A nonzero vector along it, of any length.
    """

    position: Vector
    direction: Vector
    primitive = Primitive.LINE

    def __init__(self, position: Components, direction: Components) -> None:
        object.__setattr__(self, "position", exact_vector(position, "position"))
        object.__setattr__(self, "direction", exact_direction(direction, "direction"))

    @property
    def vector(self) -> Vector:
        """The direction."""
        return self.direction


@dataclass(frozen=True, init=False)
class Plane(_Placed, _Along):
    """An oriented plane.

    Attributes
    ----------
    position
        A point in the plane.
    normal
        A nonzero normal of any length; it points to the positive side.
    """

    position: Vector
    normal: Vector
    primitive = Primitive.PLANE

    def __init__(self, position: Components, normal: Components) -> None:
        object.__setattr__(self, "position", exact_vector(position, "position"))
        object.__setattr__(self, "normal", exact_direction(normal, "normal"))

    @property
    def vector(self) -> Vector:
        """The normal."""
        return self.normal


Geometry = Point | Line | Plane
