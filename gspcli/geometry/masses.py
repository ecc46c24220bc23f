"""Masses, inertias and drives of a platform, as an instance file states them under `dynamics`.

Lengths are in the unit of length of the instance, inertias in kilogrammes times its square; masses
are in kilogrammes, gravity in m/s^2, stiffnesses in N/m (distances) and N m/rad (angles).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np

from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.drive_numbers import driven_points
from gspcli.geometry.instance import Constraint
from gspcli.geometry.lengths import METRES
from gspcli.geometry.numbers import Number, Real
from gspcli.geometry.primitives import Components, Vector, exact_direction, exact_vector
from gspcli.records import dataclass
from gspcli.wording import counted, listed, shown, suggestion

#: The entries of a matrix of inertia in the order of `RigidBody.inertia`.
INERTIA_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
#: The acceleration of gravity if none is stated.
GRAVITY = (Number.of(0), Number.of(0), Number.of("-9.81"))


def _exact(value: Real, where: str) -> Number:
    try:
        return Number.of(value)
    except ArgumentError as error:
        raise error.within(where) from None


def _row(values: Sequence[Real], where: str) -> tuple[Number, ...]:
    return tuple(_exact(value, f"{where}[{index}]") for index, value in enumerate(values))


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
        object.__setattr__(self, "mass", _exact(mass, "mass"))
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
            object.__setattr__(self, name, _exact(value, name))

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
            object.__setattr__(self, name, _exact(value, name))


@dataclass(frozen=True, init=False)
class Carriage:
    """The carriage of a slide; its mass is above zero."""

    mass: Number

    def __init__(self, mass: Real) -> None:
        object.__setattr__(self, "mass", _exact(mass, "mass"))


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
        self,
        inertia: Real | Sequence[Real] = 0,
        stiffness: Real | Sequence[Real] | None = None,
    ) -> None:
        held = None if stiffness is None else _several(stiffness, "stiffness")
        object.__setattr__(self, "inertia", _several(inertia, "inertia"))
        object.__setattr__(self, "stiffness", held)


def _several(value: Real | Sequence[Real], where: str) -> tuple[Number, ...]:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, Sequence) and not isinstance(value, str):
        return _row(value, where)
    return (_exact(value, where),)


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


#: Rounding may break the triangle inequality of principal moments by this share: a plate has
#: equality.
_ROUNDING = 1e-9
#: The place of a mistake: keys and indices from the top of the file.
Place: TypeAlias = "tuple[str | int, ...]"
#: A drive: its sort, the body and the name of its point.
Motor: TypeAlias = "tuple[str, str, str]"


def mistakes(
    dynamics: Dynamics, rows: Sequence[Constraint], length: str
) -> Iterator[tuple[Place, str]]:
    """Yield the mistakes: the place of each, and what was found and expected.

    Parameters
    ----------
    dynamics
        The stated masses and drives.
    rows
        The constraints.
    length
        The name of the unit of length.
    """
    if length not in METRES:
        message = (
            f"found {shown(length)}, expected {listed(METRES)}: with masses lengths are taken to "
            f"metres{suggestion(length, METRES)}"
        )
        yield ("units", "length"), message
    motors = _motors(rows)
    for part, found in (
        ("platform", _of_platform(dynamics.platform)),
        ("legs", _of_legs(dynamics.legs, [row for row in rows if row.kind is DPP])),
        ("drives", _of_drives(dynamics.drives, len(motors))),
        ("arms", _of_arms(dynamics.arms, [one for one in motors if one[0] == "crank"])),
        ("carriages", _of_carriages(dynamics.carriages, [m for m in motors if m[0] == "slide"])),
    ):
        for place, message in found:
            yield ("dynamics", part, *place), message


def _of_platform(body: RigidBody) -> Iterator[tuple[Place, str]]:
    yield from _of_mass(body.mass)
    if len(body.inertia) != len(INERTIA_ENTRIES):
        found = counted(len(body.inertia), "number")
        yield ("inertia",), f"found {found}, expected six: xx, yy, zz, xy, xz, yz"
        return
    low, middle, high = np.linalg.eigvalsh(body.matrix).tolist()
    found = f"found the principal moments {low:.6g}, {middle:.6g} and {high:.6g}, expected "
    if not low > 0:
        yield ("inertia",), f"{found}all above 0: give xx, yy, zz, xy, xz, yz about the centre"
    elif high > (low + middle) * (1 + _ROUNDING):
        yield (
            ("inertia",),
            f"{found}none above the sum of the others: no body is so "
            "(xy, xz, yz are entries of the matrix, not integrals: perhaps change their signs)",
        )


def _of_mass(mass: Number) -> Iterator[tuple[Place, str]]:
    if not mass.value > 0:
        yield ("mass",), f"found {mass}, expected a mass above 0"


def _motors(rows: Sequence[Constraint]) -> list[Motor]:
    """Return the drives of constraints: their sorts, the bodies and names of their points."""
    found: dict[Motor, None] = {}
    for k, row in enumerate(rows, 1):
        points = driven_points(row)
        for one in points:
            found[one.drive.sort, one.body, one.point.partner or one.name or str(k)] = None
        if not points:
            found["value", "", str(k)] = None
    return list(found)


def _of_bodies(
    bodies: Sequence[Arm] | Sequence[Carriage], motors: list[Motor], sort: str
) -> Iterator[tuple[Place, str]]:
    """Yield what is wrong with the number or the place of arms or carriages."""
    if not bodies:
        return
    if not motors:
        yield (), f"found what no drive moves: no point has a {sort}"
    elif any(body == "platform" for _, body, _ in motors):
        name = next(name for _, body, name in motors if body == "platform")
        message = f"found masses, but {sort}.{name} is on the platform: add them to its mass"
        yield (), message
    elif len(bodies) not in (1, len(motors)):
        expected = f"one for all, or {len(motors)}: one for each {sort}"
        yield (), f"found {len(bodies)}, expected {expected}"


def _of_arms(arms: Sequence[Arm], motors: list[Motor]) -> Iterator[tuple[Place, str]]:
    yield from _of_bodies(arms, motors, "crank")
    for index, arm in enumerate(arms):
        where: Place = () if len(arms) == 1 else (index,)
        for place, message in _of_mass(arm.mass):
            yield (*where, *place), message
        if arm.inertia.value < 0:
            yield (*where, "inertia"), f"found {arm.inertia}, expected an inertia of at least 0"


def _of_carriages(
    carriages: Sequence[Carriage], motors: list[Motor]
) -> Iterator[tuple[Place, str]]:
    yield from _of_bodies(carriages, motors, "slide")
    for index, carriage in enumerate(carriages):
        where: Place = () if len(carriages) == 1 else (index,)
        for place, message in _of_mass(carriage.mass):
            yield (*where, *place), message


def _of_legs(legs: Sequence[Leg], rods: Sequence[Constraint]) -> Iterator[tuple[Place, str]]:
    count = len(rods)
    if legs and not count:
        yield (), "found legs, but no constraint is a distance of two points"
    elif len(legs) > 1 and len(legs) != count:
        expected = f"one for all, or {count}: one for each distance of two points"
        yield (), f"found {len(legs)} legs, expected {expected}"
    for index, leg in enumerate(legs):
        where: Place = () if len(legs) == 1 else (index,)
        if leg.cylinder is None and leg.rod is None:
            yield where, "found no body, expected a cylinder, a rod or both"
        own = rods if len(legs) == 1 else rods[index : index + 1]
        if leg.universal is not None and (name := _on_crank(own)):
            message = f"found a universal joint at {name}, whose crank turns its axis: leave it out"
            yield (*where, "universal"), message
        for name, body in (("cylinder", leg.cylinder), ("rod", leg.rod)):
            for place, message in () if body is None else _of_leg_body(body):
                yield (*where, name, *place), message


def _on_crank(rods: Sequence[Constraint]) -> str:
    """Return the name of the first base point of rods that is on a crank, or nothing."""
    for row in rods:
        for one in driven_points(row):
            if one.body == "base" and one.drive.sort == "crank":
                return one.name or "a point"
    return ""


def _of_leg_body(body: LegBody) -> Iterator[tuple[Place, str]]:
    yield from _of_mass(body.mass)
    for name, moment in (("inertia", body.inertia), ("axial", body.axial)):
        if moment.value < 0:
            yield (name,), f"found {moment}, expected an inertia of at least 0"
    most = 2 * body.inertia.value
    if most >= 0 and body.axial.value > most * (1 + _ROUNDING):
        expected = f"at most twice the inertia across the leg, {most:.6g}: no body has more"
        yield ("axial",), f"found {body.axial}, expected {expected}"


def _of_drives(drives: Drives, count: int) -> Iterator[tuple[Place, str]]:
    for name, numbers in (("inertia", drives.inertia), ("stiffness", drives.stiffness)):
        if numbers is None:
            continue
        if len(numbers) not in (1, count):
            several = "six" if count == len("123456") else str(count)
            yield (name,), f"found {len(numbers)} numbers, expected one for all, or {several}"
        for index, number in enumerate(numbers):
            stiff = name == "stiffness"
            if number.value < 0 or (stiff and number.value == 0):
                expected = "a stiffness above 0" if stiff else "an inertia of at least 0"
                place: Place = (name,) if len(numbers) == 1 else (name, index)
                yield place, f"found {number}, expected {expected}"
