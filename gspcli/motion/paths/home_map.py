"""A small map of poses from which proved straight ways lead home, for pages that have no planner.

Each pose has the next one on its way. Ways are those of the maps of `mode_groups`: straight in
values within the ranges if each value has one, else in poses. So the page that proves them again
finds a way home from other assembly modes, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.defaults import SEED
from gspcli.motion.paths.ends import Modes, PathEnd
from gspcli.motion.paths.guides import PROVED_ROWS, ValueGuide
from gspcli.motion.paths.maps import PoseMap, ValueMap
from gspcli.motion.paths.planner import Planner
from gspcli.solver.result import SolveResult

Array = NDArray[np.float64]

#: A map grows so often at most: by sets of values with all their poses, or by poses.
_VALUE_STEPS, _POSE_STEPS = 48, 240
#: It grows so often in any case, so that there are poses elsewhere than at the values of the file.
_VALUE_LEAST, _POSE_LEAST = 3, 40
#: This many poses are kept besides those on ways from other modes, and at most in all.
_SPREAD, _MOST = 16, 80
#: Straight ways of poses are kept in this many parts, which are nearly as straight for any angles.
_PARTS = 3


class HomeMap(NamedTuple):
    """Poses from which ways lead home."""

    R: Array
    """Shape (n, 3, 3); home is the first."""
    T: Array
    """Shape (n, 3)."""
    after: NDArray[np.int64]
    """The next pose on the way home, shape (n,); that of home is 0."""


def home_map(result: SolveResult, home: int) -> HomeMap | None:
    """Return a map of poses from which proved straight ways lead to a mode.

    Parameters
    ----------
    result
        The platform, solved.
    home
        The index of the mode that is home.

    Returns
    -------
    HomeMap or None
        None if home is the only pose of it, or violates a limit; and if home fills its box of
        ranges, so that all straight ways of values in it lead home.

    Raises
    ------
    GspError
        If nothing can be planned for this platform.
    """
    planner = Planner(result.instance, seed=SEED)
    ends = Modes(result.instance, result).all()
    if planner.left(ends[home]) or planner.fills_ranges(ends[home]):
        return None
    goal = planner.classes.of(ends[home].R, ends[home].T)
    ranged = not planner.machine.moves and planner.values(ends[home]).ranged
    members = [ends[home]]
    for k, end in enumerate(ends):
        if k == home or planner.left(end) or (ranged and not _on_one_side(end, ends[home])):
            continue
        if planner.classes.of(end.R, end.T).differs(goal) is None:
            members.append(end)
    found = planner.value_map(members) if ranged else planner.pose_map(members)
    found.join_given()
    if not (planner.machine.shared or planner.stays):
        _grow(found, len(members))
    return _kept(found, planner, len(members))


def _on_one_side(first: PathEnd, second: PathEnd) -> bool:
    return bool((np.sign(first.values) == np.sign(second.values)).all())


def _grow(found: PoseMap | ValueMap, members: int) -> None:
    """Let a map grow until all modes are joined with home, or for some steps."""
    by_values = isinstance(found, ValueMap)
    least = _VALUE_LEAST if by_values else _POSE_LEAST
    for step in range(_VALUE_STEPS if by_values else _POSE_STEPS):
        if step >= least and all(found.connections.joined(0, k) for k in range(members)):
            return
        found.grow()


def _kept(found: PoseMap | ValueMap, planner: Planner, members: int) -> HomeMap | None:
    """Return what is kept of a map: ways of the modes, and of poses far from each other."""
    after: dict[int, int] = {0: 0}
    order = list(_spread(found, members))
    for node in order:
        if len(after) >= _MOST:
            break
        for _ in range(len(found.connections)):
            way = found.connections.way(node, 0)
            bad = None if way is None else _unproved(found, way, after)
            if way is None or bad is None:
                break
            _refuse(found, *bad)
        if way is not None:
            for a, b in pairwise(way):
                after.setdefault(a, b)
    if len(after) == 1:
        return None
    return _numbered(found, after)


def _spread(found: PoseMap | ValueMap, members: int) -> Iterator[int]:
    """Yield the modes that are joined with home, then poses far from those before."""
    joined = [k for k in range(1, len(found.connections)) if found.connections.joined(0, k)]
    modes = [k for k in joined if k < members]
    yield from modes
    others = [k for k in joined if k >= members]
    if not others:
        return
    places = _places(found)
    away = np.min([np.linalg.norm(places[others] - places[k], axis=1) for k in [0, *modes]], axis=0)
    for _ in range(min(_SPREAD, len(others))):
        k = int(away.argmax())
        yield others[k]
        away = np.minimum(away, np.linalg.norm(places[others] - places[others[k]], axis=1))


def _places(found: PoseMap | ValueMap) -> Array:
    """Return all poses as points: rotations, and positions in their largest distance."""
    R, T = _poses(found, list(range(len(found.connections))))
    size = float(np.ptp(T, axis=0).max()) or 1.0
    return np.concatenate((R.reshape(-1, 9), T / size), axis=1)


def _poses(found: PoseMap | ValueMap, nodes: list[int]) -> tuple[Array, Array]:
    if isinstance(found, ValueMap):
        return found.ways.poses(np.array([found.points[k] for k in nodes]))
    return found.ways.poses(np.array([found.nodes[k] for k in nodes]))


def _unproved(
    found: PoseMap | ValueMap, way: list[int], after: dict[int, int]
) -> tuple[int, int] | None:
    """Return the first part of a way that does not keep its cones; None if all do."""
    if isinstance(found, PoseMap) or not found.ways.cones:
        return None
    for a, b in pairwise(way):
        if a in after:
            return None
        guide = ValueGuide(found.ways, found.points[a], found.points[b])
        corners = np.stack((found.values[a], found.values[b]))
        if guide.trace(corners, np.array([PROVED_ROWS])) is None:
            return a, b
    return None


def _refuse(found: PoseMap | ValueMap, a: int, b: int) -> None:
    assert isinstance(found, ValueMap)
    found.refuse(a, b)


def _numbered(found: PoseMap | ValueMap, after: dict[int, int]) -> HomeMap:
    """Return the poses that are kept, with poses between them on ways of poses."""
    nodes = sorted(after)
    place = {node: k for k, node in enumerate(nodes)}
    R, T = _poses(found, nodes)
    to = [place[after[node]] for node in nodes]
    if isinstance(found, ValueMap):
        return HomeMap(R, T, np.array(to))
    more: list[Array] = []
    for node in nodes[1:]:
        begin = found.nodes[node]
        way = found.ways.nearest(begin, found.nodes[after[node]]) - begin
        last = to[place[node]]
        for part in range(_PARTS - 1, 0, -1):
            more.append(begin + way * (part / _PARTS))
            to.append(last)
            last = len(nodes) + len(more) - 1
        to[place[node]] = last
    R_more, T_more = found.ways.poses(np.array(more))
    return HomeMap(np.concatenate((R, R_more)), np.concatenate((T, T_more)), np.array(to))
