"""Checks of an instance: six constraints, at most three angles, values in range."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP, Kind
from gspcli.catalogue.types import CONSTRAINTS, MAX_ANGLES
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import METRES, AngleUnit, Constraint, Instance, Shapes, Side
from gspcli.geometry.machine import driven_points
from gspcli.geometry.masses import (
    INERTIA_ENTRIES,
    Arm,
    Carriage,
    Drives,
    Dynamics,
    Leg,
    LegBody,
    RigidBody,
)
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point, Vector
from gspcli.wording import counted, listed, shown, suggestion

#: A quarter turn in each unit; the one in radians is only rounded.
_QUARTER = {AngleUnit.DEGREE: 90, AngleUnit.RADIAN: math.pi / 2}
#: Below this part of a quarter turn rounding does not matter.
_WELL_WITHIN = 0.999
_QUARTER_TEXT = {AngleUnit.DEGREE: ("90", "180"), AngleUnit.RADIAN: ("pi/2", "pi")}


#: The place of a mistake: keys and indices from the top of the file.
Place: TypeAlias = "tuple[str | int, ...]"


def turns(value: Number, unit: AngleUnit) -> Fraction | float:
    """Return an angle in quarter turns, exactly if it is a rational number of degrees."""
    exact = value.fraction
    if exact is not None and unit is AngleUnit.DEGREE:
        return exact / 90
    quarters = value.value / _QUARTER[unit]
    # acos(-1) and pi are the same number with different roundings.
    near = round(quarters)
    return near if math.isclose(quarters, near, rel_tol=4e-16) else quarters


def wrong_value(kind: Kind, value: Number, unit: AngleUnit) -> str:
    """Return what is wrong with the value of a constraint, or nothing.

    A distance is at least zero. The angle of two lines or two planes is that of their directions
    or normals, between 0 and 180 degrees. The angle of a line and a plane is between -90 and 90,
    positive if the line's direction points to the side of the plane's normal (Section 4).
    """
    if kind.is_distance:
        return "expected a distance of at least 0" if value.value < 0 else ""
    if 0 < value.value < _QUARTER[unit] * _WELL_WITHIN:
        return ""
    quarter, half = _QUARTER_TEXT[unit]
    quarters = turns(value, unit)
    if kind.platform is kind.base:
        if not 0 <= quarters <= 2:
            return f"expected an angle of {kind.short} from 0 to {half} ({unit.value})"
    elif not -1 <= quarters <= 1:
        return f"expected an angle of {kind.short} from -{quarter} to {quarter} ({unit.value})"
    return ""


def wrong_scale(scale: Number) -> str:
    """Return what is wrong with the scale of the values of a constraint, or nothing."""
    if -1 < scale.value < 1:
        return ""
    return "expected a number between -1 and 1: readings are multiplied by 1 + scale"


def value_range(kind: Kind, unit: AngleUnit) -> tuple[float, float]:
    """Return the least and the greatest value of a kind, planes signed, angles in their unit."""
    if kind.is_distance:
        return (-math.inf if kind.has_sides else 0.0), math.inf
    quarter = float(_QUARTER[unit])
    return (0.0, 2 * quarter) if kind.platform is kind.base else (-quarter, quarter)


def wrong_half_angle(value: Number, unit: AngleUnit) -> str:
    """Return what is wrong with the half angle of a cone, or nothing."""
    if 0 < turns(value, unit) < 2:
        return ""
    return f"expected a half angle above 0 and below {_QUARTER_TEXT[unit][1]} ({unit.value})"


#: Most points of a hull: all of them are compared at each pose.
MOST_POINTS = 1000


def refuse_shape_mistakes(shapes: Shapes, rows: Sequence[Constraint]) -> None:
    """Raise `ArgumentError` if something is wrong with shapes for some constraints."""
    for place, message in shape_mistakes(shapes, rows):
        raise ArgumentError(message, _keys(("shapes", *place)).replace("diameter", "diameters"))


def _keys(place: Place) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)[1:]


def shape_mistakes(shapes: Shapes, rows: Sequence[Constraint]) -> Iterator[tuple[Place, str]]:
    """Yield what is wrong with shapes: the keys of the place in a file, and a sentence."""
    legs = sum(row.kind is DPP for row in rows)
    if not legs:
        yield (), "found shapes, but no distance of two points: only legs have a diameter"
        return
    count = len(shapes.diameters)
    if count not in (1, legs):
        each = f"{legs}, one for each leg," if legs > 1 else "one"
        yield ("diameter",), f"found {count} diameters, expected {each} or one for all"
    for k, one in enumerate(shapes.diameters):
        if one.value < 0:
            place: Place = ("diameter", k) if count > 1 else ("diameter",)
            yield place, f"found {one}, expected a diameter of at least 0"
    if shapes.near_joint is not None and shapes.near_joint.value < 0:
        yield ("near_joint",), f"found {shapes.near_joint}, expected a length of at least 0"
    for name in ("platform", "base"):
        points: tuple[Vector, ...] = getattr(shapes, name)
        if points and shapes.near_joint is None:
            message = (
                f"found the hull of the {name} without near_joint, expected both: legs meet it"
            )
            yield (name,), message
        if len(points) > MOST_POINTS:
            yield (name,), f"found {len(points)} points, expected at most {MOST_POINTS}"


#: Rounding may break the triangle inequality of principal moments by this share: a plate has
#: equality.
_ROUNDING = 1e-9
#: A drive: its sort, the body and the name of its point.
Motor: TypeAlias = "tuple[str, str, str]"


def mass_mistakes(
    dynamics: Dynamics, rows: Sequence[Constraint], length: str
) -> Iterator[tuple[Place, str]]:
    """Yield the mistakes in masses: the place of each, and what was found and expected.

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


#: The error for an offset of a distance to a plane without a side.
ONE_SIDE = "expected one only with a side: it is added to the signed distance"


def expected(instance: Instance) -> Instance:
    """Return an argument if it is an instance; its numbers are not checked.

    Raises
    ------
    ArgumentError
        If it is not.
    """
    if not isinstance(instance, Instance):
        raise ArgumentError(
            f"found a {type(instance).__name__}, expected an Instance: load reads one", "instance"
        )
    return instance


def real_array(given: Any, name: str) -> NDArray[np.float64]:
    """Return numbers as an array of doubles; complex ones must be real.

    Raises
    ------
    ArgumentError
        If they are no real numbers.
    """
    try:
        array = np.asarray(given)
        if array.dtype.kind == "c" and not array.imag.any():
            array = array.real
        if array.dtype.kind in "cUS":
            raise TypeError
        return array.astype(float)
    except (TypeError, ValueError):
        what = f"a {type(given).__name__}"
        if isinstance(given, np.ndarray) and given.dtype.kind == "c":
            what = "complex numbers"
        raise ArgumentError(f"found {what}, expected an array of real numbers", name) from None


def checked(instance: Instance) -> Instance:
    """Return an instance if it has six constraints, at most three angles and values in range.

    Raises
    ------
    ArgumentError
        Naming the first constraint, from 0, that is wrong.
    """
    rows = expected(instance).constraints
    for index, row in enumerate(rows):
        try:
            wrong = wrong_value(row.kind, row.value, instance.units.angle)
        except (ValueError, ArithmeticError):
            wrong = "which is no real number"
        if wrong:
            raise ArgumentError(f"found {row.value}, {wrong}", f"constraints[{index}].value")
        if row.limits and row.limits[0].value > row.limits[1].value:
            low, high = row.limits
            raise ArgumentError(
                f"found {low} above {high}, expected (low, high)", f"constraints[{index}].range"
            )
        if row.side is not Side.BOTH and not row.kind.has_sides:
            raise ArgumentError(
                f"found a side for {row.kind}, expected one only for DPH and DHP",
                f"constraints[{index}].side",
            )
        if row.offset is not None and row.kind.has_sides and row.side is Side.BOTH:
            raise ArgumentError(
                f"found an offset for {row.kind}, {ONE_SIDE}", f"constraints[{index}].offset"
            )
        if row.scale is not None and (wrong := wrong_scale(row.scale)):
            raise ArgumentError(f"found {row.scale}, {wrong}", f"constraints[{index}].scale")
        for where, primitive in (("platform", row.platform), ("base", row.base)):
            cone = primitive.cone if isinstance(primitive, Point) else None
            if cone and (wrong := wrong_half_angle(cone.half_angle, instance.units.angle)):
                raise ArgumentError(
                    f"found {cone.half_angle}, {wrong}",
                    f"constraints[{index}].{where}.cone.half_angle",
                )
            if cone and not any(
                other.kind is DPP and primitive == getattr(other, where) for other in rows
            ):
                raise ArgumentError(
                    "found a cone at a point without a leg (DPP), whose direction it limits",
                    f"constraints[{index}].{where}.cone",
                )
    if len(rows) != CONSTRAINTS:
        raise ArgumentError(f"found {len(rows)} constraints, expected exactly six", "constraints")
    angles = sum(not row.kind.is_distance for row in rows)
    if angles > MAX_ANGLES:
        raise ArgumentError(
            f"found {angles} angles, expected at most three: "
            "three fix the orientation (Definition 2.1)",
            "constraints",
        )
    if instance.dynamics is not None:
        for place, message in mass_mistakes(instance.dynamics, rows, instance.units.length):
            raise ArgumentError(message, _keys(place))
    if instance.shapes is not None:
        refuse_shape_mistakes(instance.shapes, rows)
    return instance
