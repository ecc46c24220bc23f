"""The poses of a platform whose lines are parallel at some of them, found part by part.

Where the lines of some DLL are parallel its poses are those of points for these lines, and of these
poses those with parallel lines. That so many balls contain parallel lines as were counted, and no
others do, proves that just these are parallel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from gspcli.certification.counting import PartCount, SideCount, by_points
from gspcli.certification.poses.parallel_poses import where_parallel
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.instance import Instance
from gspcli.solver.results.pose_set import PoseSet, joined
from gspcli.solver.side_poses import SidePoses
from gspcli.solver.special.completion import complete


def complete_parts(
    side: SidePoses, count: SideCount, solve_points: Callable[[Instance], PoseSet]
) -> PoseSet:
    """Return all poses for a choice of sides that was counted in parts.

    Parameters
    ----------
    side, count
        The poses without parallel lines, and how many there are of each sort.
    solve_points
        Returns all poses of an instance with points for lines.
    """
    chosen = side.problem.instance.on_sides(count.signs)
    found = []
    for part in count.parts:
        if part.parallel and part.distinct:
            points = solve_points(by_points(chosen, part.parallel))
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
        return replace(PoseSet.unsolved(paths, ""), account=account, problem=None)
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
    side: SidePoses, count: SideCount, solve_points: Callable[[Instance], PoseSet]
) -> PoseSet:
    """Return the poses for a choice of sides where some lines are parallel at all of them.

    They are those of the platform with points for lines. All else is in the set where the
    equations hold because the lines are parallel.
    """
    instance = side.problem.instance
    poses = solve_points(by_points(instance.on_sides(count.signs), count.parallel))
    return replace(poses, account=_among(side.paths.count, poses.account))


def _among(paths: int, account: PathAccount) -> PathAccount:
    """Return the account of paths that lead to the poses of another platform, or to no poses."""
    # The other one may have more solutions: a point at distance zero from a line counts twice.
    found = min(account.found, paths)
    lost = min(account.lost, paths - found)
    rest = {"on_curves" if account.on_curves else "spurious": paths - found - lost}
    return PathAccount(expected=paths, found=found, lost=lost, basis=Basis.COUNT, **rest)
