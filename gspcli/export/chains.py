"""Each constraint as a chain of joints between the bodies, one of them the value itself.

A chain has six joint freedoms: five that the constraint leaves, and that of its value, which a
drive holds or moves. The chains are those of the paper's Section 5 with cylindrical and planar
joints taken apart; all axes are placed at one pose of the platform.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind, Law
from gspcli.errors import ArgumentError
from gspcli.export.simulated_masses import Inertial, SimulatedMasses
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.records import dataclass

Vector = NDArray[np.float64]
#: Lines at a smaller angle than this (radians) are drawn and jointed as parallel ones, and
#: distances below this part of the platform's size as none.
_SMALL = 1e-9
_AXES = np.eye(3)


@dataclass(frozen=True, eq=False)
class ChainJoint:
    """A joint."""

    #: ``hinge``, ``slide`` or ``ball``.
    type: Literal["hinge", "slide", "ball"]
    #: Unit axis, shape (3,), in the axes of the base; meaningless for a ball.
    axis: Vector
    #: A point of the axis, or the centre, shape (3,), in the base's frame.
    point: Vector
    #: What the constraint measures at the pose if this joint is its value, else None: lengths, or
    #: radians. It grows with the joint's coordinate. Zero for a crank or slide at the pose.
    value: float | None = None
    #: The smallest and the largest value of a crank or slide; None if none is stated.
    range: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class Link:
    """A link of a chain, with the joints that lead to it from the base's side."""

    #: Origin of its frame, shape (3,), in the base's frame.
    origin: Vector
    #: In the order from the base to the platform.
    joints: tuple[ChainJoint, ...]


Chain = tuple[Link, ...]


def chain(kind: Kind, x: Vector, v: Vector, y: Vector, w: Vector) -> Chain:
    """Return the chain of a constraint from the base to the platform.

    Parameters
    ----------
    kind
        The kind.
    x, v
        A point and the unit direction of the base's primitive, each shape (3,).
    y, w
        Those of the platform's primitive at the pose, in the base's frame.
    """
    if not kind.is_distance:
        return _angle(kind.law, v, y, w)
    if kind is DPP:
        return _leg(x, y)
    if kind is DPH:
        return _above_base(x, v, y)
    if kind is DHP:
        return _above_platform(x, y, w)
    if kind is DPL:
        return _about_base_line(x, v, y)
    if kind is DLP:
        return _about_platform_line(x, y, w)
    if kind is not DLL:
        raise ValueError(kind)
    return _two_lines(x, v, y, w)


def _leg(x: Vector, y: Vector) -> Chain:
    e, distance = _direction(y - x, _AXES[2])
    first, second = _across(e)
    joints = (
        ChainJoint("hinge", first, x),
        ChainJoint("hinge", second, x),
        ChainJoint("slide", e, x, distance),
    )
    return Link(x, joints), _ball(y)


def driven_leg(x: Vector, y: Vector, axis: Vector | None) -> Chain:
    """Return a leg of two bodies: one on a universal joint at the base, one that slides in it.

    The second ends at the platform's point, where a ball would be.

    Parameters
    ----------
    x, y
        The points of the base and of the platform at the pose.
    axis
        The first axis of the universal joint, a unit vector; any one across the leg if None.
    """
    e, distance = _direction(y - x, _AXES[2])
    cylinder = Link(x, socket(x, y, _across(e)[0] if axis is None else axis))
    return cylinder, Link(y, (ChainJoint("slide", e, x, distance),))


def socket(x: Vector, y: Vector, axis: Vector) -> tuple[ChainJoint, ...]:
    """Return the two hinges of a universal joint at x of a leg to y, with its first axis."""
    second = np.cross(axis, _direction(y - x, _AXES[2])[0])
    return ChainJoint("hinge", axis, x), ChainJoint("hinge", second / np.linalg.norm(second), x)


def _above_base(x: Vector, v: Vector, y: Vector) -> Chain:
    height = float((y - x) @ v)
    side = -1.0 if height < 0 else 1.0
    first, second = _across(v)
    joints = (
        ChainJoint("slide", first, y),
        ChainJoint("slide", second, y),
        ChainJoint("slide", side * v, y, abs(height)),
    )
    return Link(y, joints), _ball(y)


def _above_platform(x: Vector, y: Vector, w: Vector) -> Chain:
    height = float((x - y) @ w)
    side = -1.0 if height < 0 else 1.0
    foot = x - height * w
    first, second = _across(w)
    # The plane recedes from the point against its normal.
    joints = (
        ChainJoint("slide", -side * w, foot, abs(height)),
        ChainJoint("slide", first, foot),
        ChainJoint("slide", second, foot),
    )
    return _ball(x), Link(foot, joints)


def _about_base_line(x: Vector, v: Vector, y: Vector) -> Chain:
    foot = x + ((y - x) @ v) * v
    e, distance = _direction(y - foot, _across(v)[0])
    joints = (
        ChainJoint("slide", v, foot),
        ChainJoint("hinge", v, foot),
        ChainJoint("slide", e, foot, distance),
    )
    return Link(foot, joints), _ball(y)


def _about_platform_line(x: Vector, y: Vector, w: Vector) -> Chain:
    foot = y + ((x - y) @ w) * w
    e, distance = _direction(foot - x, _across(w)[0])
    joints = (
        ChainJoint("slide", e, foot, distance),
        ChainJoint("hinge", w, foot),
        ChainJoint("slide", w, foot),
    )
    return _ball(x), Link(foot, joints)


def _two_lines(x: Vector, v: Vector, y: Vector, w: Vector) -> Chain:
    near, far = feet(x, v, y, w)
    normal = np.cross(w, v)
    spare = normal / np.linalg.norm(normal) if np.linalg.norm(normal) > _SMALL else _across(v)[0]
    n, distance = _direction(far - near, spare)
    joints = (
        ChainJoint("slide", v, near),
        ChainJoint("hinge", v, near),
        ChainJoint("slide", n, near, distance),
        ChainJoint("hinge", n, near),
        ChainJoint("hinge", w, far),
        ChainJoint("slide", w, far),
    )
    return (Link(far, joints),)


def _angle(law: Law, v: Vector, y: Vector, w: Vector) -> Chain:
    normal = np.cross(v, w)
    sine = float(np.linalg.norm(normal))
    n = normal / sine if sine > _SMALL else _across(v)[0]
    between = float(np.arctan2(sine, v @ w))
    # The angle of the directions, or its supplement between planes, its complement of a line
    # and a plane (Section 4): both of the latter fall when the directions open.
    if law is Law.COSINE:
        value, axis = between, n
    else:
        value, axis = (np.pi if law.is_cosine else np.pi / 2) - between, -n
    slides = tuple(ChainJoint("slide", unit, y) for unit in _AXES)
    turns = (
        ChainJoint("hinge", v, y),
        ChainJoint("hinge", axis, y, value),
        ChainJoint("hinge", w, y),
    )
    return (Link(y, slides + turns),)


def feet(x: Vector, v: Vector, y: Vector, w: Vector) -> tuple[Vector, Vector]:
    """Return the feet of the common perpendicular of two lines, on the first and on the second.

    Of parallel lines it is the perpendicular at the given point of the first.
    """
    r, cosine = y - x, float(v @ w)
    square = 1 - cosine * cosine
    along = 0.0 if square < _SMALL**2 else float(r @ v - cosine * (r @ w)) / square
    near = x + along * v
    return near, y + ((near - y) @ w) * w


def ball(centre: Vector) -> tuple[ChainJoint, ...]:
    """Return a ball joint."""
    return (ChainJoint("ball", _AXES[2], centre),)


def _ball(centre: Vector) -> Link:
    return Link(centre, ball(centre))


def _direction(difference: Vector, spare: Vector) -> tuple[Vector, float]:
    """Return the unit vector of a difference, or a spare one for none, and the length."""
    length = float(np.linalg.norm(difference))
    return (spare, length) if length < _SMALL else (difference / length, length)


def _across(w: Vector) -> tuple[Vector, Vector]:
    """Return two unit vectors perpendicular to a unit vector and to each other."""
    first = np.cross(w, _AXES[np.argmin(np.abs(w))])
    first /= np.linalg.norm(first)
    return first, np.cross(w, first)


# The arms and carriages of a simulated model: what its drives move beside the platform.
#
# A crank is a hinge with an arm, a slide a carriage on a rail. The rod of a constraint leads from
# there to the other body, with a ball joint at either end. Coordinates are zero where the instance
# states the points.


@dataclass(frozen=True, eq=False)
class Carrier:
    """An arm or a carriage, with the joint that its drive moves.

    Vectors are in the frame of its body, in metres.
    """

    #: The constraints whose rods it carries, from 0; names in models have the first of them.
    constraints: tuple[int, ...]
    #: Whether its body is the platform.
    on_platform: bool
    #: The hinge or slide, with the coordinate zero and its range. Its point is the origin of the
    #: carrier's frame: where the arm meets the axis of a crank, or the point of the carriage.
    joint: ChainJoint
    #: The length of the arm, or None for a carriage.
    lever: float | None
    #: Its mass, centre and inertia.
    inertial: Inertial

    @property
    def number(self) -> int:
        """The number in names of the model: its first constraint, from 1."""
        return self.constraints[0] + 1

    @property
    def name(self) -> str:
        """The name of its body."""
        return f"{'carriage' if self.lever is None else 'arm'}_{self.number}"


def carriers(instance: Instance, masses: SimulatedMasses, metre: float) -> tuple[Carrier, ...]:
    """Return the arms and carriages of an instance; none if no drive is a crank or a slide."""
    drives = Machine.of(instance)
    for row, driven in zip(instance.constraints, drives.driven, strict=True):
        if driven and row.kind is not DPP:
            name = row.kind.name
            message = f"found a {name} with a crank or slide, expected distances of two points"
            raise ArgumentError(f"{message}: models have rods between arms and the other body")
    found = []
    for drive, sort in enumerate(drives.sorts):
        if sort == "value":
            continue
        rows = tuple(int(k) for k in np.flatnonzero(drives.index == drive))
        k = rows[0]
        turns = sort == "crank"
        kind: Literal["hinge", "slide"] = "hinge" if turns else "slide"
        axis = np.cross(drives.across[k], drives.beside[k]) if turns else drives.beside[k]
        axis = axis / np.linalg.norm(axis)
        span = np.array([drives.low[drive], drives.high[drive]]) * (1.0 if turns else metre)
        limits = (float(span[0]), float(span[1])) if np.isfinite(span).all() else None
        found.append(
            Carrier(
                rows,
                bool(drives.on_platform[k]),
                ChainJoint(kind, axis, drives.middle[k] * metre, 0.0, limits),
                float(drives.arms[k]) * metre if turns else None,
                masses.carrier(k, drives.across[k]),
            )
        )
    return tuple(found)
