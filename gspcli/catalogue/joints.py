"""The five joints of Section 7, chains of them, and the freedoms of a chain by exact arithmetic.

A chain connects the platform to the base and is written from the platform on, as the kinds are.
Each joint lies on an *axis* of the constraint that the chain realizes: that of the platform's
primitive, that of the base's, or the leg between them. The velocities that a joint allows are
screws (angular velocity, velocity of the point at the origin). The number of freedoms of a chain is
the rank of its screws, computed without rounding at a configuration with rational coordinates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum
from fractions import Fraction
from functools import cached_property

from gspcli.records import dataclass

#: A vector with three exact components.
Vector = tuple[Fraction, Fraction, Fraction]
#: A line in space: a point of it and its direction (of any length).
Line = tuple[Vector, Vector]
#: A velocity of a rigid body: angular velocity, then the velocity of the point at the origin.
Screw = tuple[Fraction, ...]


class JointKind(Enum):
    """A joint, by its letter in the paper."""

    REVOLUTE = "R"
    PRISMATIC = "P"
    CYLINDRICAL = "C"
    SPHERICAL = "S"
    PLANAR = "E"

    @property
    def letter(self) -> str:
        """The letter, such as ``R``."""
        return self.value

    @property
    def freedoms(self) -> int:
        """The freedoms of the motion that the joint allows."""
        return len(joint_screws(self, _SAMPLE_LINE))


class JointAxis(Enum):
    """The place of a joint of a chain.

    Attributes
    ----------
    PLATFORM, BASE
        At the primitive of that body: the point, the line, or a normal of the plane.
    LEG
        Along the driven direction: the shortest connection for a distance, the common
        perpendicular of the two directions for an angle.
    ACROSS, ACROSS_TOO
        Through the end of the leg at the base, perpendicular to the leg and to each other.
    """

    PLATFORM = "platform"
    BASE = "base"
    LEG = "leg"
    ACROSS = "across"
    ACROSS_TOO = "across-too"

    @property
    def mirrored(self) -> JointAxis:
        """The axis after platform and base are exchanged."""
        return {JointAxis.PLATFORM: JointAxis.BASE, JointAxis.BASE: JointAxis.PLATFORM}.get(
            self, self
        )


@dataclass(frozen=True)
class PlacedJoint:
    """A joint of a chain.

    Attributes
    ----------
    joint
        The joint; a driven one is revolute or prismatic.
    axis
        Where it lies.
    driven
        Whether a motor moves it.
    """

    joint: JointKind
    axis: JointAxis
    driven: bool = False

    def __str__(self) -> str:
        return self.joint.letter + "*" * self.driven


@dataclass(frozen=True)
class Chain:
    """Joints in series, from the platform to the base.

    Attributes
    ----------
    joints
        The joints in order.
    """

    joints: tuple[PlacedJoint, ...]

    @property
    def name(self) -> str:
        """The joints by their letters, the driven ones starred: ``S-P*-C``."""
        return "-".join(map(str, self.joints))

    @property
    def drawing(self) -> str:
        """The chain between the two bodies: ``platform ─S─P*─C─ base``."""
        return f"platform ─{'─'.join(map(str, self.joints))}─ base"

    @cached_property
    def freedoms(self) -> int:
        """The sum of the freedoms of the joints."""
        return sum(placed.joint.freedoms for placed in self.joints)

    @property
    def driven(self) -> int:
        """The number of driven joints."""
        return sum(placed.driven for placed in self.joints)

    @property
    def locked(self) -> Chain:
        """The chain with its driven joints held."""
        return Chain(tuple(placed for placed in self.joints if not placed.driven))

    @property
    def driven_outside(self) -> Chain:
        """The chain with its driven joints moved to the base, beyond all others."""
        return Chain(self.locked.joints + tuple(placed for placed in self.joints if placed.driven))

    @property
    def mirrored(self) -> Chain:
        """The chain with platform and base exchanged."""
        return Chain(
            tuple(PlacedJoint(p.joint, p.axis.mirrored, p.driven) for p in reversed(self.joints))
        )

    def screws(self, axes: Mapping[JointAxis, Line]) -> tuple[Screw, ...]:
        """Return the screws of all joints, in order, for axes in given places."""
        return tuple(
            screw
            for placed in self.joints
            for screw in joint_screws(placed.joint, axes[placed.axis])
        )


def chain(text: str) -> Chain:
    """Return a chain from its joints and axes, as ``S:platform P*:leg C:base``.

    >>> chain("S:platform P*:leg C:base").drawing
    'platform ─S─P*─C─ base'
    """
    words = (word.split(":") for word in text.split())
    return Chain(
        tuple(
            PlacedJoint(JointKind(name[0]), JointAxis(axis), name.endswith("*"))
            for name, axis in words
        )
    )


def joint_screws(joint: JointKind, line: Line) -> tuple[Screw, ...]:
    """Return independent screws of a joint whose axis, centre or normal is a line."""
    point, direction = line
    if joint is JointKind.SPHERICAL:
        return tuple(rotation((point, unit)) for unit in _UNITS)
    turn, slide = rotation(line), translation(direction)
    if joint is JointKind.REVOLUTE:
        return (turn,)
    if joint is JointKind.PRISMATIC:
        return (slide,)
    if joint is JointKind.CYLINDRICAL:
        return (turn, slide)
    # The plane is spanned by the products with two axes: without an axis whose component is not
    # zero.
    skipped = next(i for i in range(3) if direction[i])
    inside = [cross(direction, _UNITS[i]) for i in range(3) if i != skipped]
    return (turn, *map(translation, inside))


def rotation(line: Line) -> Screw:
    """Return the screw of a rotation about a line."""
    point, direction = line
    return (*direction, *cross(point, direction))


def translation(direction: Vector) -> Screw:
    """Return the screw of a translation."""
    return (*_ZERO, *direction)


def rank(screws: Sequence[Screw]) -> int:
    """Return the dimension of the space that screws span."""
    return len(screws) - len(dependencies(screws))


def dependencies(screws: Sequence[Screw]) -> list[tuple[Fraction, ...]]:
    """Return a basis of the linear combinations of screws that are zero, as coefficients."""
    count = len(screws)
    rows = [[*screw, *(Fraction(i == j) for j in range(count))] for i, screw in enumerate(screws)]
    for column in range(6):
        pivot = next((row for row in rows if row[column]), None)
        if pivot is not None:
            rows.remove(pivot)
            for row in rows:
                factor = row[column] / pivot[column]
                row[:] = [x - factor * y for x, y in zip(row, pivot, strict=True)]
    return [tuple(row[6:]) for row in rows]


def vector(*components: int) -> Vector:
    """Return a vector with integer components."""
    x, y, z = map(Fraction, components)
    return (x, y, z)


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a: Vector, b: Vector) -> Fraction:
    """Return the scalar product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), start=Fraction(0))


def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def along(a: Vector, factor: Fraction, b: Vector) -> Vector:
    """Return a + factor b."""
    return (a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2])


_ZERO = vector(0, 0, 0)
_UNITS = (vector(1, 0, 0), vector(0, 1, 0), vector(0, 0, 1))
_SAMPLE_LINE: Line = (_ZERO, vector(0, 0, 1))
