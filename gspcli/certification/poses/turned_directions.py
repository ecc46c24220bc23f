"""Directions of a body that are nearly parallel, and the platforms with them turned apart.

Lines that are nearly the same are moved apart, too: lines that meet in a point are special.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb, ctx

from gspcli.certification.equations.statement import statements
from gspcli.certification.numbers.balls import dot, norm
from gspcli.certification.poses.special_family import DIFFERENCE_BITS, SpecialFamily
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.primitives import Line
from gspcli.geometry.tolerances import TURNED_APART_RADIANS


def turned_directions(instance: Instance) -> SpecialFamily | None:
    """Return a platform among those with its nearly parallel directions turned apart.

    The result is None if no directions of a body are nearly parallel.
    """
    differences: list[dict[str, list[arb]]] = [{} for _ in instance.constraints]
    size = 0.0
    with ctx.workprec(DIFFERENCE_BITS):
        given = statements(instance)
        for vector, point, body in (("u", "a", "platform"), ("v", "b", "base")):
            directions = [getattr(row, vector) for row in given]
            for k in range(len(given)):
                found = _turned(directions, k)
                if found is None:
                    continue
                other, differences[k][vector], angle = found
                size = max(size, angle)
                if all(_is_line(instance.constraints[i], body) for i in (other, k)):
                    offset, far = _offset(
                        getattr(given[k], point), getattr(given[other], point), directions[other]
                    )
                    if 0 < far < TURNED_APART_RADIANS[1]:
                        differences[k][point] = offset
                        size = max(size, far)
    return SpecialFamily(instance, tuple(differences), size) if size else None


def _turned(directions: Sequence[Sequence[arb]], k: int) -> tuple[int, list[arb], float] | None:
    """Return the first direction that one is nearly parallel to, the difference and the angle."""
    for i, other in enumerate(directions[:k]):
        if other and directions[k] and (turn := _turn(other, directions[k])):
            return i, *turn
    return None


def _is_line(row: Constraint, body: str) -> bool:
    """Whether the place of a direction matters, across it."""
    return row.kind.is_distance and isinstance(getattr(row, body), Line)


def _offset(
    point: Sequence[arb], other: Sequence[arb], along: Sequence[arb]
) -> tuple[list[arb], float]:
    """Return a point less its foot on a line, and its distance in units of the scale."""
    place = [x - y for x, y in zip(point, other, strict=True)]
    part = dot(place, along) / dot(along, along)
    offset = [x - part * y for x, y in zip(place, along, strict=True)]
    if all(x.contains(0) for x in offset):
        return offset, 0.0
    return offset, float(norm(offset).mid())


def _turn(other: Sequence[arb], direction: Sequence[arb]) -> tuple[list[arb], float] | None:
    """Return the difference of two directions of the same length, and their angle."""
    length = norm(direction)
    factor = length / norm(other)
    if dot(other, direction) < 0:
        factor = -factor
    difference = [x - factor * y for x, y in zip(direction, other, strict=True)]
    if all(x.contains(0) for x in difference):
        return None
    angle = float((norm(difference) / length).mid())
    least, most = TURNED_APART_RADIANS
    return (difference, angle) if least < angle < most else None
