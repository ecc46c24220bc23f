"""Platforms in special or nearly special position, solved by an exact count of their poses."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, islice

import numpy as np

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import DLL, DPP
from gspcli.catalogue.types import CONSTRAINTS, MAX_ANGLES, GspType
from gspcli.certification import certify, refine
from gspcli.certification.counting import (
    ExactCount,
    PartCount,
    SideCount,
    by_points,
    exact_count,
    geometry_count,
)
from gspcli.certification.poses.certificates import excluded
from gspcli.certification.poses.multiple import MultiplePose, multiple_poses, where_parallel
from gspcli.certification.poses.pose_arrays import PoseProofs
from gspcli.continuation.endpoints import BESIDE_CURVES, COUNTED, SolutionCurve
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.local_motions import Motion, local_motion, real_statement
from gspcli.geometry.measurement import relative_residuals
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point
from gspcli.geometry.quaternions import Field, canonical_sign, made_real
from gspcli.solver.further import (
    FEW_PATHS,
    by_elimination,
    early_elimination,
    search_side,
    with_32_digits,
)
from gspcli.solver.poses import CountKind, PoseSet, Proof, joined
from gspcli.solver.problem import Problem
from gspcli.solver.search import Search
from gspcli.solver.side_search import FEW, SideSearch


def complete(side: SideSearch, solutions: int, distinct: int, spurious: int | None) -> PoseSet:
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
    if solutions > distinct and len(side) < distinct:
        multiple = [pose for pose in _multiple(side) if pose.is_pose or spurious is None]
    side.all_simple = solutions == distinct
    search_side(side, distinct - len(multiple))
    numbers = _multiplicities(len(side), multiple, solutions, distinct)
    if multiple and not numbers:
        # Multiple poses that are near each other are one end for doubles.
        multiple = [
            pose for pose in _with_paths_of_32_digits(side) if pose.is_pose or spurious is None
        ]
        numbers = _multiplicities(len(side), multiple, solutions, distinct)
    known = list(zip(multiple, numbers, strict=True)) if numbers else []
    return _pose_set(side.poses, known, side.paths.count, solutions, spurious or 0)


def _multiple(side: SideSearch) -> list[MultiplePose]:
    """Return the multiple poses at the ends of the endgame."""
    ends = side.paths.solutions(COUNTED)
    chosen = ends.multiplicity > 1
    points, paths = ends.points[chosen], ends.multiplicity[chosen].tolist()
    low = np.zeros((len(points), 0, 8), complex)
    return list(multiple_poses(side.locator, points, low, paths, side.sides))


def _with_paths_of_32_digits(side: SideSearch) -> list[MultiplePose]:
    """Return the multiple poses at the ends of all paths with 32 digits."""
    index = np.arange(side.paths.count)
    ends = [ends for _, ends in side.paths.track(index, side.target)]
    points = np.concatenate([part.points[0] for part in ends])
    low = np.concatenate([part.more for part in ends])
    return list(multiple_poses(side.locator, points, low, [1] * len(points), side.sides))


def _multiplicities(
    found: int, multiple: list[MultiplePose], solutions: int, distinct: int
) -> list[int]:
    """Return the multiplicities if the multiple poses are those that the counts leave.

    Each is at least two, so that nothing is left to choose if they are two on average, or if
    there is one pose; else the paths decide. Empty if something does not agree.
    """
    distinct, paths = distinct - found, solutions - found
    if len(multiple) != distinct:
        return []
    if paths == 2 * distinct:
        return [2] * distinct
    if distinct == 1:
        return [paths]
    numbers = [pose.multiplicity for pose in multiple]
    return numbers if sum(numbers) == paths else []


def _pose_set(
    proved: PoseProofs,
    known: list[tuple[MultiplePose, int]],
    paths: int,
    solutions: int,
    counted: int,
) -> PoseSet:
    """Return the simple poses, and the multiple ones with their multiplicities."""
    multiple = [pose for pose, _ in known if pose.is_pose]
    numbers = [number for pose, number in known if pose.is_pose]
    spurious = sum(number for pose, number in known if not pose.is_pose)
    found = len(proved.R)
    reached = found + sum(numbers) + spurious
    # More than were counted: the prime of the count is a bad one, or a proof is wrong.
    excess = reached > solutions or solutions + counted > paths
    return PoseSet(
        quaternions=canonical_sign(
            np.concatenate([proved.quaternions, *(pose.quaternion[None] for pose in multiple)])
        ),
        R=np.concatenate([proved.R, *(pose.R[None] for pose in multiple)]),
        T=np.concatenate([proved.T, *(pose.T[None] for pose in multiple)]),
        real=np.array([*proved.real.tolist(), *(pose.real for pose in multiple)], np.bool_),
        certified=np.arange(found + len(multiple)) < found,
        multiplicity=np.array([1] * found + numbers, np.int64),
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
    side: SideSearch, count: SideCount, solve: Callable[[Instance], PoseSet]
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
        expected=paths, found=reached, spurious=paths - reached - lost, lost=lost, basis=Basis.COUNT
    )
    if not found:
        return replace(PoseSet.unsolved(paths), account=account)
    return replace(joined(found), motions=(), account=account)


def _with_parallel_lines(instance: Instance, part: PartCount, poses: PoseSet) -> PoseSet:
    """Return those poses at which just the lines of a part are parallel."""
    kept = poses[where_parallel(instance, part.parallel, poses.R, poses.T)]
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
    side: SideSearch, count: SideCount, solve: Callable[[Instance], PoseSet]
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


#: This many choices of six constraints are counted, of types with at most this many poses.
_CHOICES, _MOST_POSES = 40, 640
#: Decimals to which a pose is compared with the constraints that it was not made from.
_DIGITS = 50
#: Residuals, lengths by that of the platform, of what holds and what does not. Of multiple poses,
#: and of the distance of parallel lines, where its equation always holds, nothing else is known.
_HOLDS, _FAILS = 1e-9, 1e-4


def isolated_real_poses(
    instance: Instance, solve: Callable[[Instance], PoseSet]
) -> tuple[Motion, ...] | None:
    """Return the real poses of a platform, each a motion of dimension zero.

    It is proved that there are no others, and so that none can move. That all constraints hold at
    each of them is known to fifty decimals, or nine where poses meet and for the distance of
    parallel lines.

    Parameters
    ----------
    instance
        A platform with infinitely many solutions.
    solve
        How to solve the platforms that take its place.

    Returns
    -------
    tuple of Motion or None
        None if no constraint is several real ones, or if no six of these have finitely many
        solutions that can all be found.
    """
    unit = instance.units.angle
    rows = tuple(row for given in instance.constraints for row in real_statement(given, unit))
    if len(rows) == CONSTRAINTS:
        return None
    # The sense of a direction is said by the angle itself.
    whole = replace(instance, constraints=(*rows, *instance.constraints))
    for chosen in islice(_choices(replace(instance, constraints=rows)), _CHOICES):
        count = exact_count(chosen)
        if count is not None and count.finite:
            poses = solve(chosen)
            return _common(whole, chosen, poses) if poses.proof is not None else None
    return None


def _choices(instance: Instance) -> Iterator[Instance]:
    """Yield six of the constraints at a time, those of types with few poses first."""
    choices: list[tuple[int, int, tuple[Constraint, ...]]] = []
    for rows in combinations(instance.constraints, CONSTRAINTS):
        if sum(not row.kind.is_distance for row in rows) <= MAX_ANGLES:
            counts = generic_counts(GspType.of(row.kind for row in rows))
            if counts.one_sided <= _MOST_POSES:
                choices.append((counts.one_sided, len(choices), rows))
    for _, _, rows in sorted(choices, key=lambda choice: choice[:2]):
        yield replace(instance, constraints=rows)


def _common(whole: Instance, chosen: Instance, poses: PoseSet) -> tuple[Motion, ...] | None:
    """Return the real poses at which all constraints hold, None if some are undecided."""
    real = poses[poses.real]
    arrangement = Arrangement.of(whole)
    sizes = relative_residuals(arrangement, real.R, real.T).max(axis=1, initial=0.0)
    kept = []
    certificates = certify(chosen, real.R, real.T)
    for k, certificate in enumerate(certificates):
        if _HOLDS < sizes[k] < _FAILS:
            return None
        if sizes[k] > _HOLDS:
            continue
        exact = refine(chosen, certificate, _DIGITS) if certificate.certified else None
        if exact is None or not excluded(whole, exact):
            kept.append(Motion(0, True, real.R[k : k + 1].real, real.T[k : k + 1].real))
    return tuple(kept)


#: Samples of a motion meet the constraints up to this part of their size.
_ON_MOTION = 1e-8
#: This many poses are tried as places near real ones.
_TRIED = 16
#: A pose is certified with legs between this many sets of random points beside the constraints.
_TRIES = 4


def poses_of_repeated(problem: Problem, search: Search) -> PoseSet | None:
    """Return the motions of a platform that has equal constraints; None if it has none.

    Fewer than six equations on the six-dimensional set of poses have a solution set of positive
    dimension through each of their solutions: an equation takes away at most one dimension. So one
    certified pose proves what an elimination of a set of four dimensions takes minutes for
    (``same-points/*/exact`` of tests/oracles/special-platforms.yaml). The result is None, too, if
    no real motion is found at a certified pose.
    """
    rows = _different(problem.instance.constraints)
    if len(rows) == CONSTRAINTS:
        return None
    poses = solve_infinite(problem, search, None)
    real = [motion for motion in poses.motions if motion.real and motion.dimension]
    if any(_is_pose(problem.instance, rows, motion, problem.seed) for motion in real[:1]):
        return replace(poses, proof=Proof(CountKind.EXACT))
    return None


def _different(constraints: Sequence[Constraint]) -> list[Constraint]:
    """Return the constraints without those that say the same as one before them."""
    known = {
        (row.kind, row.platform, row.base, str(row.value), row.side): row for row in constraints
    }
    return list(known.values())


def _is_pose(instance: Instance, rows: Sequence[Constraint], motion: Motion, seed: int) -> bool:
    """Return whether there is a pose at a sample: one of six constraints that include the rows."""
    R, T = motion.R[0].real, motion.T[0].real
    rng = np.random.default_rng(seed)
    size = max(1.0, float(np.abs(T).max()))
    for _ in range(_TRIES):
        legs = [_leg(R, T, *pair) for pair in size * rng.standard_normal((6 - len(rows), 2, 3))]
        whole = replace(instance, constraints=(*rows, *legs))
        if certify(whole, R[None], T[None])[0].certified:
            return True
    return False


def _leg(R: np.ndarray, T: np.ndarray, on_platform: np.ndarray, on_base: np.ndarray) -> Constraint:
    """Return a distance of two points that has its value at a pose."""
    value = float(np.linalg.norm(R @ on_platform + T - on_base))
    return Constraint(DPP, Point(on_platform), Point(on_base), Number.of(value))


def infinitely_many(
    problem: Problem, search: Search, count: ExactCount, solve: Callable[[Instance], PoseSet]
) -> PoseSet:
    """Return motions and isolated poses of a platform with infinitely many."""
    instance, proof = problem.instance, _proof(problem.instance, count)
    if (moving := _moving_with_parallel_lines(instance, count)) is not None:
        # Lines are parallel at every pose: there are no isolated ones.
        found = tuple(x for x in solve(moving).motions if _holds(problem.arrangement, x))
        paths = instance.expected
        account = PathAccount(expected=paths, on_curves=paths, basis=Basis.COUNT)
        poses = replace(PoseSet.unsolved(paths), motions=found, account=account, proof=proof)
    else:
        poses = solve_infinite(problem, search, proof)
    if poses.account.verdict != "infinite" or any(motion.real for motion in poses.motions):
        return poses
    length = problem.arrangement.length
    isolated = isolated_real_poses(instance, lambda other: solve(other).in_order(length))
    return replace(poses, motions=(*(isolated or ()), *poses.motions))


def _proof(instance: Instance, count: ExactCount) -> Proof | None:
    """Return what proves that there are infinitely many poses, as they are stated."""
    if all(row.kind is not DLL for row in instance.constraints):
        return Proof.modulo(CountKind.EXACT, count.error)
    # The equations alone may be infinitely many because lines are parallel.
    errors = [side.infinite_part.error for side in count.sides if side.infinite_part]
    return Proof.modulo(CountKind.EXACT, min(errors)) if errors else None


def _moving_with_parallel_lines(instance: Instance, count: ExactCount) -> Instance | None:
    """Return the platform with points for lines that are parallel at infinitely many poses."""
    for side in count.sides:
        part = side.infinite_part
        if part is not None and part.parallel:
            return by_points(instance.on_sides(side.signs), part.parallel)
    return None


def solve_infinite(problem: Problem, search: Search, proof: Proof | None) -> PoseSet:
    """Return sample motions and isolated poses of a platform.

    The isolated poses are the proved ones: no simple solution lies on a set of solutions. The
    equation of a DLL holds wherever its lines are parallel, at any distance: then infinitely many
    solutions need not be infinitely many poses. If no motion is found then, the platform is not
    solved.

    Parameters
    ----------
    problem, search
        The platform, and its proved poses.
    proof
        What proves the set of poses to be infinite; None if only that of the equations is.
    """
    arrangement, tracked = problem.arrangement, problem.tracked
    poses = joined([side.answer() for side in search.sides])
    results = [paths.solutions(BESIDE_CURVES) for paths in tracked]
    samples = (_motion(arrangement, curve) for result in results for curve in result.curves)
    found = tuple(motion for motion in samples if _holds(arrangement, motion))
    motions = _with_real_motion(arrangement, found, tracked)
    account = poses.account
    if not motions and proof is None:
        # Whether there are poses beside those with parallel lines is not known.
        return replace(poses, account=_lost(account))
    # Paths that lead to no isolated pose end on the set, or at infinity. Those that seem to end at
    # infinity may end on the set if no path has ended at a sample.
    rest = account.expected - account.found
    at_infinity = sum(result.account.at_infinity for result in results) if found else 0
    at_infinity = min(at_infinity, rest)
    account = PathAccount(
        expected=account.expected,
        found=account.found,
        at_infinity=at_infinity,
        on_curves=rest - at_infinity,
    )
    return replace(poses, motions=motions, account=account, proof=proof)


def _motion(arrangement: Arrangement, curve: SolutionCurve) -> Motion:
    """Return the poses along a sample of a curve of solutions."""
    points = made_real(curve.motion) if curve.real else curve.motion
    return Motion(curve.dimension, curve.real, *arrangement.poses_of(points))


def _with_real_motion(
    arrangement: Arrangement, motions: tuple[Motion, ...], tracked: Sequence[TrackedPaths]
) -> tuple[Motion, ...]:
    """Return motions with a real one, even if no path has ended at one of its poses.

    Real poses are sought near those of the other motions, and near the ends of paths.
    """
    if any(motion.real for motion in motions):
        return motions
    for R, T in islice(_places(arrangement, motions, tracked), _TRIED):
        near = local_motion(arrangement, R, T)
        if near is not None and near.real and _holds(arrangement, near):
            return (near, *motions)
    return motions


def _places(
    arrangement: Arrangement, motions: Sequence[Motion], tracked: Sequence[TrackedPaths]
) -> Iterator[tuple[Field, Field]]:
    for motion in motions[: _TRIED // 2]:
        yield motion.R[0], motion.T[0]
    for tracked_paths in tracked:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            R, T = arrangement.poses_of(tracked_paths.first().points[0])
        finite = np.isfinite(R).all(axis=(1, 2)) & np.isfinite(T).all(axis=1)
        yield from zip(R[finite], T[finite], strict=True)


def _holds(arrangement: Arrangement, motion: Motion) -> bool:
    found = relative_residuals(arrangement, motion.R, motion.T)
    found[:, arrangement.distances] /= max(1.0, np.abs(motion.T).max() / arrangement.length)
    return bool(found.max() <= _ON_MOTION)


def _lost(account: PathAccount) -> PathAccount:
    """Return the account with everything lost that is no pose."""
    rest = account.expected - account.found
    return PathAccount(expected=account.expected, found=account.found, lost=rest)


#: For each path, a count takes longer than to track this part of the paths with 32 digits. More
#: than the second part of the paths are not tracked again: then the platform is special.
_LONG, _MOST = 1 / 2500, 1 / 5
#: A count with a larger probability of error is replaced by the count of the geometry, if smaller.
_DOUBTFUL = 1e-9


def poses_by_count(
    problem: Problem, search: Search, solve: Callable[[Instance], PoseSet]
) -> PoseSet:
    """Return all poses of a platform of which fewer are proved than its type has.

    Parameters
    ----------
    problem, search
        The platform, and its proved poses. Its careful paths have been tracked.
    solve
        Returns all poses of another platform, solved likewise.
    """
    count = None
    if problem.limit != 0:
        if (poses := poses_of_repeated(problem, search)) is not None:
            return poses
        if (poses := _by_geometry_or_type(problem, search)) is not None:
            return poses
        suspect = any(_unresolved(side) * FEW > side.paths.count for side in search.sides)
        count = exact_count(
            problem.instance, seed=problem.seed, limit=problem.limit, suspect=suspect
        )
    if count is None:
        return _uncounted(problem, search)
    if any(side.solutions is None and not side.parallel for side in count.sides):
        return infinitely_many(problem, search, count, solve)
    parts = [
        _of_side(side, counted, solve).on_sides(problem.choices[k : k + 1])
        for k, (side, counted) in enumerate(zip(search.sides, count.sides, strict=True))
    ]
    # A set without a sample of it may have real poses that are isolated, such as lines that
    # coincide.
    if any(part.account.on_curves and not part.motions for part in parts):
        return infinitely_many(problem, search, count, solve)
    return _with_better_proof(problem, _proved(joined(parts), count))


def _by_geometry_or_type(problem: Problem, search: Search) -> PoseSet | None:
    """Return as many proved poses as the geometry or the type has; None if fewer are found soon."""
    # With products there are more paths, and a count takes several times as long.
    if not problem.is_reducible and (poses := _with_32_digits(search)) is not None:
        return poses
    # From now on the search has the count of the geometry.
    counted = problem.geometry_count
    if counted is not None and (poses := search.complete) is not None:
        return poses
    is_small = problem.expected <= FEW_PATHS
    if counted is not None and counted.solutions and (counted.has_lone_lines or is_small):
        # Almost all sets of values have as many poses as the geometry: a count of the platform
        # itself takes a tenth of the time of a first solution (`tools.verify.realistic`).
        most = counted.solutions // len(search.sides)
        for side in search.sides:
            side.all_simple = counted.distinct == counted.solutions
            search_side(side, most, early_elimination)
        return search.complete
    return _with_32_digits(search)


def _with_32_digits(search: Search) -> PoseSet | None:
    """Follow wrong paths with 32 digits, unless a count is quicker; None if poses are missing."""
    if not any(_too_many_unresolved(side) for side in search.sides):
        for side in search.sides:
            search_side(side, side.paths.count, with_32_digits)
    return search.complete


def _with_better_proof(problem: Problem, poses: PoseSet) -> PoseSet:
    """Return poses with the count of the geometry as proof, where that misleads less often."""
    exact = poses.proof
    if poses.account.verdict == "incomplete" or (exact is not None and exact.error < _DOUBTFUL):
        return poses
    # Angles with many decimals leave few primes to count exactly with, but not for the geometry.
    geometry = geometry_count(problem.instance, seed=problem.seed, limit=problem.limit)
    proofs = [proof for proof in (exact, _by_geometry(poses, geometry)) if proof is not None]
    return replace(poses, proof=min(proofs, key=lambda proof: proof.error) if proofs else None)


def _of_side(side: SideSearch, count: SideCount, solve: Callable[[Instance], PoseSet]) -> PoseSet:
    """Return the poses for a choice of sides by its count."""
    if count.parallel:
        return with_points_for_all(side, count, solve)
    if count.parts:
        return complete_parts(side, count, solve)
    return _counted(side, count)


def _unresolved(side: SideSearch) -> int:
    """Return how many paths in double precision do not end at simple solutions."""
    ends = side.paths.first()
    return int((~(ends.is_simple & ends.has_converged)).sum())


def _too_many_unresolved(side: SideSearch) -> bool:
    paths = side.paths.count
    return not paths or _unresolved(side) > min(max(1 / FEW, _LONG * paths), _MOST) * paths


def _counted(side: SideSearch, count: SideCount) -> PoseSet:
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


def _uncounted(problem: Problem, search: Search) -> PoseSet:
    """Return the poses of a platform that could not be counted exactly, by its geometry's count."""
    instance, limit, sides = problem.instance, problem.limit, search.sides
    count = geometry_count(instance, seed=problem.seed, limit=limit) if limit != 0 else None
    most = None
    # Two pairs of lines parallel at once spoil the argument (docs/counts.md), and a
    # geometry that has no pose for most values has infinitely many for others.
    if count is not None and count.solutions and count.has_lone_lines:
        # All choices of sides are alike.
        most = count.solutions // len(sides)
    for side in sides:
        _search_uncounted(side, side.paths.count if most is None else most)
    poses = joined([side.answer(most) for side in sides])
    proof = None if most is None else _by_geometry(poses, count)
    return _proved(poses, None) if proof is None else replace(poses, proof=proof)


def _search_uncounted(side: SideSearch, wanted: int) -> None:
    """Go on with the further strategies where no count says how many of the paths lead to poses."""

    def are_few_missing() -> bool:
        return (wanted - len(side)) * FEW <= side.paths.count

    search_side(side, wanted, early_elimination)
    # Eigenvectors are the last way to many poses that no path leads to.
    if side.all_simple or are_few_missing():
        search_side(side, wanted, by_elimination)
    if are_few_missing():
        search_side(side, wanted)


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
