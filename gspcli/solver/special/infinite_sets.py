"""Platforms whose equations have infinitely many solutions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from gspcli.catalogue.kinds import DLL, DPP
from gspcli.catalogue.types import CONSTRAINTS
from gspcli.certification import certify
from gspcli.certification.counting import ExactCount, by_points
from gspcli.continuation.endpoints import BESIDE_CURVES
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.solutions import SolutionCurve
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.local_motions import Motion, local_motion
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point
from gspcli.geometry.quaternions import Field, made_real
from gspcli.geometry.residuals import relative_residuals
from gspcli.solver.ledger import Ledger
from gspcli.solver.problem import Problem
from gspcli.solver.results.pose_set import PoseSet, joined
from gspcli.solver.results.proof import CountKind, Proof
from gspcli.solver.special.real_statements import isolated_real_poses

#: Samples of a motion meet the constraints up to this part of their size.
_ON_MOTION = 1e-8
#: This many poses are tried as places near real ones.
_TRIED = 16
#: A pose is certified with legs between this many sets of random points beside the constraints.
_TRIES = 4


def poses_of_repeated(problem: Problem, ledger: Ledger) -> PoseSet | None:
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
    poses = solve_infinite(problem, ledger, None)
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
    problem: Problem, ledger: Ledger, count: ExactCount, solve: Callable[[Instance], PoseSet]
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
        poses = solve_infinite(problem, ledger, proof)
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


def solve_infinite(problem: Problem, ledger: Ledger, proof: Proof | None) -> PoseSet:
    """Return sample motions and isolated poses of a platform.

    The isolated poses are the proved ones: no simple solution lies on a set of solutions. The
    equation of a DLL holds wherever its lines are parallel, at any distance: then infinitely many
    solutions need not be infinitely many poses. If no motion is found then, the platform is not
    solved.

    Parameters
    ----------
    problem, ledger
        The platform, and its proved poses.
    proof
        What proves the set of poses to be infinite; None if only that of the equations is.
    """
    arrangement, tracked = problem.arrangement, problem.tracked
    poses = joined([side.poses() for side in ledger.sides])
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
            R, T = arrangement.poses_of(tracked_paths.first().points)
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
