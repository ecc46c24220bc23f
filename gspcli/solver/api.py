"""The functions that solve any instance: once, or for many sets of values."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.types import MAX_ANGLES
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.building import checked
from gspcli.geometry.instance import Instance
from gspcli.solver.arguments import problems_of, value_rows, whole
from gspcli.solver.poses import PoseSet
from gspcli.solver.result import SolveResult, stable_order

Array = NDArray[np.float64]


def solve(
    instance: Instance, *, seed: int = SEED, jobs: int = 1, certify: bool = True
) -> SolveResult:
    """Return all poses of an instance, with an account of every path.

    Platforms with three angles are solved in closed form (Algorithm 6.6), all others by
    tracking paths.

    Parameters
    ----------
    instance
        The platform; the sides of its DPH and DHP distances say which solutions are asked for.
    seed
        Source of random choices. Another seed gives the same poses in the same order.
    jobs
        Threads for path tracking. The answer does not depend on them.
    certify
        Whether to prove each pose, and whether it is real.

    Raises
    ------
    ArgumentError
        If an argument is wrong: not an instance, not six constraints, a value out of range.
    """
    checked(instance)
    seed, jobs = whole(seed, "seed", least=0), whole(jobs, "jobs", least=1)
    arrangement = Arrangement.of(instance)
    poses = _poses(arrangement, seed, jobs)
    if certify and len(poses.R):
        from gspcli.certification import decide

        poses = poses.decided(*decide(instance, poses.R, poses.T))
    poses = poses.reordered(stable_order(poses, arrangement.length))
    return SolveResult(instance, arrangement, poses, seed)


def solve_values(
    instance: Instance, values: ArrayLike, *, seed: int = SEED, jobs: int = 1
) -> Iterator[PoseSet]:
    """Yield all poses of an instance for each of many sets of values, in order, uncertified.

    This is the quick way to many poses of one geometry: systems are solved in batches, and the
    results are arrays. The values of the instance itself are not used.

    Parameters
    ----------
    instance
        The geometry, units and sides.
    values
        Distances and angles in the units and order of the instance, shape (batch, 6).
    seed, jobs
        As for `solve`.

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
    solved = _solve_rows(instance, rows if all(right) else rows[right], seed, jobs)
    return (
        next(solved) if problem is None else PoseSet.unsolved(instance.expected, problem)
        for problem in problems
    )


def _solve_rows(instance: Instance, rows: Array, seed: int, jobs: int) -> Iterator[PoseSet]:
    arrangement = Arrangement.of(instance)
    if len(arrangement.angles) == MAX_ANGLES:
        from gspcli.solver.closed_form import solve_closed_forms

        return solve_closed_forms(arrangement, rows)
    from gspcli.solver.tracking import solve_each_by_tracking

    each = (arrangement.with_values(row) for row in rows)
    return solve_each_by_tracking(each, seed=seed, jobs=jobs)


def _poses(arrangement: Arrangement, seed: int, jobs: int) -> PoseSet:
    """Return the poses by the method for the class of the platform."""
    # Each method is imported when it is needed: start-up is most of the time of one solve.
    poses = None
    if len(arrangement.angles) == MAX_ANGLES:
        from gspcli.solver.closed_form import solve_closed_form

        poses = solve_closed_form(arrangement)
        if not poses.account.lost:
            return poses
    from gspcli.solver.tracking import solve_by_tracking

    # Paths may see through a special position that the closed form does not.
    tracked = solve_by_tracking(arrangement, seed=seed, jobs=jobs)
    return tracked if poses is None or tracked.account.lost < poses.account.lost else poses
