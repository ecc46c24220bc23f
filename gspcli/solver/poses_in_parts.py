"""The poses of a platform whose lines are parallel at some of them, found part by part.

Where the lines of some DLL are parallel its poses are those of points for these lines, and of these
poses those with parallel lines. That so many balls contain parallel lines as were counted, and no
others do, proves that just these are parallel.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from flint import acb, ctx
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.balls import cross, rotated
from gspcli.certification.counting import PartCount, SideCount, by_points
from gspcli.certification.frames import Frames
from gspcli.certification.locating import Located, Locator
from gspcli.certification.statement import Statement
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.solver.completion import complete
from gspcli.solver.pose_set import PoseSet, joined
from gspcli.solver.search import Search

#: Bits in which lines are told from parallel ones.
_BITS = 512


def complete_parts(
    instance: Instance,
    side: SideCount,
    search: Search,
    solve_points: Callable[[Instance], PoseSet],
) -> PoseSet:
    """Return all poses for a choice of sides that was counted in parts.

    Parameters
    ----------
    instance
        The platform.
    side
        The count.
    search
        For the poses without parallel lines.
    solve_points
        Returns all poses of an instance with points for lines.
    """
    chosen = instance.on_sides(side.signs)
    found = []
    for part in side.parts:
        if part.parallel and part.distinct:
            found.append(_with_parallel_lines(chosen, part, solve_points(_points(chosen, part))))
        elif part.solutions and part.distinct:
            found.append(complete(search, part.solutions, part.distinct, 0))
    paths = search.pursuit.paths
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


def _points(instance: Instance, part: PartCount) -> Instance:
    return by_points(instance, part.parallel)


def _with_parallel_lines(instance: Instance, part: PartCount, poses: PoseSet) -> PoseSet:
    """Return those poses at which just the lines of a part are parallel."""
    same = _points(instance, part)
    locator = Locator(same, Frames.of(Arrangement.of(same)))
    original = Locator(instance, locator.frames)
    located = [_located(locator, R, T) for R, T in zip(poses.R, poses.T, strict=True)]
    with ctx.workprec(_BITS):
        lines = original.system(_BITS).statements
        chosen = np.array(
            [pose is not None and _are_parallel(lines, part, pose) for pose in located], np.bool_
        )
    kept = poses.reordered(chosen)
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


def _located(
    locator: Locator, R: NDArray[np.complex128], T: NDArray[np.complex128]
) -> Located | None:
    rotation = [[acb(x) for x in row] for row in R.tolist()]
    start = locator.point_of_pose(rotation, [acb(x) for x in T.tolist()], _BITS)
    sides = (0,) * len(locator.instance.constraints)
    found = locator.locate_exactly(start, sides, _BITS)
    return found if isinstance(found, Located) else None


def _are_parallel(lines: Sequence[Statement], part: PartCount, pose: Located) -> bool:
    """Whether balls do not tell the lines of a part from parallel ones, and tell all others."""
    for index, line in enumerate(lines):
        if line.kind is DLL:
            u = rotated(pose.pose.rotation, [acb(x) for x in line.u])
            across = cross(u, [acb(x) for x in line.v])
            if all(x.contains(0) for x in across) != (index in part.parallel):
                return False
    return True
