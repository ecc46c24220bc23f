"""Lengths of a platform that are out of all proportion: a wrong unit, or joints meant as one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations

from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Point

#: Ratios of lengths above this are pointed out. Poses lose twice as many digits of sixteen.
SUSPICIOUS = 1e7


def out_of_proportion(instance: Instance) -> str | None:
    """Return a sentence on the longest and the shortest length if they do not go together.

    The lengths are the distances that constraints ask for and those of the points of one body.
    """
    lengths = sorted(_lengths(instance))
    if not lengths or lengths[-1][0] <= SUSPICIOUS * lengths[0][0]:
        return None
    (shortest, small), (longest, large) = lengths[0], lengths[-1]
    unit = instance.units.length
    return (
        f"lengths differ by a factor of {longest / shortest:.0e}: {large} {longest:g} {unit}, "
        f"{small} {shortest:g} {unit}; is a unit wrong, or are points meant to be one? "
        "Solving takes long, and may not be complete"
    )


def _lengths(instance: Instance) -> Iterator[tuple[float, str]]:
    """Yield each length that is not zero, and what has it."""
    for number, row in enumerate(instance.constraints, start=1):
        if row.kind.is_distance and row.value.value:
            yield row.value.value, f"distance {number} is"
    platform = {row.platform_name: row.platform for row in instance.constraints}
    base = {row.base_name: row.base for row in instance.constraints}
    for body, primitives in (("platform", platform), ("base", base)):
        points = {name: p.point for name, p in primitives.items() if isinstance(p, Point)}
        for (first, a), (second, b) in combinations(points.items(), 2):
            if length := math.dist(a, b):
                yield length, f"{first} and {second} of the {body} are apart by"
