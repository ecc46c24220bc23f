"""Platforms at which the equation of a point and a line is a product of two real quadrics.

DPL is ``G H = d^2 N^2`` with complex conjugate G and H. So the argument that doubles real solutions
by the two sides of a plane (docs/real-constructions.md) does not hold for it. But in some cases it
is a product of two *real* quadrics on the solutions of the other constraints:

turned
    The point y is far from the platform's other points. Then R y moves on a large sphere about
    places near the line, which meets the cylinder in two circles: the angle of R y and the line is
    one of two nearly right angles. So in the limit DPL is two angles.
carried by DPP
    Another constraint keeps the same point at a distance r from a point of the line. A sphere and
    a cylinder about a line through its centre meet in two circles, in the planes at the distances
    +-c from the centre, ``c^2 = r^2 - d^2``: exactly two one-sided DPH.
carried by DPH
    Another constraint keeps the same point on a plane through the line, where the cylinder is two
    parallel lines: exactly two one-sided DPH again.

carried by an angle and DHP
    The plane of the platform goes through the point and through a point of the line, and its normal
    has a right angle with the line. The condition is then the moment of normal and line: two DLL.

The same holds for DLP with platform and base exchanged. The remaining constraints are a `Pattern`,
best with one quadric for each constraint, or with three angles, since three cylinders meet in eight
real points. If its angles are right angles and its carried planes are at distance zero, each real
solution of a pattern becomes two for each constraint that was split, if the two are near enough.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import ALL, DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.quaternions import normalized
from gspcli.reality.patterns import Pattern
from gspcli.reality.platforms import Platforms
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Three angles fix the rotations; with more a type has infinitely many poses.
_MOST_ANGLES = 3


def _joined(groups: Iterable[tuple[int, ...]]) -> tuple[tuple[int, ...], ...]:
    """Return groups after groups with a common member are joined."""
    joined: list[set[int]] = []
    for group in groups:
        touching = [known for known in joined if not known.isdisjoint(group)]
        joined = [known for known in joined if known not in touching]
        joined.append(set(group).union(*touching))
    return tuple(sorted(tuple(sorted(group)) for group in joined))


@dataclass(frozen=True)
class Splitting:
    """The way in which the DPL and DLP of a type are split.

    Attributes
    ----------
    kinds
        The kinds of the type.
    turned
        The constraints that become two angles.
    carried
        The constraints that become two planes, or meeting lines, each with the constraints that
        carry it: one distance of its point, or an angle and a distance.
    """

    kinds: tuple[Kind, ...]
    turned: tuple[int, ...] = ()
    carried: tuple[tuple[int, tuple[int, ...]], ...] = ()

    @property
    def factor(self) -> int:
        """The number of solutions for each solution of the pattern."""
        return int(2 ** (len(self.turned) + len(self.carried)))

    @property
    def left(self) -> int:
        """The number of DPL and DLP that are not split; 0 with three angles: none is needed."""
        kinds = self.pattern.kinds
        if sum(not kind.is_distance for kind in kinds) == _MOST_ANGLES:
            return 0
        return sum(kind in (DPL, DLP) for kind in kinds)

    @property
    def pattern(self) -> Pattern:
        """The pattern of the remaining constraints."""
        kinds = list(self.kinds)
        for i in self.turned:
            kinds[i] = ALL
        u, v = [], []
        for i, carriers in self.carried:
            kinds[i] = _remaining(self.kinds[i], self.kinds[carriers[-1]])
            if len(carriers) == 2:
                angle, other = carriers
                u.append((i, angle, other) if self.kinds[other] is not DPH else (i, angle))
                v.append((i, angle, other) if self.kinds[other] is not DHP else (i, angle))
        points = ((i, carriers[-1]) for i, carriers in self.carried)
        right = bool(self.turned or u)
        return Pattern(tuple(kinds), _joined(points), _joined(u), _joined(v), right)

    def lifted(
        self, known: Platforms, R: Array, T: Array, *, gap: float, reach: float, cosine: float
    ) -> Platforms:
        """Return a reduced platform of the type near one of the pattern.

        Parameters
        ----------
        known
            One platform of the pattern, without leading axes.
        R, T
            Its real solutions, shapes (n, 3, 3) and (n, 3).
        gap
            Half the difference of the two positions into which a constraint is split.
        reach, cosine
            The distance of the points that turn, and half the difference of their two cosines.
        """
        y, x, u, v = known.y.copy(), known.x.copy(), known.u.copy(), known.v.copy()
        values = known.values.copy()
        there, back = T.mean(axis=0), -np.einsum("nji,nj->ni", R, T).mean(axis=0)
        for i in self.turned:
            if self.kinds[i] is DPL:
                y[i], x[i] = reach * known.u[i], there
            else:
                x[i], y[i] = reach * known.v[i], back
            values[i] = reach * np.sqrt(1 - cosine**2)
        for i, carriers in self.carried:
            kind = self.kinds[carriers[-1]]
            if kind is DPP:
                values[i] = np.sqrt(known.values[carriers[-1]] ** 2 - gap**2)
                continue
            values[i] = gap
            if len(carriers) == 1:
                side = v if self.kinds[i] is DPL else u
                side[i] = normalized(np.cross(side[i], side[carriers[-1]]))
        return Platforms(self.kinds, y, x, u, v, values)


def _remaining(kind: Kind, carrier: Kind) -> Kind:
    """Return the kind of the two constraints that replace a carried one."""
    if (kind, carrier) in ((DPL, DHP), (DLP, DPH)):
        return DLL
    return DPH if kind is DPL else DHP


def splittings(kinds: tuple[Kind, ...]) -> Iterator[Splitting]:
    """Yield the ways to split DPL and DLP of a type, all or some of them."""
    lines = [i for i, kind in enumerate(kinds) if kind in (DPL, DLP)]
    angles = sum(not kind.is_distance for kind in kinds)
    for count in range(min(len(lines), _MOST_ANGLES - angles) + 1):
        for turned in combinations(lines, count):
            rest = [i for i in lines if i not in turned]
            for size in range(len(rest) + 1):
                for some in combinations(rest, size):
                    for carried in _carried(kinds, turned, list(some)):
                        yield Splitting(kinds, turned, carried)


def _carried(
    kinds: tuple[Kind, ...], turned: tuple[int, ...], lines: list[int]
) -> Iterator[tuple[tuple[int, tuple[int, ...]], ...]]:
    """Yield the ways to choose a carrier for each line; lines of one kind have different ones."""
    if not lines:
        yield ()
        return
    first = lines[0]
    angles = [i for i, kind in enumerate(kinds) if not kind.is_distance or i in turned]
    alone = (DPP, DPH) if kinds[first] is DPL else (DPP, DHP)
    with_angle = DHP if kinds[first] is DPL else DPH
    carriers: list[tuple[int, ...]] = [(i,) for i, kind in enumerate(kinds) if kind in alone]
    carriers += [(a, i) for a in angles for i, kind in enumerate(kinds) if kind is with_angle]
    for other in _carried(kinds, turned, lines[1:]):
        for carrier in carriers:
            taken = [i for i, by in other if by[-1] == carrier[-1]]
            if all(kinds[i] is not kinds[first] for i in taken):
                yield ((first, carrier), *other)
