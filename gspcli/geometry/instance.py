"""An instance: a platform with numbers, as an instance file states it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import Kind
from gspcli.catalogue.types import GspType
from gspcli.errors import ArgumentError
from gspcli.geometry import numbers
from gspcli.geometry.euler import check_sequence, rotation_from_euler
from gspcli.geometry.numbers import Number, Real
from gspcli.geometry.primitives import Components, Geometry, Vector, exact_vector
from gspcli.geometry.quaternions import rotation_from_quaternion, unit_quaternion
from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.geometry.masses import Dynamics


#: Names of units of length in metres. Kinematics is the same in any unit, so other names are only
#: carried along; where forces come in, a unit must be one of these.
METRES = {
    "m": 1.0,
    "dm": 0.1,
    "cm": 0.01,
    "mm": 1e-3,
    "um": 1e-6,
    "µm": 1e-6,
    "km": 1e3,
    "in": 0.0254,
    "inch": 0.0254,
    "ft": 0.3048,
}


Array = NDArray[np.float64]

#: The error for a quaternion of zero.
TURNS = "expected a quaternion [w, x, y, z]: any but zero"


@dataclass(frozen=True, init=False)
class HomePose:
    """The stated home of a machine; home is the real pose for its values that is nearest to it.

    Attributes
    ----------
    position
        Of the platform's origin in the base, in the unit of length.
    quaternion
        The rotation, scalar first, of any length; no turn by default, and with `euler`.
    euler
        Instead the order of the axes of `angles`, as `gspcli.geometry.euler` takes it, or None.
    angles
        Turns about x, y and z in the unit of angles; zero without `euler`.
    """

    position: Vector
    quaternion: tuple[Number, ...]
    euler: str | None
    angles: Vector

    def __init__(
        self,
        position: Components,
        quaternion: Sequence[Real] | None = None,
        *,
        euler: str | None = None,
        angles: Components = (0, 0, 0),
    ) -> None:
        turned = tuple(map(Number.of, (1, 0, 0, 0) if quaternion is None else quaternion))
        if len(turned) != 4 or not any(part.value for part in turned):
            raise ArgumentError(f"found {quaternion}, {TURNS}", "quaternion")
        if euler is not None and quaternion is not None:
            raise ArgumentError("found angles, too, expected a quaternion or angles", "quaternion")
        object.__setattr__(self, "position", exact_vector(position, "position"))
        object.__setattr__(self, "quaternion", turned)
        object.__setattr__(self, "euler", None if euler is None else check_sequence(euler))
        object.__setattr__(self, "angles", exact_vector(angles, "angles"))

    @property
    def T(self) -> Array:
        """The position, shape (3,)."""
        return np.array([part.value for part in self.position])

    def R(self, in_radians: float) -> Array:
        """Return the rotation, shape (3, 3); the unit of angles is given in radians."""
        if self.euler is not None:
            angles = [part.value * in_radians for part in self.angles]
            return rotation_from_euler(self.euler, angles)
        quaternion = unit_quaternion(np.array([part.value for part in self.quaternion]))
        return np.asarray(rotation_from_quaternion(quaternion), float)


@dataclass(frozen=True, init=False)
class Frame(HomePose):
    """A frame that is fixed in a body: as `HomePose`, of the frame in that body.

    `position` is its origin, which files call ``point``; the rotation turns its axes.
    """


@dataclass(frozen=True)
class Frames:
    """The frames that an instance file states.

    Attributes
    ----------
    tool
        In the platform; None for the platform's own frame.
    work
        In the base; None for the base's own frame.
    """

    tool: Frame | None = None
    work: Frame | None = None


@dataclass(frozen=True, init=False)
class Shapes:
    """The shapes of the legs and of both bodies.

    Attributes
    ----------
    diameters
        Of the legs, at least zero: one for all of them, or one for each, in their order.
    platform, base
        Points of each body, in its frame; their convex hull is its shape. Empty if it has none.
    near_joint
        The part of a leg that is nearer to its joint is not compared with what it is joined to
        there: the body, and the legs that share the joint. So it is with an arm, its rod, and the
        body with its axis. If None, or zero, legs that share a joint, and an arm and its rod, are
        not compared at all.
    """

    diameters: tuple[Number, ...]
    platform: tuple[Vector, ...]
    base: tuple[Vector, ...]
    near_joint: Number | None

    def __init__(
        self,
        diameters: Real | Sequence[Real],
        platform: Sequence[Components] = (),
        base: Sequence[Components] = (),
        near_joint: Real | None = None,
    ) -> None:
        several = isinstance(diameters, Sequence) and not isinstance(diameters, str)
        given: Sequence[Real] = diameters if several else [diameters]  # type: ignore[assignment,list-item]
        exact_diameters = tuple(
            Number.of(one, f"diameters[{k}]" if several else "diameters")
            for k, one in enumerate(given)
        )
        object.__setattr__(self, "diameters", exact_diameters)
        for name, points in (("platform", platform), ("base", base)):
            exact = tuple(exact_vector(one, f"{name}[{k}]") for k, one in enumerate(points))
            object.__setattr__(self, name, exact)
        near = None if near_joint is None else Number.of(near_joint, "near_joint")
        object.__setattr__(self, "near_joint", near)


class Side(Enum):
    """The side of the plane on which the point of a PH or HP distance lies."""

    POSITIVE = "positive"
    NEGATIVE = "negative"
    BOTH = "both"


class AngleUnit(Enum):
    """The unit of the angles of an instance."""

    DEGREE = "deg"
    RADIAN = "rad"

    @property
    def in_radians(self) -> float:
        """The unit in radians."""
        return math.pi / 180 if self is AngleUnit.DEGREE else 1.0


@dataclass(frozen=True)
class Units:
    """The units of an instance.

    Attributes
    ----------
    length
        The name of the length unit; only masses give it a meaning (`lengths.METRES`).
    angle
        The unit of angle values.
    """

    length: str
    angle: AngleUnit


@dataclass(frozen=True)
class Constraint:
    """One constraint of an instance.

    Attributes
    ----------
    kind
        The measured quantity and the kinds of the two primitives.
    platform, base
        The primitives, each in the frame of its body.
    value
        The distance in length units or the angle in angle units of the instance, as it is between
        the primitives; a number of any kind is made exact (`Number.of`).
    side
        For DPH and DHP: where the point lies; `Side.BOTH` for all other kinds.
    platform_name, base_name
        The names of the primitives. Equal names on one body are one shared primitive.
    limits
        The smallest and the largest value that the machine can reach, or None. They restrict
        motions and do not change which poses satisfy the value.
    tolerance
        The largest error of the machine's value, or None if the file states none.
    offset, scale
        The value is a reading (of a file, a table or an encoder) times ``1 + scale``, plus
        ``offset``; None stands for zero. For DPH and DHP the offset is added to the signed
        distance, so one side must be chosen. `value` and `limits` are values, not readings.
    """

    kind: Kind
    platform: Geometry
    base: Geometry
    value: Number
    side: Side = Side.BOTH
    platform_name: str = ""
    base_name: str = ""
    limits: tuple[Number, Number] | None = None
    tolerance: Number | None = None
    offset: Number | None = None
    scale: Number | None = None

    def __post_init__(self) -> None:
        if type(self.value) is not Number:
            object.__setattr__(self, "value", Number.of(self.value, "value"))

    def value_of(self, reading: Number) -> Number:
        """Return the value of a reading, with scale and offset, exactly.

        Every reading that enters the program is converted here.
        """
        return numbers.value_of(reading, self.scale, self.offset, self._added)

    def reading_of(self, value: Number) -> Number:
        """Return the reading at which the machine has a value, exactly."""
        return numbers.reading_of(value, self.scale, self.offset, self._added)

    def raised_by(self, difference: Number) -> Number:
        """Return the value after a number is added to its reading, exactly."""
        return self.value_of(numbers.combined(self.reading_of(self.value), "+", difference))

    @property
    def _added(self) -> str:
        """The operation that applies the offset: ``-`` on the negative side, where values fall."""
        return "-" if self.side is Side.NEGATIVE else "+"


def as_read(row: Constraint, *, offset: Number | None, scale: Number | None) -> Constraint:
    """Return a constraint, whose value and limits are readings, with an offset and a scale."""
    read = replace(row, offset=offset, scale=scale)
    limits = row.limits
    return replace(
        read,
        value=read.value_of(row.value),
        limits=limits and (read.value_of(limits[0]), read.value_of(limits[1])),
    )


@dataclass(frozen=True)
class Instance:
    """A generalized Stewart platform with numbers.

    Attributes
    ----------
    constraints
        Six constraints, in the order of the file.
    units
        The units of lengths and angles.
    name, source
        The name and the source that the file states, or None.
    further
        Primitives without a constraint: the body (``platform`` or ``base``), the name and the
        primitive. Sensors can be attached to them.
    dynamics
        Masses, inertias and drives, or None if the file states none. They change no pose.
    home
        The stated home of the machine, or None. It selects one of the real poses and changes none.
    frames
        The frames in which commands read and print poses, or None (`gspcli.PoseFrame`). They
        change no pose.
    readings
        What further sensors read at the pose of the values, as `parse_reading` takes it.
    shapes
        The diameters of legs and the hulls of bodies, or None. They change no pose.
    """

    constraints: tuple[Constraint, ...]
    units: Units
    name: str | None = None
    source: str | None = None
    further: tuple[tuple[str, str, Geometry], ...] = ()
    dynamics: Dynamics | None = None
    home: HomePose | None = None
    frames: Frames | None = None
    readings: tuple[str, ...] = ()
    shapes: Shapes | None = None

    def __repr__(self) -> str:
        kinds = " ".join(row.kind.name for row in self.constraints)
        units = f"{self.units.length}, {self.units.angle.value}"
        return f"<Instance{f' {self.name!r}' if self.name else ''}: {kinds} ({units})>"

    @cached_property
    def type(self) -> GspType:
        """The type of the platform.

        Raises
        ------
        TypeNameError
            If there are not six constraints or more than three are angles.
        """
        return GspType.of(constraint.kind for constraint in self.constraints)

    @cached_property
    def primitives(self) -> tuple[Geometry, ...]:
        """The primitives in the order of the constraints, those of the platform first."""
        rows = self.constraints
        return (*[row.platform for row in rows], *[row.base for row in rows])

    @cached_property
    def coordinates(self) -> list[float]:
        """The coordinates of a point of each primitive, one after the other, in length units."""
        return [number.value for body in self.primitives for number in body.position]

    @cached_property
    def side_choices(self) -> int:
        """The number of choices for the sides that are not stated; a distance of zero has one."""
        left_open = sum(
            row.kind.has_sides and row.side is Side.BOTH and row.value.value != 0
            for row in self.constraints
        )
        return 1 << left_open

    @cached_property
    def expected(self) -> int:
        """The generic count of the type for the sides asked for."""
        return generic_counts(self.type).one_sided * self.side_choices

    def named(self, body: str) -> dict[str, Geometry]:
        """Return the primitives of a body, ``platform`` or ``base``, by name, used ones first."""
        used = {
            getattr(row, f"{body}_name"): getattr(row, body)
            for row in self.constraints
            if getattr(row, f"{body}_name")
        }
        return used | {name: geometry for where, name, geometry in self.further if where == body}

    @property
    def title(self) -> str:
        """The name of the instance, if it has one, and its type."""
        return ": ".join(part for part in (self.name, self.type.id) if part)

    def to_json(self) -> dict[str, Any]:
        """Return what identifies the instance in every document: its name, type and units."""
        return {
            "name": self.name,
            "type": self.type.to_json(),
            "units": {"length": self.units.length, "angle": self.units.angle.value},
        }

    def on_sides(self, signs: Sequence[int]) -> Instance:
        """Return the instance with one side for each DPH and DHP whose sign is 1 or -1."""
        rows = tuple(
            replace(row, side=Side.POSITIVE if sign > 0 else Side.NEGATIVE)
            if row.kind.has_sides
            else row
            for row, sign in zip(self.constraints, signs, strict=True)
        )
        return replace(self, constraints=rows)

    def with_values(self, values: dict[int, Number]) -> Instance:
        """Return the instance with other values for some constraints (indices from 0)."""
        constraints = list(self.constraints)
        for index, value in values.items():
            constraints[index] = replace(constraints[index], value=value)
        return replace(self, constraints=tuple(constraints))
