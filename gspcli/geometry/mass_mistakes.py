"""Mistakes in masses, inertias and drives: impossible bodies, wrong numbers of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np

from gspcli.catalogue.kinds import DPP
from gspcli.geometry.drives import driven_points
from gspcli.geometry.instance import Constraint
from gspcli.geometry.lengths import METRES
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
from gspcli.wording import counted, listed, shown, suggestion

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
