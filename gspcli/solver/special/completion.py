"""Every pose of a system whose solutions have been counted, or an account of what is missing.

Poses are proved until there are as many as the exact count says. No certificate covers multiple
poses; there the counts decide. If the paths of the endgame lead to as many distinct solutions as
are counted, with as many paths together, these are the solutions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from gspcli.certification.poses.collection import Collection
from gspcli.certification.poses.multiple import MultiplePose, multiple_poses
from gspcli.continuation.endpoints import COUNTED
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.tracked_paths import PathEnds
from gspcli.geometry.quaternions import canonical_sign
from gspcli.solver.results.pose_set import PoseSet
from gspcli.solver.side_poses import SidePoses

#: If at most one path in so many is missing, paths have jumped rather than that the platform is
#: special: other paths find what is missing. Else no count says whether more would be found.
FEW = 50


def is_exhausted(side: SidePoses) -> bool:
    """Return whether all further strategies have been tried."""
    # Imported where they are needed: for most platforms the first strategies are enough.
    from gspcli.solver.strategies.further import FURTHER

    return side.begun == len(FURTHER)


def go_on(side: SidePoses) -> None:
    """Do the next part of the further strategies, up to where the poses may be all."""
    from gspcli.solver.strategies.further import FURTHER

    if side.running is None:
        side.running = FURTHER[side.begun](side)
    if next(side.running, side) is side:
        side.begun, side.running = side.begun + 1, None


def go_on_until(
    side: SidePoses, last: Callable[[SidePoses], Iterator[None]], most: int | None = None
) -> None:
    """Go on as long as poses are missing.

    Parameters
    ----------
    side
        The poses for a choice of sides.
    last
        The last of the further strategies that may be used.
    most
        How many poses there can be, if that is known.
    """
    from gspcli.solver.strategies.further import FURTHER
    from gspcli.solver.strategies.more_digits import with_more_steps

    paths, end = side.paths.count, FURTHER.index(last) + 1
    side.most = most
    while side.begun < end:
        found = len(side.found)
        missing = min(paths - found - len(side.infinite), (most or paths) - found)
        if missing <= 0:
            break
        if side.begun > FURTHER.index(with_more_steps) and missing * FEW > paths:
            break
        go_on(side)


def complete(side: SidePoses, solutions: int, distinct: int, spurious: int | None) -> PoseSet:
    """Return all poses if the counts are reached; else the missing ones count as lost.

    Parameters
    ----------
    side
        The poses for a choice of sides.
    solutions, distinct
        How many solutions it has, with multiplicity and without; poses, if it is known how many
        others there are.
    spurious
        How many solutions are none, besides; None if that is not known.
    """
    multiple: list[MultiplePose] = []
    candidates = _Candidates(side)
    side.most, side.all_simple = solutions, solutions == distinct
    while len(side.found) + len(multiple) < distinct:
        if solutions > distinct:
            multiple = [pose for pose in candidates.poses() if pose.is_pose or spurious is None]
            if len(side.found) + len(multiple) >= distinct:
                break
        if is_exhausted(side):
            break
        go_on(side)
    numbers = _multiplicities(side.found, multiple, solutions, distinct)
    known = list(zip(multiple, numbers, strict=True)) if numbers else []
    return _pose_set(side.found, known, side.paths.count, solutions, spurious or 0)


class _Candidates:
    """The multiple poses at the ends of the endgame, or of paths with 64 digits without a pose.

    Parameters
    ----------
    side
        The poses for a choice of sides.
    """

    def __init__(self, side: SidePoses) -> None:
        self._side = side
        self._tried: PathEnds | None = None
        self._poses: list[MultiplePose] | None = None

    def poses(self) -> list[MultiplePose]:
        """Return the multiple poses that can be found by now."""
        side, left = self._side, self._side.left
        if self._poses is None or left is not self._tried:
            self._tried = left
            if left is None:
                ends = side.paths.solutions(COUNTED)
                chosen = ends.multiplicity > 1
                points, paths = ends.points[chosen], ends.multiplicity[chosen].tolist()
                low = np.zeros((len(points), 0, 8), complex)
            else:
                points, low, paths = left.points, left.low, [1] * len(left.points)
            found = multiple_poses(side.locator, points, low, paths, side.sides)
            self._poses = list(found)
        return self._poses


def _multiplicities(
    found: Collection, multiple: list[MultiplePose], solutions: int, distinct: int
) -> list[int]:
    """Return the multiplicities if the multiple poses are those that the counts leave.

    Each is at least two, so that nothing is left to choose if they are two on average, or if
    there is one pose; else the paths decide. Empty if something does not agree.
    """
    distinct, paths = distinct - len(found), solutions - len(found)
    if len(multiple) != distinct:
        return []
    if paths == 2 * distinct:
        return [2] * distinct
    if distinct == 1:
        return [paths]
    numbers = [pose.multiplicity for pose in multiple]
    return numbers if sum(numbers) == paths else []


def _pose_set(
    found: Collection,
    known: list[tuple[MultiplePose, int]],
    paths: int,
    solutions: int,
    counted: int,
) -> PoseSet:
    """Return the simple poses, and the multiple ones with their multiplicities."""
    multiple = [pose for pose, _ in known if pose.is_pose]
    numbers = [number for pose, number in known if pose.is_pose]
    spurious = sum(number for pose, number in known if not pose.is_pose)
    reached = len(found) + sum(numbers) + spurious
    # More than were counted: the prime of the count is a bad one, or a proof is wrong.
    excess = reached > solutions or solutions + counted > paths
    return PoseSet(
        quaternions=canonical_sign(
            np.concatenate([found.quaternions, *(pose.quaternion[None] for pose in multiple)])
        ),
        R=np.concatenate([found.R, *(pose.R[None] for pose in multiple)]),
        T=np.concatenate([found.T, *(pose.T[None] for pose in multiple)]),
        real=np.array([*found.real.tolist(), *(pose.real for pose in multiple)], np.bool_),
        certified=np.arange(len(found) + len(multiple)) < len(found),
        multiplicity=np.array([1] * len(found) + numbers, np.int64),
        motions=(),
        account=PathAccount(
            expected=paths,
            found=reached - spurious,
            at_infinity=0 if excess else paths - solutions - counted,
            spurious=spurious if excess else spurious + counted,
            lost=paths - reached if excess else solutions - reached,
            basis=Basis.COUNT,
        ),
    )
