"""Platforms in special or nearly special position, solved by an exact count of their poses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from gspcli.certification.counting import (
    ExactCount,
    SideCount,
    exact_count,
    geometry_count,
)
from gspcli.geometry.instance import Instance
from gspcli.solver.ledger import Ledger
from gspcli.solver.problem import Problem
from gspcli.solver.results.pose_set import PoseSet, joined
from gspcli.solver.results.proof import CountKind, Proof
from gspcli.solver.side_poses import FEW, SidePoses
from gspcli.solver.special.completion import (
    complete,
    complete_parts,
    with_points_for_all,
)
from gspcli.solver.special.infinite_sets import infinitely_many, poses_of_repeated

#: For each path, a count takes longer than to track this part of the paths with 32 digits. More
#: than the second part of the paths are not tracked again: then the platform is special.
_LONG, _MOST = 1 / 2500, 1 / 5
#: A count with a larger probability of error is replaced by the count of the geometry, if smaller.
_DOUBTFUL = 1e-9


def poses_by_count(
    problem: Problem, ledger: Ledger, solve: Callable[[Instance], PoseSet]
) -> PoseSet:
    """Return all poses of a platform of which fewer are proved than its type has.

    Parameters
    ----------
    problem, ledger
        The platform, and its proved poses. Its careful paths have been tracked.
    solve
        Returns all poses of another platform, solved likewise.
    """
    count = None
    if problem.limit != 0:
        if (poses := poses_of_repeated(problem, ledger)) is not None:
            return poses
        if (poses := _by_geometry_or_type(problem, ledger)) is not None:
            return poses
        suspect = any(_unresolved(side) * FEW > side.paths.count for side in ledger.sides)
        count = exact_count(
            problem.instance, seed=problem.seed, limit=problem.limit, suspect=suspect
        )
    if count is None:
        return _uncounted(problem, ledger)
    if any(side.solutions is None and not side.parallel for side in count.sides):
        return infinitely_many(problem, ledger, count, solve)
    parts = [
        _of_side(side, counted, solve).on_sides(problem.choices[k : k + 1])
        for k, (side, counted) in enumerate(zip(ledger.sides, count.sides, strict=True))
    ]
    # A set without a sample of it may have real poses that are isolated, such as lines that
    # coincide.
    if any(part.account.on_curves and not part.motions for part in parts):
        return infinitely_many(problem, ledger, count, solve)
    return _with_better_proof(problem, _proved(joined(parts), count))


def _by_geometry_or_type(problem: Problem, ledger: Ledger) -> PoseSet | None:
    """Return as many proved poses as the geometry or the type has; None if fewer are found soon."""
    # With products there are more paths, and a count takes several times as long.
    if not problem.is_reducible and (poses := _with_32_digits(ledger)) is not None:
        return poses
    # From now on the ledger has the count of the geometry.
    counted = problem.geometry_count
    if counted is not None and (poses := ledger.complete) is not None:
        return poses
    from gspcli.solver.strategies.further import FEW_PATHS, early_elimination, search

    is_small = problem.expected <= FEW_PATHS
    if counted is not None and counted.solutions and (counted.has_lone_lines or is_small):
        # Almost all sets of values have as many poses as the geometry: a count of the platform
        # itself takes a tenth of the time of a first solution (`tools.verify.realistic`).
        most = counted.solutions // len(ledger.sides)
        for side in ledger.sides:
            side.all_simple = counted.distinct == counted.solutions
            search(side, most, early_elimination)
        return ledger.complete
    return _with_32_digits(ledger)


def _with_32_digits(ledger: Ledger) -> PoseSet | None:
    """Follow wrong paths with 32 digits, unless a count is quicker; None if poses are missing."""
    from gspcli.solver.strategies.further import search, with_32_digits

    if not any(_too_many_unresolved(side) for side in ledger.sides):
        for side in ledger.sides:
            search(side, side.paths.count, with_32_digits)
    return ledger.complete


def _with_better_proof(problem: Problem, poses: PoseSet) -> PoseSet:
    """Return poses with the count of the geometry as proof, where that misleads less often."""
    exact = poses.proof
    if poses.account.verdict == "incomplete" or (exact is not None and exact.error < _DOUBTFUL):
        return poses
    # Angles with many decimals leave few primes to count exactly with, but not for the geometry.
    geometry = geometry_count(problem.instance, seed=problem.seed, limit=problem.limit)
    proofs = [proof for proof in (exact, _by_geometry(poses, geometry)) if proof is not None]
    return replace(poses, proof=min(proofs, key=lambda proof: proof.error) if proofs else None)


def _of_side(side: SidePoses, count: SideCount, solve: Callable[[Instance], PoseSet]) -> PoseSet:
    """Return the poses for a choice of sides by its count."""
    if count.parallel:
        return with_points_for_all(side, count, solve)
    if count.parts:
        return complete_parts(side, count, solve)
    return _counted(side, count)


def _unresolved(side: SidePoses) -> int:
    """Return how many paths in double precision do not end at simple solutions."""
    ends = side.paths.first()
    return int((~(ends.simple & ends.converged)).sum())


def _too_many_unresolved(side: SidePoses) -> bool:
    paths = side.paths.count
    return not paths or _unresolved(side) > min(max(1 / FEW, _LONG * paths), _MOST) * paths


def _counted(side: SidePoses, count: SideCount) -> PoseSet:
    """Return the poses for a choice of sides for which they were counted."""
    assert count.solutions is not None
    # Where distinct solutions were not counted, only simple ones can be all.
    solutions, distinct = count.solutions, count.distinct
    if distinct is None:
        distinct = solutions
    elif count.spurious is not None and count.spurious_distinct is not None:
        solutions, distinct = solutions - count.spurious, distinct - count.spurious_distinct
    known = None if count.distinct is None else count.spurious
    return complete(side, solutions, distinct, known)


def _uncounted(problem: Problem, ledger: Ledger) -> PoseSet:
    """Return the poses of a platform that could not be counted exactly, by its geometry's count."""
    instance, limit, sides = problem.instance, problem.limit, ledger.sides
    count = geometry_count(instance, seed=problem.seed, limit=limit) if limit != 0 else None
    most = None
    # Two pairs of lines parallel at once spoil the argument (docs/counts.md), and a
    # geometry that has no pose for most values has infinitely many for others.
    if count is not None and count.solutions and count.has_lone_lines:
        # All choices of sides are alike.
        most = count.solutions // len(sides)
    for side in sides:
        _search_uncounted(side, side.paths.count if most is None else most)
    poses = joined([side.poses(most) for side in sides])
    proof = None if most is None else _by_geometry(poses, count)
    return _proved(poses, None) if proof is None else replace(poses, proof=proof)


def _search_uncounted(side: SidePoses, wanted: int) -> None:
    """Go on with the further strategies where no count says how many of the paths lead to poses."""
    from gspcli.solver.strategies.further import by_elimination, early_elimination, search

    def are_few_missing() -> bool:
        return (wanted - len(side.found)) * FEW <= side.paths.count

    search(side, wanted, early_elimination)
    # Eigenvectors are the last way to many poses that no path leads to.
    if side.all_simple or are_few_missing():
        search(side, wanted, by_elimination)
    if are_few_missing():
        search(side, wanted)


def _by_geometry(poses: PoseSet, count: ExactCount | None) -> Proof | None:
    """Return the proof that poses are all, if they are as many as the geometry has."""
    number = int(poses.certified.sum())
    return Proof.by_geometry(count, number) if number < poses.account.expected else None


def _proved(poses: PoseSet, count: ExactCount | None) -> PoseSet:
    """Return poses with what proves that they are all, or infinitely many."""
    is_all = poses.certified.sum() == poses.account.expected
    proof = Proof(CountKind.TYPE) if is_all else None
    if proof is None and count is not None and poses.account.verdict != "incomplete":
        # Multiple poses need the count of the distinct ones, too.
        multiple = (poses.multiplicity > 1).any()
        proof = Proof.modulo(CountKind.EXACT, count.distinct_error if multiple else count.error)
    return replace(poses, proof=proof, exact_count=count.solutions if count else None)


def confirmed(problem: Problem, poses: PoseSet) -> PoseSet:
    """Return poses with a proof that a second prime confirms, so that both would have to be bad.

    Parameters
    ----------
    problem, poses
        The platform, and all its poses. If the second count is another one, they have no proof.
    """
    proof = poses.proof
    if proof is None or not proof.error or poses.account.verdict != "complete":
        return poses
    counted = exact_count if proof.by is CountKind.EXACT else geometry_count
    count = counted(problem.instance, seed=problem.seed + 1, limit=None)
    if count is None:
        return poses
    if proof.by is CountKind.GEOMETRY:
        other = _by_geometry(poses, count)
    else:
        other = _proved(poses, count).proof if count.solutions == poses.exact_count else None
    both = None if other is None else Proof(proof.by, proof.error * other.error)
    return replace(poses, proof=both)
