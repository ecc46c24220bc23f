"""Platforms in special or nearly special position: each system of sides by what its count says."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from gspcli.catalogue.kinds import DLL
from gspcli.certification.counting import (
    ExactCount,
    SideCount,
    by_points,
    exact_count,
    geometry_count,
)
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.instance import Instance
from gspcli.solver.completion import complete
from gspcli.solver.infinite import along_points, solve_infinite
from gspcli.solver.ledger import Ledger
from gspcli.solver.pose_set import PoseSet, joined
from gspcli.solver.poses_in_parts import complete_parts
from gspcli.solver.problem import Problem
from gspcli.solver.proof import Ground, Proof
from gspcli.solver.side import Side
from gspcli.solver.solved_starts import STARTS
from gspcli.solver.strategies import steps
from gspcli.solver.uncounted import FEW, until

#: A count takes longer than to follow this part of the paths with 32 digits, for each path that
#: there is; and the part of which more are not followed: then the platform is a special one.
_LONG, _MOST = 1 / 2500, 1 / 5
#: Counts that mislead with a larger probability are worth another one.
_DOUBTFUL = 1e-9
#: Places of long strategies.
_IN_BALLS, _WITH_32_DIGITS, _ALL = 0, 1, 5


def finish(problem: Problem, ledger: Ledger, solve: Callable[[Problem], PoseSet]) -> PoseSet:
    """Return all poses of a platform of which short strategies have not proved as many as expected.

    Parameters
    ----------
    problem, ledger
        The platform, and what is proved; its careful paths have been followed.
    solve
        Returns all poses of another platform.
    """
    instance, arrangement, sides = problem.instance, problem.arrangement, ledger.sides
    if problem.proofs is None:
        for side in sides:
            side.reached = np.zeros(side.pursuit.paths, np.bool_)
    for side in sides:
        side.steps = steps(side)
    count = None
    if problem.limit != 0:
        counted = problem.geometry_count
        for last in (-1, _IN_BALLS) if counted and counted.solutions else ():
            _go_on(sides, last, counted.solutions // len(sides))
            if (poses := ledger.complete) is not None:
                STARTS.keep(arrangement, poses)
                return poses
        # Paths that went wrong are followed with 32 digits as long as a count would take longer.
        if not any(_too_many_astray(side) for side in sides):
            _go_on(sides, _WITH_32_DIGITS)
            if (poses := ledger.complete) is not None:
                return poses
        astray = any(_astray(side) * FEW > side.pursuit.paths for side in sides)
        count = exact_count(instance, seed=problem.seed, limit=problem.limit, suspect=astray)
    if count is None:
        return _uncounted(problem, ledger)
    infinite = any(side.solutions is None and not side.parallel for side in count.sides)
    if infinite and (moving := _moving_with_parallel_lines(instance, count)) is not None:
        samples = solve(problem.like(moving)).motions
        return along_points(instance, arrangement, samples, _infinite(instance, count))
    parts = [
        _by_count(side, counted, solve).on_sides(problem.choices[k : k + 1])
        for k, (side, counted) in enumerate(zip(sides, count.sides, strict=True))
        if not infinite
    ]
    # A set without a sample of it may have real poses that are alone, such as lines that coincide.
    if infinite or any(part.account.on_curves and not part.motions for part in parts):
        proof = _infinite(instance, count)
        return solve_infinite(instance, arrangement, problem.pursuits, proof)
    poses = _proved(joined(parts), count)
    exact = poses.proof
    if poses.account.verdict == "incomplete" or (exact is not None and exact.error < _DOUBTFUL):
        return poses
    # Angles with many decimals leave few primes to count exactly with, but not for the geometry.
    geometry = geometry_count(instance, seed=problem.seed, limit=problem.limit)
    grounds = [proof for proof in (exact, _by_geometry(poses, geometry)) if proof is not None]
    return replace(poses, proof=min(grounds, key=_error) if grounds else None)


def _by_count(side: Side, counted: SideCount, solve: Callable[[Problem], PoseSet]) -> PoseSet:
    """Return the poses for a choice of sides by its count."""

    def solve_points(same: Instance) -> PoseSet:
        return solve(side.problem.like(same))

    instance = side.problem.instance
    if counted.parallel:
        return _with_parallel_lines(instance, counted, side, solve_points)
    if counted.parts:
        return complete_parts(instance, counted, side, solve_points)
    return _counted(side, counted)


def _go_on(sides: Sequence[Side], last: int, most: int | None = None) -> None:
    """Run long strategies up to one by its place, as long as poses are missing."""
    for side in sides:
        until(side, last, most)


def _astray(side: Side) -> int:
    ends = side.pursuit.first()
    return int((~(ends.simple & ends.settled)).sum())


def _too_many_astray(side: Side) -> bool:
    paths = side.pursuit.paths
    return not paths or _astray(side) > min(max(1 / FEW, _LONG * paths), _MOST) * paths


def _infinite(instance: Instance, count: ExactCount) -> Proof | None:
    """Return what proves that there are infinitely many poses, as they are stated."""
    if all(row.kind is not DLL for row in instance.constraints):
        return Proof.modulo(Ground.EXACT, count.error)
    # The equations alone may be infinitely many because lines are parallel.
    errors = [side.infinite_part.error for side in count.sides if side.infinite_part]
    return Proof.modulo(Ground.EXACT, min(errors)) if errors else None


def _moving_with_parallel_lines(instance: Instance, count: ExactCount) -> Instance | None:
    """Return the platform with points for lines that are parallel at infinitely many poses."""
    for side in count.sides:
        part = side.infinite_part
        if part is not None and part.parallel:
            return by_points(instance.on_sides(side.signs), part.parallel)
    return None


def _counted(search: Side, side: SideCount) -> PoseSet:
    """Return the poses for a choice of sides for which they were counted."""
    assert side.solutions is not None
    # Where distinct solutions were not counted, only simple ones can be all.
    solutions, distinct = side.solutions, side.distinct
    if distinct is None:
        distinct = solutions
    elif side.spurious is not None and side.spurious_distinct is not None:
        solutions, distinct = solutions - side.spurious, distinct - side.spurious_distinct
    known = None if side.distinct is None else side.spurious
    return complete(search, solutions, distinct, known)


def _with_parallel_lines(
    instance: Instance,
    side: SideCount,
    search: Side,
    solve_points: Callable[[Instance], PoseSet],
) -> PoseSet:
    """Return the poses for a choice of sides where some lines are parallel at all of them.

    They are those of the platform with points for lines. All else is in the set where the
    equations hold because the lines are parallel.
    """
    poses = solve_points(by_points(instance.on_sides(side.signs), side.parallel))
    return replace(poses, account=_among(search.pursuit.paths, poses.account))


def _among(paths: int, account: PathAccount) -> PathAccount:
    """Return the account of paths that lead to the poses of another platform, or to no poses."""
    # The other one may have more solutions: a point at distance zero from a line counts twice.
    found = min(account.found, paths)
    lost = min(account.lost, paths - found)
    rest = {"on_curves" if account.on_curves else "spurious": paths - found - lost}
    return PathAccount(expected=paths, found=found, lost=lost, basis=Basis.COUNT, **rest)


def _uncounted(problem: Problem, ledger: Ledger) -> PoseSet:
    """Return the poses of a platform that could not be counted exactly, by its geometry's count."""
    instance, limit, sides = problem.instance, problem.limit, ledger.sides
    count = geometry_count(instance, seed=problem.seed, limit=limit) if limit != 0 else None
    # Two pairs of lines that are parallel at once spoil the argument (docs/counts.md), and a
    # geometry that has no pose for most values has infinitely many for others.
    useful = count is not None and count.solutions and count.has_lone_lines
    # All choices of sides are alike.
    most = count.solutions // len(sides) if useful else None
    _go_on(sides, _ALL, most)
    poses = joined([side.poses(most) for side in sides])
    proof = _by_geometry(poses, count) if useful else None
    return _proved(poses, None) if proof is None else replace(poses, proof=proof)


def _by_geometry(poses: PoseSet, count: ExactCount | None) -> Proof | None:
    """Return the proof that poses are all, if they are as many as the geometry has."""
    if count is None or not count.solutions or not count.has_lone_lines:
        return None
    is_all = poses.certified.sum() == count.solutions < poses.account.expected
    return Proof.modulo(Ground.GEOMETRY, count.error) if is_all else None


def _error(proof: Proof) -> float:
    return proof.error


def _proved(poses: PoseSet, count: ExactCount | None) -> PoseSet:
    """Return poses with what proves that they are all, or infinitely many."""
    proof = poses.proof_by_type
    if proof is None and count is not None and poses.account.verdict != "incomplete":
        # Multiple poses need the count of the distinct ones, too.
        multiple = (poses.multiplicity > 1).any()
        proof = Proof.modulo(Ground.EXACT, count.distinct_error if multiple else count.error)
    return replace(poses, proof=proof, exact_count=count.solutions if count else None)
