"""Platforms in special or nearly special position: each system of sides by what its count says."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from gspcli.catalogue.kinds import DLL
from gspcli.certification.counting import (
    ExactCount,
    SideCount,
    by_points,
    exact_count,
    geometry_count,
)
from gspcli.certification.equations.frames import Frames
from gspcli.certification.poses.locator import Locator
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.pursuit import Pursuit
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.solver.completion import complete
from gspcli.solver.infinite import along_points, solve_infinite
from gspcli.solver.pose_set import PoseSet, joined
from gspcli.solver.poses_in_parts import complete_parts
from gspcli.solver.proof import Ground, Proof
from gspcli.solver.search import Effort, Search
from gspcli.solver.special_geometry import (
    has_kept_count,
    keep_solved,
    kept_count,
    poses_of_geometry,
)
from gspcli.solver.study_systems import side_choices
from gspcli.solver.tracking import pursue_each
from gspcli.solver.uncounted import FEW, without_count

#: A count takes longer than to follow this part of the paths with 32 digits, for each path that
#: there is; and the part of which more are not followed: then the platform is a special one.
_LONG, _MOST = 1 / 2500, 1 / 5
#: Counts that mislead with a larger probability are worth another one.
_DOUBTFUL = 1e-9


def solve_special(
    instance: Instance,
    arrangement: Arrangement,
    pursuits: Sequence[Pursuit],
    proofs: ValueProofs | None = None,
    *,
    seed: int,
    limit: float | None,
) -> PoseSet:
    """Return all poses of a platform whose paths do not all end at distinct simple poses.

    Parameters
    ----------
    instance, arrangement
        The platform, exactly and in floating point.
    pursuits
        The paths to its poses, for each choice of sides.
    proofs
        The platform as equations that doubles can prove, if there are such.
    seed
        Source of the random prime of the count.
    limit
        Work that the exact count may take (`certification.counting`), None for no limit;
        if it is zero, nothing is counted.
    """
    locator = Locator(instance, Frames.of(arrangement))
    searches = [
        Search(arrangement, locator, pursuit, sides)
        for pursuit, sides in zip(pursuits, _equations(arrangement), strict=True)
    ]
    count = None
    if limit != 0:
        geometry = kept_count(instance, seed, limit) if has_kept_count(arrangement) else None
        if geometry is not None:
            poses = poses_of_geometry(arrangement, proofs, searches, geometry)
            if poses is not None:
                keep_solved(instance, arrangement, poses)
                return poses
        poses = _as_many_as_the_type(arrangement, searches)
        if poses is not None:
            return poses
        astray = any(_many_astray(pursuit) for pursuit in pursuits)
        count = exact_count(instance, seed=seed, limit=limit, suspect=astray)
    if count is None:
        return _uncounted(instance, arrangement, searches, seed, limit)

    def solve_points(same: Instance) -> PoseSet:
        arrangement = Arrangement.of(same)
        _, pursuits = next(pursue_each([arrangement], seed=seed, jobs=1))
        return solve_special(same, arrangement, pursuits, seed=seed, limit=limit)

    infinite = any(side.solutions is None and not side.parallel for side in count.sides)
    if infinite and (moving := _moving_with_parallel_lines(instance, count)) is not None:
        samples = solve_points(moving).motions
        return along_points(instance, arrangement, samples, _infinite(instance, count))
    choices = side_choices(arrangement)
    parts = [
        (
            _with_parallel_lines(instance, side, search, solve_points)
            if side.parallel
            else complete_parts(instance, side, search, solve_points)
            if side.parts
            else _counted(search, side)
        ).on_sides(choices[k : k + 1])
        for k, (search, side) in enumerate(zip(searches, count.sides, strict=True))
        if not infinite
    ]
    # A set without a sample of it may have real poses that are alone, such as lines that coincide.
    if infinite or any(part.account.on_curves and not part.motions for part in parts):
        return solve_infinite(instance, arrangement, pursuits, _infinite(instance, count))
    poses = _proved(joined(parts), count)
    exact = poses.proof
    if poses.account.verdict == "incomplete" or (exact is not None and exact.error < _DOUBTFUL):
        return poses
    # Angles with many decimals leave few primes to count exactly with, but not for the geometry.
    geometry = geometry_count(instance, seed=seed, limit=limit)
    grounds = [proof for proof in (exact, _by_geometry(poses, geometry)) if proof is not None]
    return replace(poses, proof=min(grounds, key=_error) if grounds else None)


def _many_astray(pursuit: Pursuit) -> bool:
    """Return whether so many paths do not end at simple poses that these may be infinitely many."""
    return _astray(pursuit) * FEW > pursuit.paths


def _astray(pursuit: Pursuit) -> int:
    ends = pursuit.first()
    return int((~(ends.simple & ends.settled)).sum())


def _as_many_as_the_type(arrangement: Arrangement, searches: Sequence[Search]) -> PoseSet | None:
    """Return as many proved poses as the type has; None if fewer are found, or a count is quicker.

    Paths that went wrong are followed with 32 digits as long as a count would take longer.
    """
    pursuits = [search.pursuit for search in searches]
    for each in pursuits:
        part = min(max(1 / FEW, _LONG * each.paths), _MOST)
        if not each.paths or _astray(each) > part * each.paths:
            return None
    poses = _joined_without_count(arrangement, searches, None, Effort.SOME)
    return replace(poses, proof=poses.proof_by_type) if poses.proof_by_type else None


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


def _counted(search: Search, side: SideCount) -> PoseSet:
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
    search: Search,
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


def _uncounted(
    instance: Instance,
    arrangement: Arrangement,
    searches: Sequence[Search],
    seed: int,
    limit: float | None,
) -> PoseSet:
    """Return the poses of a platform that could not be counted exactly, by its geometry's count."""
    count = geometry_count(instance, seed=seed, limit=limit) if limit != 0 else None
    if count is None or not count.solutions or not count.has_lone_lines:
        # Two pairs of lines that are parallel at once spoil the argument (docs/counts.md), and a
        # geometry that has no pose for most values has infinitely many for others.
        return _proved(_joined_without_count(arrangement, searches, None), None)
    # All choices of sides are alike.
    most = count.solutions // len(searches)
    poses = _joined_without_count(arrangement, searches, most)
    proof = _by_geometry(poses, count)
    return _proved(poses, None) if proof is None else replace(poses, proof=proof)


def _joined_without_count(
    arrangement: Arrangement,
    searches: Sequence[Search],
    most: int | None,
    effort: Effort = Effort.MUCH,
) -> PoseSet:
    choices = side_choices(arrangement)[:, None]
    return joined(
        [
            without_count(search, most, effort).on_sides(choice)
            for search, choice in zip(searches, choices, strict=True)
        ]
    )


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


def _equations(arrangement: Arrangement) -> list[tuple[int, ...]]:
    """Return for each choice of sides which equation of each constraint it means."""
    both = [
        kind.has_sides and side == 0
        for kind, side in zip(arrangement.kinds, arrangement.sides.tolist(), strict=True)
    ]
    return [
        tuple(int(free and sign < 0) for free, sign in zip(both, choice, strict=True))
        for choice in side_choices(arrangement).tolist()
    ]
