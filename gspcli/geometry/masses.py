"""Masses, inertias and drives of a platform, as an instance file states them under `dynamics`.

Lengths are in the unit of length of the instance, inertias in kilogrammes times its square; masses
are in kilogrammes, gravity in m/s^2, stiffnesses in N/m (distances) and N m/rad (angles).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gspcli.geometry.numbers import Number, Real
from gspcli.geometry.primitives import Components, Vector, exact_direction, exact_vector
from gspcli.records import dataclass

#: The entries of a matrix of inertia in the order of `RigidBody.inertia`.
INERTIA_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
#: The acceleration of gravity if none is stated.
GRAVITY = (Number.of(0), Number.of(0), Number.of("-9.81"))


def _row(values: Sequence[Real], where: str) -> tuple[Number, ...]:
    return tuple(Number.of(value, f"{where}[{index}]") for index, value in enumerate(values))


@dataclass(frozen=True, init=False)
class RigidBody:
    """A rigid body.

    Attributes
    ----------
    mass
        Above zero.
    centre
        Its centre of mass, in its frame.
    inertia
        The matrix of inertia about the centre of mass, in the axes of the frame: its entries xx,
        yy, zz, xy, xz, yz. Those off the diagonal are minus the integrals of x y, x z and y z.
    """

    mass: Number
    centre: Vector
    inertia: tuple[Number, ...]

    def __init__(self, mass: Real, centre: Components, inertia: Sequence[Real]) -> None:
        object.__setattr__(self, "mass", Number.of(mass, "mass"))
        object.__setattr__(self, "centre", exact_vector(centre, "centre"))
        object.__setattr__(self, "inertia", _row(inertia, "inertia"))

    @property
    def matrix(self) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        """The matrix of inertia, shape (3, 3)."""
        matrix = np.zeros((3, 3))
        for (i, j), entry in zip(INERTIA_ENTRIES, self.inertia, strict=True):
            matrix[i, j] = matrix[j, i] = entry.value
        return matrix


@dataclass(frozen=True, init=False)
class LegBody:
    """One of the two bodies of a leg; it has the same inertia about every axis across the leg.

    Attributes
    ----------
    mass
        Above zero.
    centre
        The distance of its centre of mass from its joint, along the leg towards the other joint.
    inertia
        About any axis through the centre of mass across the leg.
    axial
        About the leg itself. It acts only where a universal joint makes the leg spin.
    """

    mass: Number
    centre: Number
    inertia: Number
    axial: Number

    def __init__(self, mass: Real, centre: Real, inertia: Real = 0, axial: Real = 0) -> None:
        for name, value in zip(self._names, (mass, centre, inertia, axial), strict=True):
            object.__setattr__(self, name, Number.of(value, name))

    _names = ("mass", "centre", "inertia", "axial")


@dataclass(frozen=True, init=False)
class Leg:
    """The bodies of a leg, a distance of two points.

    Attributes
    ----------
    cylinder
        The body at the joint of the base, or None if it has no mass.
    rod
        The body at the joint of the platform, or None if it has no mass.
    universal
        The first axis of a universal joint at the base: a vector fixed in the base, of any length.
        The joint at the platform is a ball then. None if the leg does not spin about its axis.
    """

    cylinder: LegBody | None
    rod: LegBody | None
    universal: Vector | None

    def __init__(
        self,
        cylinder: LegBody | None = None,
        rod: LegBody | None = None,
        universal: Components | None = None,
    ) -> None:
        axis = None if universal is None else exact_direction(universal, "universal")
        object.__setattr__(self, "cylinder", cylinder)
        object.__setattr__(self, "rod", rod)
        object.__setattr__(self, "universal", axis)


@dataclass(frozen=True, init=False)
class Arm:
    """The arm of a crank.

    Attributes
    ----------
    mass
        Above zero.
    centre
        The distance of its centre of mass from the axis, along the arm; negative for a
        counterweight.
    inertia
        About the line through its centre of mass that is parallel to the axis.
    """

    mass: Number
    centre: Number
    inertia: Number

    def __init__(self, mass: Real, centre: Real, inertia: Real = 0) -> None:
        for name, value in (("mass", mass), ("centre", centre), ("inertia", inertia)):
            object.__setattr__(self, name, Number.of(value, name))


@dataclass(frozen=True, init=False)
class Carriage:
    """The carriage of a slide; its mass is above zero."""

    mass: Number

    def __init__(self, mass: Real) -> None:
        object.__setattr__(self, "mass", Number.of(mass, "mass"))


@dataclass(frozen=True, init=False)
class Drives:
    """The drives: values, cranks and slides. Each attribute is one number for all, or one each.

    Attributes
    ----------
    inertia
        The inertia that a drive adds: kilogrammes for a length, a moment of inertia for an angle.
    stiffness
        The stiffness with which a drive holds its length or angle, or None if it is not stated.
    """

    inertia: tuple[Number, ...]
    stiffness: tuple[Number, ...] | None

    def __init__(
        self, inertia: Real | Sequence[Real] = 0, stiffness: Real | Sequence[Real] | None = None
    ) -> None:
        held = None if stiffness is None else _several(stiffness, "stiffness")
        object.__setattr__(self, "inertia", _several(inertia, "inertia"))
        object.__setattr__(self, "stiffness", held)


def _several(value: Real | Sequence[Real], where: str) -> tuple[Number, ...]:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, Sequence) and not isinstance(value, str):
        return _row(value, where)
    return (Number.of(value, where),)


@dataclass(frozen=True, init=False)
class Dynamics:
    """The masses and the drives of a platform.

    Attributes
    ----------
    platform
        The moving platform.
    legs
        One leg for all distances of two points, or one for each of them in their order; empty if
        the legs have no mass.
    drives
        The drives.
    gravity
        The acceleration of gravity, in the axes of the base, m/s^2.
    arms
        One arm for all cranks, or one for each in the order of the drives; empty without mass.
    carriages
        One carriage for all slides, or one for each, likewise.
    """

    platform: RigidBody
    legs: tuple[Leg, ...]
    drives: Drives
    gravity: Vector
    arms: tuple[Arm, ...] = ()
    carriages: tuple[Carriage, ...] = ()

    def __init__(
        self,
        platform: RigidBody,
        legs: Leg | Sequence[Leg] = (),
        drives: Drives | None = None,
        gravity: Components = GRAVITY,
        arms: Arm | Sequence[Arm] = (),
        carriages: Carriage | Sequence[Carriage] = (),
    ) -> None:
        object.__setattr__(self, "platform", platform)
        object.__setattr__(self, "legs", (legs,) if isinstance(legs, Leg) else tuple(legs))
        object.__setattr__(self, "drives", drives or Drives())
        object.__setattr__(self, "gravity", exact_vector(gravity, "gravity"))
        object.__setattr__(self, "arms", (arms,) if isinstance(arms, Arm) else tuple(arms))
        carried = (carriages,) if isinstance(carriages, Carriage) else tuple(carriages)
        object.__setattr__(self, "carriages", carried)
