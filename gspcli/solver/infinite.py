"""Platforms whose equations have infinitely many solutions, as an exact count has said."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from gspcli.certification import decide
from gspcli.continuation.endpoints import BESIDE_CURVES
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import Field
from gspcli.geometry.residuals import relative_residuals
from gspcli.solver.pose_set import Motion, PoseSet
from gspcli.solver.poses_by_paths import poses_by_paths, poses_of
from gspcli.solver.problem import Problem
from gspcli.solver.proof import Proof
from gspcli.solver.self_motion import local_motion

#: Samples of a motion meet the constraints up to this part of their size.
_ON_MOTION = 1e-8
#: So many poses are tried as places near real ones.
_TRIED = 16


def solve_infinite(problem: Problem, proof: Proof | None) -> PoseSet:
    """Return sample motions and isolated poses of a platform.

    The equation of a DLL holds wherever its lines are parallel, at any distance: then infinitely
    many solutions need not be infinitely many poses. If no motion is found then, the platform is
    not solved.

    Parameters
    ----------
    problem
        The platform.
    proof
        What proves the set of poses to be infinite; None if only that of the equations is.
    """
    instance, arrangement, tracked = problem.instance, problem.arrangement, problem.tracked
    best = _cleaned(arrangement, poses_by_paths(arrangement, tracked, BESIDE_CURVES))
    best = best.decided(decide(instance, best.R, best.T)) if len(best.R) else best
    motions = _with_real_motion(arrangement, best.motions, tracked)
    if best.motions:
        best = _isolated(best)
        # Without a proof the count may mean parallel lines: the samples are evidence.
        return replace(best, motions=motions, proof=proof)
    if motions or proof is not None:
        # No path has ended at a sample, but some must end on the set: those that are lost or seemed
        # to end at infinity.
        best = _isolated(best)
        rest = best.account.expected - best.account.found
        reduced = replace(_lost(best.account), on_curves=rest, lost=0)
        return replace(best, motions=motions, account=reduced, proof=proof)
    # Whether there are poses beside those with parallel lines, nobody knows.
    return replace(best, account=_lost(best.account))


def along_points(
    instance: Instance, arrangement: Arrangement, samples: Sequence[Motion], proof: Proof | None
) -> PoseSet:
    """Return the motions of a platform whose lines are parallel all along.

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
            R, T = poses_of(arrangement, tracked_paths.first().points)
        finite = np.isfinite(R).all(axis=(1, 2)) & np.isfinite(T).all(axis=1)
        yield from zip(R[finite], T[finite], strict=True)


def _isolated(poses: PoseSet) -> PoseSet:
    """Drop the poses that are not proved to be isolated: they may lie on the set."""
    kept, account = poses.reordered(poses.certified), poses.account
    found = int(kept.multiplicity.sum())
    on_curves = account.on_curves + account.found - found
    return replace(kept, account=replace(account, found=found, on_curves=on_curves))


def _cleaned(arrangement: Arrangement, poses: PoseSet) -> PoseSet:
    """Drop the motions whose samples do not meet the constraints as they are stated."""
    kept = tuple(motion for motion in poses.motions if _holds(arrangement, motion))
    if len(kept) == len(poses.motions):
        return poses
    account = poses.account
    if not kept:
        account = replace(account, on_curves=0, lost=account.lost + account.on_curves)
    return replace(poses, motions=kept, account=account)


def _holds(arrangement: Arrangement, motion: Motion) -> bool:
    found = relative_residuals(arrangement, motion.R, motion.T)
    found[:, arrangement.distances] /= max(1.0, np.abs(motion.T).max() / arrangement.length)
    return bool(found.max() <= _ON_MOTION)


def _lost(account: PathAccount) -> PathAccount:
    """Return the account with everything lost that is no pose."""
    rest = account.expected - account.found
    return PathAccount(expected=account.expected, found=account.found, lost=rest)
