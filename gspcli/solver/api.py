"""The functions that solve any instance, once or for many sets of values, and certify poses."""

from __future__ import annotations

import operator
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import chain, islice
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.defaults import MAX_PRECISION, SEED, TOLERANCE
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Instance
from gspcli.geometry.readings import problems_of, value_rows, values_of
from gspcli.solver.all_poses import all_poses, first_poses
from gspcli.solver.kept_geometry import kept_among
from gspcli.solver.poses import PoseBatch, PoseSet
from gspcli.solver.problem import Problem
from gspcli.solver.result import SolveResult
from gspcli.solver.search import Search
from gspcli.solver.solved_starts import STARTS, SolvedStarts
from gspcli.solver.start import Start, start_among
from gspcli.wording import shortened

if TYPE_CHECKING:
    from gspcli.certification import Certificates
    from gspcli.geometry.quaternions import Field


def whole(value: Any, where: str, *, least: int) -> int:
    """Return an argument that is a whole number.

    Raises
    ------
    ArgumentError
        If it is none, or below the least one.
    """
    try:
        number = operator.index(value)
    except TypeError:
        number = least - 1
    if number < least or isinstance(value, bool):
        raise ArgumentError(
            f"found {shortened(repr(value))}, expected a whole number of at least {least}", where
        )
    return number


Array = NDArray[np.float64]
Index = NDArray[np.intp]

#: Fewer sets of values are solved one by one: solving the geometry costs as much as a few of them.
_LEAST = 4
#: Sets of values whose largest distances are within such a factor have one start. Sets up to the
#: extent of the geometry are alike.
_FACTOR = 8
#: From this many times the extent on the rotations are so far from real ones, as the square of
#: that, that doubles prove hardly any pose: each set is solved alone, with more digits.
_FAR = 512


def groups_of(
    problem: Problem, rows: Array, solve: Callable[[Problem], PoseSet]
) -> Iterator[tuple[Index, Problem]]:
    """Yield sets of values that can be solved together: their indices, and their platform.

    Sets in which other distances are zero may have another equation. Sets that are much larger than
    the others have another unit of length and a start of their own: with a common start the paths
    to the other sets would be long, and doubles would not separate their ends.

    Parameters
    ----------
    problem
        The platform; its own values are not used.
    rows
        Sets of values in the units of the instance, shape (b, 6).
    solve
        Returns all poses of a platform.
    """
    sizes = None if problem.has_closed_form else _sizes(problem.arrangement, rows)
    zero = [(row == 0).tobytes() for row in rows] if (rows == 0).any() else [b""] * len(rows)
    groups: dict[tuple[bytes, int], list[int]] = {}
    for k, pattern in enumerate(zero):
        groups.setdefault((pattern, 0 if sizes is None else int(sizes[k])), []).append(k)
    for (_, size), members in groups.items():
        if sizes is not None and (len(members) < _LEAST or _FACTOR**size >= _FAR):
            continue
        group = problem.with_rows(rows[members])
        if group.proofs is None:
            continue
        if sizes is not None:
            group.start = common_start(group, solve)
            if group.start is None or group.start.proof is None:
                continue
            if group.start.found < group.expected:
                group.count_geometry()
        yield np.array(members, np.intp), group


def common_start(problem: Problem, solve: Callable[[Problem], PoseSet]) -> Start | None:
    """Return a start for sets of values of one size; None if none is safe."""
    among = problem.arrangement, problem.values, problem.count_geometry
    return (
        kept_among(problem, solve, begin=False)
        or start_among(*among, problem.seed, problem.jobs, problem.starts)
        or kept_among(problem, solve, begin=True)
    )


def _sizes(arrangement: Arrangement, rows: Array) -> NDArray[np.int64]:
    """Return how large each set of values is: powers of `_FACTOR` times the extent, shape (b,)."""
    largest = np.abs(rows[:, arrangement.distances]).max(axis=1)
    # Of a geometry without extent only multiples of its values have a meaning.
    unit = arrangement.extent or float(np.median(largest)) or 1.0
    powers = np.floor(np.log(np.maximum(largest / unit, 1)) / np.log(_FACTOR))
    return np.asarray(powers, np.int64)


#: This many sets of values are solved together in closed form.
_TOGETHER = 64


class Together(NamedTuple):
    """Sets of values that were solved together, by their indices, and the rows of their search."""

    rows: Index
    places: Index
    search: Search


class Answers(NamedTuple):
    """The poses for some sets of values, one after the other."""

    #: Their indices.
    rows: range
    #: Those of which the first strategies have found all poses, in groups.
    together: list[Together]
    #: The poses for each of the others.
    alone: Mapping[int, PoseSet]

    def poses(self) -> Iterator[PoseSet]:
        """Yield the poses for each set of values."""
        places = {
            k: (part.search, place)
            for part in self.together
            for k, place in zip(part.rows.tolist(), part.places.tolist(), strict=True)
        }
        for k in self.rows:
            if k in self.alone:
                yield self.alone[k]
            else:
                search, place = places[k]
                yield search.poses(place)


def many_poses(
    instance: Instance, values: ArrayLike, *, seed: int, jobs: int, starts: SolvedStarts
) -> Iterator[Answers]:
    """Yield the poses for each set of values, wrong ones included.

    Parameters and errors are those of `gspcli.solve_values`.
    """
    checked(instance)
    seed, jobs = whole(seed, "seed", least=0), whole(jobs, "jobs", least=1)
    rows = values_of(instance, value_rows(values), signed=False)
    wrong = {
        k: PoseSet.unsolved(instance.expected, problem)
        for k, problem in problems_of(instance, rows).items()
    }
    if len(wrong) == len(rows):
        return iter([Answers(range(len(rows)), [], wrong)])
    right = np.delete(np.arange(len(rows)), list(wrong))
    local_frames = LocalFrames.of(instance, _distances(instance, rows[right]))
    near = local_frames.applied(instance)
    problem = Problem(near, seed=seed, jobs=jobs, starts=starts)
    return _solved(problem, rows, right, wrong, local_frames)


def _distances(instance: Instance, rows: Array) -> list[float]:
    """Return those of the set of values whose largest distance is the smallest."""
    distances = [i for i, c in enumerate(instance.constraints) if c.kind.is_distance]
    lengths = np.abs(rows[:, distances])
    return list(lengths[lengths.max(axis=1).argmin()])


def _solved(
    problem: Problem,
    rows: Array,
    right: Index,
    wrong: Mapping[int, PoseSet],
    local_frames: LocalFrames,
) -> Iterator[Answers]:
    """Yield the poses for sets of values, of which some are right."""
    groups: list[Problem] = []
    #: Of each set of values the group, none if it is -1, and its place there.
    which, place = np.full(len(rows), -1), np.zeros(len(rows), np.intp)
    for members, group in groups_of(problem, rows[right], all_poses):
        which[right[members]], place[right[members]] = len(groups), np.arange(len(members))
        groups.append(group)
    batches = [group.start.batch if group.start else _TOGETHER for group in groups]
    step = min(batches, default=1)
    for begin in range(0, len(rows), step):
        chosen = range(begin, min(begin + step, len(rows)))
        index, alone = np.arange(chosen.start, chosen.stop), {}
        together = []
        for k, group in enumerate(groups):
            here = index[which[index] == k]
            if len(here):
                together.append(_first(group, here, place[here], local_frames))
        left = set(index.tolist()).difference(*(part.rows.tolist() for part in together))
        for k in sorted(left):
            if k in wrong:
                alone[k] = wrong[k]
            else:
                one = problem.with_values(rows[k])
                poses = all_poses(one).in_order(one.arrangement.length)
                alone[k] = poses if local_frames.is_none else poses.taken_back(local_frames)
        yield Answers(chosen, together, alone)


def _first(group: Problem, rows: Index, places: Index, local_frames: LocalFrames) -> Together:
    """Return those sets of values of a group of which the first strategies find all poses."""
    search = first_poses(group.part(places))
    done = np.delete(np.arange(len(rows)), search.left)
    if not local_frames.is_none and search.proved is not None:
        back = local_frames.doubles_back(search.proved.R, search.proved.T)
        search.proved = replace(search.proved, T=back)
    return Together(rows[done], done, search)


def batch_of(arrangement: Arrangement, values: Array, answers: list[Answers]) -> PoseBatch:
    """Return answers, one after the other, as one batch (see its attributes)."""
    others = {k: poses for each in answers for k, poses in each.alone.items()}
    together = [part for each in answers for part in each.together if len(part.rows)]
    widths = [len(poses.R) for poses in others.values()] + [len(part.search) for part in together]
    shape = len(values), max(widths, default=0)
    batch = PoseBatch(
        **PoseBatch.none(*shape),
        arrangement=arrangement,
        values=values,
        number=np.zeros(len(values), np.int64),
        complete=np.zeros(len(values), np.bool_),
        proved=np.zeros(len(values), np.bool_),
        others=others,
    )
    for rows, places, search in together:
        assert search.proved is not None
        batch.put((rows, slice(len(search))), search.proved[places])
        batch.number[rows] = len(search)
        batch.complete[rows] = batch.proved[rows] = True
    for k, poses in others.items():
        batch.number[k] = number = len(poses.R)
        batch.put((k, slice(number)), poses)
        batch.complete[k] = poses.problem is None and poses.account.verdict == "complete"
        batch.proved[k] = batch.complete[k] and poses.proof is not None
    return batch


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
        poses = _ordered(problem)
    else:
        # Far from the bodies doubles have few digits left for what is asked.
        poses = _ordered(problem.like(local_frames.applied(instance))).taken_back(local_frames)
    return SolveResult(**vars(poses), instance=instance, arrangement=problem.arrangement, seed=seed)


def _ordered(problem: Problem) -> PoseSet:
    poses = all_poses(problem)
    if problem.limit is None:
        from gspcli.solver.by_count import confirmed

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

    What `solve_values` yields, without an object for each set: 6-6 platforms take 11 kB each.

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
        instance, R, T, sides=sides, tolerance=tolerance, max_precision=max_precision, solve=_proved
    )


def _proved(instance: Instance) -> tuple[Field, Field] | None:
    """Return the certified poses of a platform, None if it is not proved that they are all."""
    result = solve(instance)
    if result.verdict != "complete" or result.proof is None:
        return None
    return result.R[result.certified], result.T[result.certified]
