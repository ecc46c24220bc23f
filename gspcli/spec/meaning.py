"""Remarks about unusual instances, and the primitives that constraints share."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from gspcli.catalogue.coincidence import Bond, over_constraint
from gspcli.catalogue.kinds import DLL, DLP, DPL, DPP
from gspcli.geometry.checking import turns
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point
from gspcli.geometry.tolerances import PARALLEL_SINE_IN_FILES


def equations(constraint: Constraint, unit: AngleUnit) -> int:
    """Return the number of independent equations of a constraint: its valence (Section 2).

    It is one for most constraints. Distance 0 makes two points equal (three equations) and puts a
    point on a line (two). Parallel lines or planes, and a line perpendicular to a plane, have two.
    """
    kind = constraint.kind
    if kind.is_distance:
        if constraint.value.value != 0:
            return 1
        return {DPP: 3, DPL: 2, DLP: 2}.get(kind, 1)
    quarters = turns(constraint.value, unit)
    special = (0, 2) if kind.platform is kind.base else (-1, 1)
    return 2 if quarters in special else 1


def outside(value: Number, limits: tuple[Number, Number]) -> bool:
    """Return whether a value is outside its range, by more than the rounding of doubles."""
    low, high = (limit.value for limit in limits)
    slack = 4e-16 * max(abs(low), abs(high))
    return not low - slack <= value.value <= high + slack


def remarks(instance: Instance) -> list[tuple[int, str]]:
    """Return remarks about an instance: constraint indices from 0 and a sentence each."""
    found: list[tuple[int, str]] = []
    for index, constraint in enumerate(instance.constraints):
        kind, value = constraint.kind, constraint.value
        if constraint.limits is not None and outside(value, constraint.limits):
            reading = constraint.reading_of(value)
            low, high = map(constraint.reading_of, constraint.limits)
            found.append((index, f"the value {reading} is outside its range from {low} to {high}"))
        count = equations(constraint, instance.units.angle)
        if count > 1:
            message = (
                f"{kind.name} with value {value} is {count} equations, not one (Section 2): "
                "perhaps no solution, or infinitely many"
            )
            found.append((index, message))
        elif kind.is_distance and value.value == 0:
            if kind.has_sides and constraint.side is not Side.BOTH:
                message = f"{kind.name} with value 0 has no sides: they are the same"
                found.append((index, message))
            elif kind is DLL:
                message = "DLL with value 0: the lines meet, and every solution counts twice"
                found.append((index, message))
    return found + _dependence(instance)


def sharing(instance: Instance) -> tuple[dict[str, list[int]], dict[str, list[int]]]:
    """Return the shared primitives of platform and base: names, and constraint numbers from 1."""
    users: tuple[dict[str, list[int]], dict[str, list[int]]] = ({}, {})
    for number, constraint in enumerate(instance.constraints, start=1):
        users[0].setdefault(constraint.platform_name, []).append(number)
        users[1].setdefault(constraint.base_name, []).append(number)
    platform, base = ({n: use for n, use in body.items() if len(use) > 1} for body in users)
    return platform, base


def bonds(instance: Instance) -> list[Bond]:
    """Return the constraints with their primitives numbered, equal names as one primitive."""
    platform: dict[str, int] = {}
    base: dict[str, int] = {}
    return [
        Bond(
            constraint.kind,
            platform.setdefault(constraint.platform_name, len(platform) + 1),
            base.setdefault(constraint.base_name, len(base) + 1),
        )
        for constraint in instance.constraints
    ]


def _dependence(instance: Instance) -> list[tuple[int, str]]:
    """Return the proof that the constraints are always dependent, if counting gives one."""
    numbered = bonds(instance)
    found = over_constraint(numbered)
    if found is None:
        return []
    names = {}
    for bond, constraint in zip(numbered, instance.constraints, strict=True):
        names[bond.platform_name] = f"the platform's {constraint.platform_name}"
        names[bond.base_name] = f"the base's {constraint.base_name}"
    named = replace(found, primitives=tuple(_renamed(text, names) for text in found.primitives))
    numbers = " ".join(str(index + 1) for index in found.constraints)
    message = f"no solution, or infinitely many: {named.reason} (constraints {numbers})"
    return [(found.constraints[0], message)]


def _renamed(text: str, names: Mapping[str, str]) -> str:
    words, _, name = text.rpartition(" ")
    return f"{words} {names[name]}".strip()


#: Ratios of lengths above this give a warning. Poses lose twice as many of sixteen digits.
SUSPICIOUS = 1e7


def out_of_proportion(instance: Instance) -> str | None:
    """Return a sentence about the longest and the shortest length if their ratio is too large.

    The lengths are the distances of constraints and those of the points of one body. The longest
    one can also be the distance of a line or plane from a point or line of the same body.
    """
    lengths = sorted(_lengths(instance))
    if not lengths:
        return None
    (shortest, small), (longest, large) = lengths[0], max(lengths[-1], *_offsets(instance))
    if longest <= SUSPICIOUS * shortest:
        return None
    unit = instance.units.length
    return (
        f"lengths differ by a factor of {longest / shortest:.0e}: {large} {longest:g} {unit}, "
        f"{small} {shortest:g} {unit}; is a unit wrong, or are points meant to be one?"
    )


def _lengths(instance: Instance) -> Iterator[tuple[float, str]]:
    """Yield each length that is not zero, and its name."""
    for number, row in enumerate(instance.constraints, start=1):
        if row.kind.is_distance and row.value.value:
            yield row.value.value, f"distance {number} is"
    for body, primitives in _bodies(instance):
        points = {name: p.point for name, p in primitives.items() if isinstance(p, Point)}
        for (first, a), (second, b) in combinations(points.items(), 2):
            if length := math.dist(a, b):
                yield length, f"{first} and {second} of the {body} are apart by"


def _offsets(instance: Instance) -> Iterator[tuple[float, str]]:
    """Yield the distances of lines and planes from points and lines; at least a nameless zero."""
    yield 0.0, ""
    for body, primitives in _bodies(instance):
        for (first, a), (second, b) in combinations(primitives.items(), 2):
            yield _apart(a, b), f"{first} and {second} of the {body} are apart by"


def _bodies(instance: Instance) -> Iterator[tuple[str, dict[str, Geometry]]]:
    rows = instance.constraints
    yield "platform", {row.platform_name or f"{k}": row.platform for k, row in enumerate(rows, 1)}
    yield "base", {row.base_name or f"{k}": row.base for k, row in enumerate(rows, 1)}


def _apart(a: Geometry, b: Geometry) -> float:
    """Return the distance of two primitives; zero for a plane and a line or plane."""
    between = b.point - a.point
    if isinstance(a, Line) and isinstance(b, Line):
        normal = np.cross(a.unit, b.unit)
        if (sine := float(np.linalg.norm(normal))) > PARALLEL_SINE_IN_FILES:
            return abs(float(normal @ between)) / sine
        return float(np.linalg.norm(np.cross(a.unit, between)))
    if isinstance(b, Point):
        a, b = b, a
    if not isinstance(a, Point):
        return 0.0
    if isinstance(b, Plane):
        return abs(float(b.unit @ between))
    if isinstance(b, Line):
        return float(np.linalg.norm(np.cross(b.unit, between)))
    return float(np.linalg.norm(between))
