"""The functions that solve any instance: once, or for many sets of values."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.types import MAX_ANGLES
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.building import checked
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.solver.arguments import problems_of, value_rows, whole
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.proof import Ground, Proof
from gspcli.solver.result import SolveResult, stable_order

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.continuation.pursuit import Pursuit

Array = NDArray[np.float64]

#: Work that an exact count may take unless somebody asks for it, in billions of multiplications
#: modulo a prime: about as many seconds.
PATIENCE = 2.0


def solve(
    instance: Instance,
    *,
    seed: int = SEED,
    jobs: int = 1,
    certify: bool = True,
    prove: bool | None = None,
) -> SolveResult:
    """Return all poses of an instance, proved, with an account of every path.

    Platforms with three angles are solved in closed form (Algorithm 6.6), all others by
    tracking paths. If that does not give as many distinct simple poses as the type has, the
    platform is in special or nearly special position: its poses are counted exactly, modulo a
    random prime, and located with as many digits as they need.

    Parameters
    ----------
    instance
        The platform, whose numbers are meant exactly as they are written; the sides of its DPH
        and DHP distances say which solutions are asked for.
    seed
        Source of random choices. Another seed gives the same poses in the same order.
    jobs
        Threads for path tracking. The answer does not depend on them.
    certify
        Whether to prove each pose of a platform in general position, and whether it is real.
        In special position that is always done.
    prove
        Whether to count the poses of a special platform however long it takes (True), not at
        all (False), or if it takes no longer than `PATIENCE` (None). Without a count only
        as many certified poses as the type has prove that there are no others.

    Raises
    ------
    ArgumentError
        If an argument is wrong: not an instance, not six constraints, a value out of range.
    """
    checked(instance)
    seed, jobs = whole(seed, "seed", least=0), whole(jobs, "jobs", least=1)
    arrangement = Arrangement.of(instance)
    pursuits: list[Pursuit] | None = None
    # Each method is imported when it is needed: start-up is most of the time of one solve.
    if len(arrangement.angles) == MAX_ANGLES:
        from gspcli.solver.closed_form import solve_closed_form

        poses: PoseSet | None = solve_closed_form(arrangement)
    else:
        pursuits, poses = next(_each_tracked([arrangement], seed, jobs))
    if poses is not None and certify and len(poses.R):
        poses = _proved(instance, poses)
    if poses is None or not _is_general(poses, certify):
        limit = {True: None, False: 0.0, None: PATIENCE}[prove]
        poses = _special(instance, arrangement, pursuits, seed, jobs, limit)
    poses = poses.reordered(stable_order(poses, arrangement.length))
    return SolveResult(instance, arrangement, poses, seed)


def _each_tracked(
    arrangements: Iterable[Arrangement], seed: int, jobs: int
) -> Iterator[tuple[list[Pursuit], PoseSet | None]]:
    """Yield the paths of each platform, and their ends if all are distinct simple poses."""
    from gspcli.solver.tracking import poses_by_paths, pursue_each

    for arrangement, pursuits in pursue_each(arrangements, seed=seed, jobs=jobs):
        regular = all(pursuit.is_regular for pursuit in pursuits)
        yield pursuits, poses_by_paths(arrangement, pursuits) if regular else None


def _special(
    instance: Instance,
    arrangement: Arrangement,
    pursuits: list[Pursuit] | None,
    seed: int,
    jobs: int,
    limit: float | None,
) -> PoseSet:
    """Return the poses of a platform that is not in general position."""
    from gspcli.solver.special import solve_special

    if pursuits is None:
        pursuits, _ = next(_each_tracked([arrangement], seed, jobs))
    return solve_special(instance, arrangement, pursuits, seed=seed, limit=limit)


def _proved(instance: Instance, poses: PoseSet) -> PoseSet:
    """Return poses with certificates, and with a proof if they are as many as the type has."""
    from gspcli.certification import decide

    poses = poses.decided(*decide(instance, poses.R, poses.T))
    complete = poses.certified.sum() == poses.account.expected
    return replace(poses, proof=Proof(Ground.TYPE)) if complete else poses


def _is_general(poses: PoseSet, certify: bool) -> bool:
    """Whether there are as many distinct simple poses as the type has, as asked proved or not."""
    simple = int((poses.multiplicity == 1).sum())
    return poses.proof is not None if certify else simple == poses.account.expected


def solve_values(
    instance: Instance,
    values: ArrayLike,
    *,
    seed: int = SEED,
    jobs: int = 1,
    certify: bool = False,
) -> Iterator[PoseSet]:
    """Yield all poses of an instance for each of many sets of values, in order.

    This is the quick way to many poses of one geometry: it is solved once for complex values, and
    from there the values alone are moved. The values of the instance itself are not used. Poses
    in general position are certified only if that is asked for, those in special or nearly
    special position always.

    Parameters
    ----------
    instance
        The geometry, units and sides.
    values
        Distances and angles in the units and order of the instance, shape (batch, 6).
    seed, jobs
        As for `solve`.
    certify
        Whether to prove each pose, and whether it is real, and so that there are no others.

    Raises
    ------
    ArgumentError
        If an argument is of another sort or shape. A set of values that is wrong (not a number,
        a negative distance) only spoils its own `PoseSet`, whose `problem` says so.
    """
    checked(instance)
    seed, jobs = whole(seed, "seed", least=0), whole(jobs, "jobs", least=1)
    rows = value_rows(values)
    problems = problems_of(instance, rows)
    right = [problem is None for problem in problems]
    rows = rows if all(right) else rows[right]
    solved = _solve_rows(instance, rows, seed, jobs, certify=certify)
    return (
        next(solved) if problem is None else PoseSet.unsolved(instance.expected, problem)
        for problem in problems
    )


def _solve_rows(
    instance: Instance, rows: Array, seed: int, jobs: int, *, certify: bool
) -> Iterator[PoseSet]:
    """Yield the poses for each set of values; those of special platforms are proved."""
    arrangement = Arrangement.of(instance)
    quick = _quick_rows(instance, arrangement, rows, seed, jobs, certify=certify)
    for row, found in zip(rows, quick, strict=True):
        if found is not None and (found.proof is not None or not certify):
            yield found
            continue
        numbers = {i: Number.of(value) for i, value in enumerate(row.tolist())}
        given, one = instance.with_values(numbers), arrangement.with_values(row)
        pursuits, poses = None, found
        if poses is None:
            pursuits, poses = next(_each_tracked([one], seed, jobs))
        if poses is not None and certify:
            poses = _proved(given, poses)
        if poses is None or not _is_general(poses, certify):
            poses = _special(given, one, pursuits, seed, jobs, PATIENCE)
        yield poses


def _quick_rows(
    instance: Instance,
    arrangement: Arrangement,
    rows: Array,
    seed: int,
    jobs: int,
    *,
    certify: bool,
) -> Iterator[PoseSet | None]:
    """Yield the poses for each set of values; None if they are not found for certain."""
    if len(arrangement.angles) == MAX_ANGLES:
        from gspcli.solver.closed_form import solve_closed_forms

        for poses in solve_closed_forms(arrangement, rows):
            yield poses if _is_general(poses, certify=False) else None
        return
    from gspcli.solver.one_geometry import solve_rows

    def count() -> ExactCount | None:
        from gspcli.certification.counting import geometry_count

        return geometry_count(instance, seed=seed, limit=PATIENCE)

    proofs = None
    if certify and len(rows):
        from gspcli.certification.many_values import ValueProofs

        proofs = ValueProofs.of(instance, rows)
    yield from solve_rows(arrangement, rows, count=count, proofs=proofs, seed=seed, jobs=jobs)
