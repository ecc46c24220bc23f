"""What is done about poses that the first strategies leave open, in the order of the cost.

Each strategy adds poses to those of one choice of sides, and ends as soon as these are all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from gspcli.certification.counting import ApproximatePose, poses_by_elimination
from gspcli.certification.poses.far_points import conjugate_sources
from gspcli.certification.poses.special_family import (
    FamilyPaths,
    SpecialFamily,
    points_off_lines,
    turned_directions,
)
from gspcli.continuation.quadrics import ComplexArray
from gspcli.solver.poses import are_far
from gspcli.solver.problem import Problem
from gspcli.solver.side_search import FEW, Index, SideSearch

#: A platform that is special up to less than one in this many has poses where N is below 1e-32.
_DECIMALS = 10**9
#: Differences of directions, or of points from a line, from which poses are followed, negative for
#: the other side: poses are found there with 32 digits.
_APART = (1e-2, -1e-3)
#: So many paths are lost before others are tried.
_LOST = 4
#: Bits in which all poses are computed by elimination: 512 do not suffice 1e33 lengths away, where
#: machines in floating point have poses. The most paths for which that is done (some seconds).
_BITS = (704, 1408, 2048)
_MOST = 200
#: The first elimination takes as long as this many paths with more digits, or as this part of the
#: cube of all paths. Where there are no more paths than that, it takes half as long as with 32
#: digits.
FEW_PATHS, _OF_CUBE = 8, 1 / 8000
#: If more than one path in this many is open, most of them lead to poses far away.
_MANY = 8
#: Sets of random paths that are tried, and at most if each of them leads to more poses.
_ATTEMPTS, _MOST_ATTEMPTS = 3, 8


def with_32_digits(side: SideSearch) -> None:
    """Follow with 32 digits the paths whose ends in double precision are not proved.

    That some of these ends are simple beyond doubt, and could be proved in balls, gains nothing:
    on 238 special platforms it added no pose.
    """
    count = side.paths.count
    reached = side.reached if len(side.reached) == count else np.zeros(count, np.bool_)
    side.unresolved = np.flatnonzero(~reached)
    if _is_eliminable(side) and (_is_small(side) or _has_many_decimals(side)):
        # If the platform is special, it is so up to less than 32 digits show. Then paths would take
        # a quarter of the time of a first solution and find no pose.
        return
    if _MANY * len(side.unresolved) > count and points_off_lines(side.problem.instance):
        # Paths from points off their line lead to more poses, in half the time.
        return
    side.unresolved = _followed(side, side.unresolved, 0)


def _has_many_decimals(side: SideSearch) -> bool:
    """Whether coordinates are written with more decimals than paths with 32 digits tell."""
    for primitive in side.problem.instance.primitives:
        for number in (*primitive.position, *getattr(primitive, "vector", ())):
            if (known := number.fraction) is not None and known.denominator > _DECIMALS:
                return True
    return False


def _followed(side: SideSearch, index: Index, attempt: int) -> Index:
    """Add the poses at the ends of some paths, with 32 digits; return which led to none."""
    new = np.zeros(len(index), np.bool_)
    for which, ends in side.paths.track(index, side.target, attempt=attempt):
        converged = ends.has_converged[0]
        new[which[converged]] = side.add_ends(ends.take(converged))
        if side.is_complete:
            return index[~new]
    side.add_close_conjugates()
    # Two paths to one pose: one of them has jumped.
    return index[~new]


def from_special_families(side: SideSearch) -> None:
    """Add the poses to which those of a platform that is less special lead."""
    for family_of in (turned_directions, points_off_lines):
        family = family_of(side.problem.instance) if len(side.unresolved) else None
        if family is None:
            continue
        for apart in _APART:
            _follow_family(side, family, apart)
            if side.is_complete:
                return


def _follow_family(side: SideSearch, family: SpecialFamily, apart: float) -> None:
    """Add the poses to which those with such differences lead."""
    paths = FamilyPaths(family, side.locator, side.sides, apart)
    begin = side.problem.like(paths.instance)
    lost = 0
    for i, (point, low) in enumerate(_ends(begin, side.k)):
        pose = paths.locate(begin.locator, point, low)
        lost += pose is None
        side.add_located([pose])
        side.add_conjugates()
        if side.is_complete or (lost >= _LOST and 2 * lost > i):
            # Where most are lost, the differences are too large.
            return
    side.add_close_conjugates()


def _ends(problem: Problem, k: int) -> Iterator[tuple[ComplexArray, ComplexArray]]:
    """Yield ends of paths with 32 digits: of each pair of conjugates one first, the farthest."""
    paths = problem.tracked[k]
    first = paths.first()
    simple = first.is_simple[0]
    others = paths.track(np.flatnonzero(~simple), problem.target(k))
    parts = [first.take(simple), *(ends.take(ends.has_converged[0]) for _, ends in others)]
    points = np.concatenate([ends.points[0] for ends in parts])
    low = [more for ends in parts for more in ends.more]
    norm = np.abs((points[:, :4] ** 2).sum(axis=1)) / np.abs(points).max(axis=1) ** 2
    is_second = conjugate_sources(points) != np.arange(len(points))
    for i in np.lexsort((norm, is_second)).tolist():
        yield points[i], low[i]


def _can_eliminate(side: SideSearch) -> bool:
    """Whether elimination finds all poses in some seconds."""
    return side.all_simple and side.paths.count <= _MOST


def _is_eliminable(side: SideSearch) -> bool:
    """Whether it is quicker to eliminate than to follow the paths without a pose."""
    if _is_small(side):
        return _can_eliminate(side)
    cube = _OF_CUBE * side.paths.count**3
    # Where nothing is found at all, paths with more digits hardly find more.
    many = len(side.unresolved) > (max(FEW_PATHS, cube) if len(side) else FEW_PATHS)
    return _can_eliminate(side) and many


def _is_small(side: SideSearch) -> bool:
    """Whether it is quicker to eliminate than to follow paths with 32 digits."""
    return 2 * len(side.unresolved) > side.paths.count <= FEW_PATHS


def early_elimination(side: SideSearch) -> None:
    """Eliminate where counts say that poses are simple, and many paths lead to none."""
    if _is_eliminable(side):
        side.eliminated = 1
        _eliminate(side, _BITS[0])


def by_elimination(side: SideSearch) -> None:
    """Eliminate with more and more bits."""
    for bits in _BITS[side.eliminated :] if side.paths.count <= _MOST else ():
        _eliminate(side, bits)
        if side.is_complete:
            return


def _eliminate(side: SideSearch, bits: int) -> None:
    """Add the poses that eigenvectors give: first those that doubles tell from all others."""
    problem, open_ = side.problem, list[ApproximatePose]()
    instance = problem.instance.on_sides(problem.choices[side.k].tolist())
    near = int((~are_far(side.poses.R, side.poses.T, problem.arrangement.length)).sum())
    for pose in poses_by_elimination(instance, bits, near=near, seed=problem.seed):
        R = np.array([[complex(x) for x in row] for row in pose.R])
        T = np.array([complex(x) for x in pose.T])
        if side.is_near(R, T):
            open_.append(pose)
            continue
        _add(side, pose, bits)
        if side.is_complete:
            return
    side.add_close_conjugates()
    for pose in open_ if not side.is_complete else ():
        _add(side, pose, bits)
    side.add_close_conjugates()


def _add(side: SideSearch, pose: ApproximatePose, bits: int) -> None:
    """Add the pose near an approximation, and its conjugate."""
    start = side.locator.point_of_pose(pose.R, pose.T, bits)
    side.add_located([side.locator.locate_exactly(start, side.sides, bits // 2)])
    side.add_conjugates()


def along_other_paths(side: SideSearch) -> None:
    """Follow all paths in other random ways, as long as that leads to more poses."""
    missing, count = side.wanted - len(side), side.paths.count
    if not _can_eliminate(side) and len(side.unresolved) >= missing > count / FEW:
        # The paths to them have not arrived, and none has jumped.
        return
    for attempt in range(1, _MOST_ATTEMPTS):
        before = len(side)
        _followed(side, np.arange(count), attempt)
        if side.is_complete or (attempt + 1 >= _ATTEMPTS and len(side) == before):
            return


FURTHER: tuple[Callable[[SideSearch], None], ...] = (
    with_32_digits,
    # Poses far away because directions are nearly parallel, or points nearly on a line.
    from_special_families,
    # Eigenvectors, where most paths lead to no pose.
    early_elimination,
    # Eigenvectors with more and more bits.
    by_elimination,
    # Some paths have jumped.
    along_other_paths,
)


def search_side(
    side: SideSearch, wanted: int, last: Callable[[SideSearch], None] = along_other_paths
) -> None:
    """Go on with the further strategies until as many poses are proved as wanted.

    Parameters
    ----------
    side
        The poses for a choice of sides.
    wanted
        How many simple poses there can be.
    last
        The last of the strategies that may be used.
    """
    side.wanted = wanted
    for strategy in FURTHER[side.tried : FURTHER.index(last) + 1]:
        if side.is_complete:
            break
        strategy(side)
        if side.is_complete:
            # Another count may say that there are more.
            break
        side.tried += 1
