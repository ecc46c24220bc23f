"""Lengths of a platform that differ too much: a wrong unit, or joints that should be one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations

import numpy as np

from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Geometry, Line, Plane, Point
from gspcli.geometry.tolerances import PARALLEL_SINE_IN_FILES

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
    yield "platform", {row.platform_name: row.platform for row in rows}
    yield "base", {row.base_name: row.base for row in rows}


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
