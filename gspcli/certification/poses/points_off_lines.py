"""Points of a body that are nearly on a line, and the platforms with them farther from it.

The distances of points on a line from another line are square roots of a polynomial of degree two
in the place on the line: three of them determine all others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from math import inf

from flint import arb, ctx

from gspcli.catalogue.kinds import DLP, DPL
from gspcli.certification.equations.statement import statements
from gspcli.certification.numbers.balls import dot, norm
from gspcli.certification.poses.special_family import DIFFERENCE_BITS, SpecialFamily
from gspcli.geometry.instance import Instance
from gspcli.geometry.tolerances import OFF_LINES

#: Of three points on a line the distances from another line are independent.
_FEWEST = 4


def points_off_lines(instance: Instance) -> SpecialFamily | None:
    """Return a platform among those with its points moved off their line.

    The result is None if no points of a body are nearly on a line.
    """
    differences: list[dict[str, list[arb]]] = [{} for _ in instance.constraints]
    size = 0.0
    with ctx.workprec(DIFFERENCE_BITS):
        given = list(enumerate(statements(instance)))
        for kind, name in ((DPL, "a"), (DLP, "b")):
            points = {k: getattr(row, name) for k, row in given if row.kind is kind}
            for k, (off, far) in _off_line(points).items():
                differences[k][name] = off
                size = max(size, far)
    return SpecialFamily(instance, tuple(differences), size) if size else None


def _off_line(points: Mapping[int, Sequence[arb]]) -> Mapping[int, tuple[list[arb], float]]:
    """Return points less their feet on the line of two points, and their sizes, by index.

    It is the line with the most others near it, of two points far from each other.
    """
    found: dict[int, tuple[list[arb], float]] = {}
    best = (_FEWEST - 1, inf)
    for a, b in combinations(points.values(), 2):
        along = [x - y for x, y in zip(b, a, strict=True)]
        if norm(along).contains(0):
            continue
        near = {k: off for k, point in points.items() if (off := _off(point, a, along))}
        number = (len(near), float(norm(along).mid()))
        if number > best:
            best, found = number, near
    least, _ = OFF_LINES
    return {k: (off, size) for k, (off, size) in found.items() if size > least}


def _off(
    point: Sequence[arb], a: Sequence[arb], along: Sequence[arb]
) -> tuple[list[arb], float] | None:
    """Return a point less its foot on the line through a along a vector, if it is near."""
    place = [x - y for x, y in zip(point, a, strict=True)]
    part = dot(place, along) / dot(along, along)
    off = [x - part * y for x, y in zip(place, along, strict=True)]
    size = float((norm(off) / norm(along)).mid())
    _, most = OFF_LINES
    return (off, size) if size < most else None
