"""Every pose of a system whose solutions have been counted, or an account of what is missing.

Poses are proved until there are as many as the exact count says. No certificate covers multiple
poses; there the counts decide. If the paths of the endgame lead to as many distinct solutions as
are counted, with as many paths together, these are the solutions.

Where the lines of some DLL are parallel the poses are those of points for these lines, and of these
poses those with parallel lines. That so many balls contain parallel lines as were counted, and no
others do, proves that just these are parallel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gspcli.certification.counting import PartCount, SideCount, by_points
from gspcli.certification.poses.collection import Collection
from gspcli.certification.poses.multiple import MultiplePose, multiple_poses
from gspcli.certification.poses.parallel_poses import where_parallel
from gspcli.continuation.endpoints import COUNTED
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import canonical_sign
from gspcli.solver.results.pose_set import PoseSet, joined
from gspcli.solver.side_poses import SidePoses


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
    # Imported where it is needed: for most platforms the first strategies are enough.
    from gspcli.solver.strategies.further import search

    multiple: list[MultiplePose] = []
    if solutions > distinct and len(side.found) < distinct:
        multiple = [pose for pose in _multiple(side) if pose.is_pose or spurious is None]
    side.all_simple = solutions == distinct
    search(side, distinct - len(multiple))
    numbers = _multiplicities(side.found, multiple, solutions, distinct)
    known = list(zip(multiple, numbers, strict=True)) if numbers else []
    return _pose_set(side.found, known, side.paths.count, solutions, spurious or 0)


def _multiple(side: SidePoses) -> list[MultiplePose]:
    """Return the multiple poses at the ends of the endgame."""
    ends = side.paths.solutions(COUNTED)
    chosen = ends.multiplicity > 1
    points, paths = ends.points[chosen], ends.multiplicity[chosen].tolist()
    low = np.zeros((len(points), 0, 8), complex)
    return list(multiple_poses(side.locator, points, low, paths, side.sides))


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


def complete_parts(
    side: SidePoses, count: SideCount, solve: Callable[[Instance], PoseSet]
) -> PoseSet:
    """Return all poses for a choice of sides that was counted in parts.

    Parameters
    ----------
    side, count
        The poses without parallel lines, and how many there are of each sort.
    solve
        Returns all poses of a platform: that with points for lines.
    """
    chosen = side.problem.instance.on_sides(count.signs)
    found = []
    for part in count.parts:
        if part.parallel and part.distinct:
            points = solve(by_points(chosen, part.parallel))
            found.append(_with_parallel_lines(chosen, part, points))
        elif part.solutions and part.distinct:
            found.append(complete(side, part.solutions, part.distinct, 0))
    paths = side.paths.count
    reached = min(sum(poses.account.found for poses in found), paths)
    lost = min(sum(poses.account.lost for poses in found), paths - reached)
    account = PathAccount(
        expected=paths,
        found=reached,
        spurious=paths - reached - lost,
        lost=lost,
        basis=Basis.COUNT,
    )
    if not found:
        return replace(PoseSet.unsolved(paths), account=account)
    return replace(joined(found), motions=(), account=account)


def _with_parallel_lines(instance: Instance, part: PartCount, poses: PoseSet) -> PoseSet:
    """Return those poses at which just the lines of a part are parallel."""
    kept = poses.reordered(where_parallel(instance, part.parallel, poses.R, poses.T))
    assert part.distinct is not None
    proved = (
        poses.account.verdict == "complete"
        and len(kept.R) == part.distinct == part.solutions
        and bool(kept.certified.all())
    )
    lost = 0 if proved else max(1, part.distinct - len(kept.R))
    return replace(
        kept,
        certified=kept.certified & proved,
        account=PathAccount(expected=len(kept.R) + lost, found=len(kept.R), lost=lost),
        motions=(),
        proof=None,
    )


def with_points_for_all(
    side: SidePoses, count: SideCount, solve: Callable[[Instance], PoseSet]
) -> PoseSet:
    """Return the poses for a choice of sides where some lines are parallel at all of them.

    They are those of the platform with points for lines. All else is in the set where the
    equations hold because the lines are parallel.
    """
    chosen = side.problem.instance.on_sides(count.signs)
    poses = solve(by_points(chosen, count.parallel))
    return replace(poses, account=_among(side.paths.count, poses.account))


def _among(paths: int, account: PathAccount) -> PathAccount:
    """Return the account of paths that lead to the poses of another platform, or to no poses."""
    # The other one may have more solutions: a point at distance zero from a line counts twice.
    found = min(account.found, paths)
    lost = min(account.lost, paths - found)
    rest = {"on_curves" if account.on_curves else "spurious": paths - found - lost}
    return PathAccount(expected=paths, found=found, lost=lost, basis=Basis.COUNT, **rest)
