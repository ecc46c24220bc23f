"""All poses by eigenvectors, without paths, where counts say that they are simple."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gspcli.certification.counting import ApproximatePose, poses_by_elimination
from gspcli.solver.results.pose_set import are_far
from gspcli.solver.side_poses import SidePoses

#: Bits in which all poses are computed: 512 do not suffice 1e33 lengths away, where machines in
#: floating point have poses. The largest number of paths for which that is done (some seconds).
_BITS = (704, 1408, 2048)
_MOST = 200
#: The first elimination takes as long as this many paths with 64 digits, or as this part of the
#: cube of all paths. Where there are no more paths than that, it takes half as long as with 32
#: digits.
FEW_PATHS, _OF_CUBE = 8, 1 / 8000


def can_eliminate(side: SidePoses) -> bool:
    """Whether elimination finds all poses in some seconds."""
    return side.all_simple and side.paths.count <= _MOST


def is_eliminable(side: SidePoses) -> bool:
    """Whether it is quicker to eliminate than to follow the paths without a pose."""
    if is_small(side):
        return can_eliminate(side)
    cube = _OF_CUBE * side.paths.count**3
    # Where nothing is found at all, paths with more digits hardly find more.
    many = len(side.unresolved) > (max(FEW_PATHS, cube) if len(side.found) else FEW_PATHS)
    return can_eliminate(side) and many


def is_small(side: SidePoses) -> bool:
    """Whether it is quicker to eliminate than to follow paths with 32 digits."""
    return 2 * len(side.unresolved) > side.paths.count <= FEW_PATHS


def early_elimination(side: SidePoses) -> Iterator[None]:
    """Eliminate where that is quicker than to follow many paths with 64 digits."""
    if is_eliminable(side):
        side.eliminated = 1
        yield from _eliminated(side, _BITS[0])


def by_elimination(side: SidePoses) -> Iterator[None]:
    """Eliminate with more and more bits."""
    for bits in _BITS[side.eliminated :] if side.paths.count <= _MOST else ():
        yield from _eliminated(side, bits)


def _eliminated(side: SidePoses, bits: int) -> Iterator[None]:
    """Add the poses that eigenvectors give: first those that doubles tell from all others."""
    problem, found, left = side.problem, side.found, []
    instance = problem.instance.on_sides(problem.choices[side.k].tolist())
    near = int((~are_far(found.R, found.T, problem.arrangement.length)).sum())
    for pose in poses_by_elimination(instance, bits, near=near, seed=problem.seed):
        if _added(side, pose, bits, only_new=True):
            yield
        else:
            left.append(pose)
    found.add_close_conjugates()
    yield
    for pose in left:
        _added(side, pose, bits, only_new=False)
    found.add_close_conjugates()
    yield


def _added(side: SidePoses, pose: ApproximatePose, bits: int, *, only_new: bool) -> bool:
    """Add the pose near an approximation, and its conjugate; False if it seems to be known."""
    locator = side.locator
    if only_new:
        R = np.array([[complex(x) for x in row] for row in pose.R])
        T = np.array([complex(x) for x in pose.T])
        if side.found.is_near(R, T):
            return False
    start = locator.point_of_pose(pose.R, pose.T, bits)
    side.found.add([locator.locate_exactly(start, side.sides, bits // 2)])
    side.found.add_conjugates()
    return True
