"""Poses far away because a body is nearly special, from a platform that is less so.

They are continued in the angle between nearly parallel directions, in the distance of points from a
line, or in the size of a body.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gspcli.certification.poses.conjugate_points import conjugate_sources
from gspcli.certification.poses.points_off_lines import points_off_lines
from gspcli.certification.poses.small_bodies import small_bodies
from gspcli.certification.poses.special_family import FamilyPaths, SpecialFamily
from gspcli.certification.poses.turned_directions import turned_directions
from gspcli.continuation.quadrics import ComplexArray
from gspcli.solver.problem import Problem
from gspcli.solver.side_poses import SidePoses
from gspcli.solver.strategies.elimination import is_eliminable

#: The differences from which poses are followed, each tried in turn, negative for the other side:
#: poses are found there with 32 digits.
_APART = (1e-3, -3e-3)
#: The same for the size of a body: below, some poses are not found with 32 digits.
_LARGER = (0.02, -0.03)
#: Paths with 64 digits are quicker than from directions that differ by more, unless three are
#: nearly parallel, or this many paths have led to no pose for each that is missing.
_LEAST, _MANY = 1e-13, 4


def from_turned_directions(side: SidePoses) -> Iterator[None]:
    """Add the poses to which those of a platform with directions turned apart lead."""
    turned = turned_directions(side.problem.instance) if len(side.unresolved) else None
    if turned is not None and _is_quick(side, turned):
        yield from _from_family(side, turned, _APART)


def from_points_off_lines(side: SidePoses) -> Iterator[None]:
    """Add the poses to which those of a platform with points farther from a line lead."""
    moved = points_off_lines(side.problem.instance) if len(side.unresolved) else None
    if moved is not None:
        yield from _from_family(side, moved, _APART)


def from_larger_bodies(side: SidePoses) -> Iterator[None]:
    """Add the poses to which those of a platform with a larger body lead, if it is a small one."""
    larger = small_bodies(side.problem.instance) if len(side.unresolved) else None
    if larger is not None and not is_eliminable(side):
        yield from _from_family(side, larger, _LARGER)


def _is_quick(side: SidePoses, turned: SpecialFamily) -> bool:
    """Whether its paths are quicker than paths with 64 digits."""
    missing = (side.most or side.paths.count) - len(side.found)
    are_three = sum(map(bool, turned.differences)) > 1
    return turned.size < _LEAST or are_three or len(side.unresolved) > _MANY * missing


def _from_family(side: SidePoses, family: SpecialFamily, begins: Sequence[float]) -> Iterator[None]:
    for apart in begins:
        paths = FamilyPaths(family, side.locator, side.sides, apart)
        problem = side.problem.like(paths.instance)
        for point, low in _ends(problem, side.k):
            side.found.add([paths.locate(problem.locator, point, low)])
            side.found.add_conjugates()
            yield
        side.found.add_close_conjugates()
        yield


def _ends(problem: Problem, k: int) -> Iterator[tuple[ComplexArray, ComplexArray]]:
    """Yield ends of paths with 32 digits: of each pair of conjugates one first, the farthest."""
    paths = problem.tracked[k]
    first = paths.first()
    others = paths.track(np.flatnonzero(~first.simple), problem.target(k), digits=32)
    parts = [first.take(first.simple), *(ends.take(ends.converged) for _, ends in others)]
    points = np.concatenate([ends.points for ends in parts])
    low = [more for ends in parts for more in ends.low]
    norm = np.abs((points[:, :4] ** 2).sum(axis=1)) / np.abs(points).max(axis=1) ** 2
    is_second = conjugate_sources(points) != np.arange(len(points))
    for i in np.lexsort((norm, is_second)).tolist():
        yield points[i], low[i]
