"""Platforms whose equations have infinitely many solutions by an exact count."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from gspcli.continuation.endpoints import BESIDE_CURVES
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.solutions import SolutionCurve
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.conjugates import made_real
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import Field
from gspcli.geometry.residuals import relative_residuals
from gspcli.solver.ledger import Ledger
from gspcli.solver.problem import Problem
from gspcli.solver.results.pose_set import Motion, PoseSet, joined
from gspcli.solver.results.proof import Proof
from gspcli.solver.special.motions import local_motion

#: Samples of a motion meet the constraints up to this part of their size.
_ON_MOTION = 1e-8
#: So many poses are tried as places near real ones.
_TRIED = 16


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


def along_points(
    instance: Instance, arrangement: Arrangement, samples: Sequence[Motion], proof: Proof | None
) -> PoseSet:
    """Return the motions of a platform whose lines are parallel at every pose.

    Parameters
    ----------
    instance, arrangement
        The platform, exactly and in floating point.
    samples
        Motions of the platform with points for these lines.
    proof
        What proves the set of poses to be infinite.
    """
    paths = instance.expected
    return replace(
        PoseSet.unsolved(paths, ""),
        motions=tuple(motion for motion in samples if _holds(arrangement, motion)),
        account=PathAccount(expected=paths, on_curves=paths, basis=Basis.COUNT),
        proof=proof,
        problem=None,
    )


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
