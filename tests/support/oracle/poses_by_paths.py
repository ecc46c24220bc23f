"""All poses of any platform by tracking paths from a solved start system."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.endpoints import SystemSolutions
from gspcli.continuation.paths import PathAccount
from gspcli.continuation.systems import System
from gspcli.continuation.tracked_paths import TrackedPaths, track_all
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.local_motions import Motion
from gspcli.geometry.quaternions import (
    canonical_sign,
    made_real,
    normalized,
    quaternion_from_rotation,
    unit_quaternion,
)
from gspcli.solver.poses import PoseSet
from gspcli.solver.study_systems import target_systems
from tests.support.oracle.parallel_ends import judge_parallel_lines, polish_parallel_lines

Complex = NDArray[np.complex128]


def solve_by_tracking(arrangement: Arrangement, *, seed: int) -> PoseSet:
    """Return all poses of a platform of any type; as `solve_each_by_tracking`."""
    return next(solve_each_by_tracking([arrangement], seed=seed))


def solve_each_by_tracking(
    arrangements: Iterable[Arrangement], *, seed: int, jobs: int = 1
) -> Iterator[PoseSet]:
    """Yield all poses of each platform, in order, as they become known.

    One system is solved for each combination of sides asked for. Whether a solution is real
    is decided by pairing conjugates within its system. Platforms of one type are quicker
    together.

    Parameters
    ----------
    arrangements
        The platforms, of any types.
    seed
        Source of the random paths. Another seed gives the same sets of poses.
    jobs
        Threads. The result does not depend on them.
    """
    for arrangement, tracked in track_platforms(arrangements, seed=seed, jobs=jobs):
        yield poses_by_paths(arrangement, tracked)


def track_platforms(
    arrangements: Iterable[Arrangement], *, seed: int, jobs: int = 1
) -> Iterator[tuple[Arrangement, list[TrackedPaths]]]:
    """Yield each platform with the paths to its poses: one `TrackedPaths` for each choice of sides.

    Parameters
    ----------
    arrangements, seed, jobs
        As for `solve_each_by_tracking`.
    """
    waiting: deque[tuple[Arrangement, int]] = deque()

    def systems() -> Iterator[System]:
        for arrangement in arrangements:
            targets = target_systems(arrangement.normalized)
            waiting.append((arrangement, len(targets)))
            yield from targets

    tracked = track_all(systems(), seed=seed, jobs=jobs)
    for first in tracked:
        arrangement, count = waiting.popleft()
        yield arrangement, [first, *islice(tracked, count - 1)]


def real_points(points: Complex) -> tuple[Complex, NDArray[np.bool_]]:
    """Return points of norm one, real ones exactly real, and which are real.

    A point is real if no other one of the set is nearer to its conjugate.
    """
    z = normalized(points)
    products = z.conj() @ z.conj().T
    phases = products / np.where(products == 0, 1, np.abs(products))
    gaps = np.linalg.norm(z.conj()[:, None] - phases.T[..., None] * z, axis=2)
    real = np.diag(gaps) <= gaps.min(axis=1, initial=np.inf)
    z[real] = made_real(z[real])
    return z, real


def poses_by_paths(arrangement: Arrangement, tracked: Sequence[TrackedPaths]) -> PoseSet:
    """Return where the paths for all sides end, by numerical path tracking alone."""
    results = [tracked_paths.solutions() for tracked_paths in tracked]
    pairs = [real_points(result.points) for result in results]
    points = np.concatenate([representatives for representatives, _ in pairs])
    real = np.concatenate([real for _, real in pairs])
    multiplicity = np.concatenate([result.multiplicity for result in results])
    R, T = arrangement.poses_of(points)
    spurious, undecided = judge_parallel_lines(arrangement, R, T, multiplicity > 1)
    quaternions = canonical_sign(unit_quaternion(points[:, :4]))
    polished, T = polish_parallel_lines(arrangement, R, T, multiplicity == 1)
    if polished is not R:
        R, quaternions = polished, quaternion_from_rotation(polished)
    posed = ~spurious & ~undecided
    motions, beside = _motions(arrangement, results)
    account = sum((result.account for result in results), PathAccount(expected=0))
    none, unknown = (int(multiplicity[where].sum()) for where in (spurious, undecided))
    return PoseSet(
        quaternions=quaternions[posed],
        R=R[posed],
        T=T[posed],
        real=real[posed],
        certified=np.zeros(int(posed.sum()), dtype=np.bool_),
        multiplicity=multiplicity[posed],
        motions=motions,
        account=replace(
            account,
            found=account.found - none - unknown,
            on_curves=account.on_curves - beside,
            spurious=none + beside,
            lost=account.lost + unknown,
        ),
    )


def _motions(
    arrangement: Arrangement, results: list[SystemSolutions]
) -> tuple[tuple[Motion, ...], int]:
    """Return the motions, and how many paths end on sets that are none (parallel lines)."""
    motions, beside = [], 0
    for curve in (curve for result in results for curve in result.curves):
        R, T = arrangement.poses_of(made_real(curve.motion) if curve.real else curve.motion)
        spurious, _ = judge_parallel_lines(arrangement, R, T, np.ones(len(R), dtype=np.bool_))
        # The distances of parallel lines hold all along a motion or almost nowhere.
        if spurious.any():
            beside += len(curve.points)
        else:
            motions.append(Motion(curve.dimension, curve.real, R, T))
    return tuple(motions), beside
