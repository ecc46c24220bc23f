"""Points of a body that are nearly on a line, and the platforms with them farther from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import combinations
from math import inf
from typing import NamedTuple

from flint import arb, ctx

from gspcli.catalogue.kinds import DLP, DPL
from gspcli.certification.numbers.balls import ball, dot, norm
from gspcli.certification.poses.special_family import DIFFERENCE_BITS, exact
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.primitives import Point, Vector
from gspcli.geometry.tolerances import OFF_LINES
from gspcli.records import dataclass

#: Of three points on a line the distances from another line are independent.
_FEWEST = 4


class _Foot(NamedTuple):
    """The foot of a point on a line, the point less the foot, and its size in lengths."""

    foot: list[arb]
    off: list[arb]
    size: float

    def at(self, s: arb) -> Point:
        """Return the point at s."""
        x, y, z = (exact(a + s * b) for a, b in zip(self.foot, self.off, strict=True))
        return Point((x, y, z))


@dataclass(frozen=True)
class PointsOffLines:
    """A platform with points near a line as a member of a family.

    The distances of points on a line from another line are square roots of a polynomial of degree
    two in the place on the line: three of them determine all others.

    Attributes
    ----------
    instance
        The platform at s = 1.
    platform, base
        The feet of points by the indices of their constraints.
    """

    instance: Instance
    platform: Mapping[int, _Foot]
    base: Mapping[int, _Foot]

    @classmethod
    def of(cls, instance: Instance) -> PointsOffLines | None:
        """Return the family of a platform; None if no points of it are nearly on a line."""
        rows = list(enumerate(instance.constraints))
        with ctx.workprec(DIFFERENCE_BITS):
            platform = _feet({k: row.platform.position for k, row in rows if row.kind is DPL})
            base = _feet({k: row.base.position for k, row in rows if row.kind is DLP})
        return cls(instance, platform, base) if platform or base else None

    @cached_property
    def size(self) -> float:
        """The largest distance from a line, as a part of the distance of two points on it."""
        return max(foot.size for feet in (self.platform, self.base) for foot in feet.values())

    def at(self, s: arb) -> Instance:
        """Return the platform with the differences multiplied by s, to the working precision."""
        rows = enumerate(self.instance.constraints)
        return Instance(tuple(self._moved(k, row, s) for k, row in rows), self.instance.units)

    def _moved(self, k: int, row: Constraint, s: arb) -> Constraint:
        platform = self.platform[k].at(s) if k in self.platform else row.platform
        base = self.base[k].at(s) if k in self.base else row.base
        return Constraint(row.kind, platform, base, row.value, row.side)


def _feet(points: Mapping[int, Vector]) -> dict[int, _Foot]:
    """Return the feet on the line of two points with the most others near it, the longest one."""
    balls = {k: [ball(number) for number in point] for k, point in points.items()}
    feet: dict[int, _Foot] = {}
    best = (_FEWEST - 1, inf)
    for (_, a), (_, b) in combinations(balls.items(), 2):
        along = [x - y for x, y in zip(b, a, strict=True)]
        if norm(along).contains(0):
            continue
        near = {k: foot for k, point in balls.items() if (foot := _foot(point, a, along))}
        number = (len(near), float(norm(along).mid()))
        if number > best:
            best, feet = number, near
    least, _ = OFF_LINES
    return {k: foot for k, foot in feet.items() if foot.size > least}


def _foot(point: Sequence[arb], a: Sequence[arb], along: Sequence[arb]) -> _Foot | None:
    """Return the foot on the line through a along a vector, if a point is near it."""
    place = [x - y for x, y in zip(point, a, strict=True)]
    part = dot(place, along) / dot(along, along)
    off = [x - part * y for x, y in zip(place, along, strict=True)]
    size = float((norm(off) / norm(along)).mid())
    _, most = OFF_LINES
    if not size < most:
        return None
    return _Foot([x - y for x, y in zip(point, off, strict=True)], off, size)
