"""The functions that solve any instance, once or for many sets of values, and certify poses."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from itertools import chain, islice
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from gspcli.defaults import MAX_PRECISION, SEED, TOLERANCE
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Instance
from gspcli.geometry.readings import value_rows, values_of
from gspcli.solver.all_poses import all_poses
from gspcli.solver.arguments import whole
from gspcli.solver.many_poses import batch_of, many_poses
from gspcli.solver.problem import Problem
from gspcli.solver.result import SolveResult
from gspcli.solver.results.pose_batch import PoseBatch
from gspcli.solver.results.pose_set import PoseSet
from gspcli.solver.starts.solved_starts import STARTS, SolvedStarts

if TYPE_CHECKING:
    from gspcli.certification import Certificates
    from gspcli.geometry.quaternions import Field


def solve(
    instance: Instance,
    *,
    seed: int = SEED,
    jobs: int = 1,
    prove: bool | None = None,
    starts: SolvedStarts = STARTS,
) -> SolveResult:
    """Return all poses of an instance, proved, with an account of every path.

    Platforms with three angles are solved in closed form (Algorithm 6.6), all others by
    tracking paths. If that gives fewer distinct simple poses than the type has, the platform is in
    special or nearly special position. Then its poses are counted exactly, modulo a random prime,
    and located with as many digits as they need.

    Parameters
    ----------
    instance
        The platform, whose numbers are meant exactly as written; the sides of its DPH
        and DHP distances say which solutions are asked for.
    seed
        Source of random choices. Another seed gives the same poses in the same order.
    jobs
        Threads for path tracking. The answer does not depend on them.
    prove
        Whether to count the poses of a special platform however long it takes (True), not at
        all (False), or if it takes no longer than `PATIENCE` (None). Without a count only
        as many certified poses as the type has prove that there are no others. If True, a
        second random prime confirms a count.
    starts
        What is kept of solved platforms: nothing but time depends on it. By default that of the
        process.

    Raises
    ------
    ArgumentError
        If an argument is wrong: not an instance, not six constraints, a value out of range.

    Examples
    --------
    >>> import gspcli
    >>> found = gspcli.solve(gspcli.example("octahedral-3-3"))
    >>> found.verdict, found.counts.real, found.counts.found
    ('complete', 4, 16)
    >>> found.real_solutions[0].R.shape
    (3, 3)
    """
    checked(instance)
    seed, jobs = whole(seed, "seed", least=0), whole(jobs, "jobs", least=1)
    problem = Problem(instance, seed=seed, jobs=jobs, prove=prove, starts=starts)
    local_frames = problem.local_frames
    if local_frames.is_none:
        return SolveResult(instance, problem.arrangement, _ordered(problem), seed)
    # Far from the bodies doubles have few digits left for what is asked.
    poses = _ordered(problem.like(local_frames.applied(instance))).taken_back(local_frames)
    return SolveResult(instance, problem.arrangement, poses, seed)


def _ordered(problem: Problem) -> PoseSet:
    poses = all_poses(problem)
    if problem.limit is None:
        from gspcli.solver.special.by_count import confirmed

        poses = confirmed(problem, poses)
    return poses.in_order(problem.arrangement.length)


def solve_values(
    instance: Instance,
    values: ArrayLike,
    *,
    seed: int = SEED,
    jobs: int = 1,
    starts: SolvedStarts = STARTS,
) -> Iterator[PoseSet]:
    """Yield all poses of an instance for each of many sets of values, in order.

    This is the quick way to many poses of one geometry: it is solved once for complex values, and
    from there the values alone are moved. The values of the instance itself are not used.

    Parameters
    ----------
    instance
        The geometry, units and sides.
    values
        Distances and angles in the units and order of the instance, shape (batch, 6); offsets are
        added to them. Doubles are meant exactly, as fractions.
    seed, jobs, starts
        As for `solve`.

    Raises
    ------
    ArgumentError
        If an argument is of another sort or shape. A set of values that is wrong (not a number,
        a negative distance) only spoils its own `PoseSet`, whose `problem` says so.
    """
    answers = many_poses(instance, values, seed=seed, jobs=jobs, starts=starts)
    return chain.from_iterable(each.poses() for each in answers)


def solve_batch(
    instance: Instance,
    values: ArrayLike,
    *,
    seed: int = SEED,
    jobs: int = 1,
    starts: SolvedStarts = STARTS,
    progress: Iterable[object] = (),
) -> PoseBatch:
    """Return all poses of an instance for each of many sets of values, as arrays.

    What `solve_values` yields, without an object for each set: 6-6 platforms take 8 kB each.

    Parameters
    ----------
    instance, values, seed, jobs, starts
        As for `solve_values`.
    progress
        Consumed one item a set of values.

    Raises
    ------
    ArgumentError
        As for `solve_values`.
    """
    answers, steps = [], iter(progress)
    for each in many_poses(instance, values, seed=seed, jobs=jobs, starts=starts):
        answers.append(each)
        deque(islice(steps, len(each.rows)), maxlen=0)
    rows = values_of(instance, value_rows(values), signed=False)
    return batch_of(Arrangement.of(instance), rows, answers)


def certify(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    sides: ArrayLike | None = None,
    tolerance: float = TOLERANCE,
    max_precision: int = MAX_PRECISION,
) -> Certificates:
    """Prove what can be proved about approximate solutions of an instance.

    Parameters, result and errors are those of `gspcli.certification.certify`. The platform is
    solved only for candidates that the equations leave open, and at which the lines of a DLL may be
    parallel. That such a candidate is certified rests on the proof of that solution, which may be
    modulo a random prime (`SolveResult.proof`).
    """
    from gspcli import certification

    return certification.certify(
        instance,
        R,
        T,
        sides=sides,
        tolerance=tolerance,
        max_precision=max_precision,
        solve=_proved,
    )


def _proved(instance: Instance) -> tuple[Field, Field] | None:
    """Return the certified poses of a platform, None if it is not proved that they are all."""
    result = solve(instance)
    if result.verdict != "complete" or result.proof is None:
        return None
    return result.R[result.certified], result.T[result.certified]
