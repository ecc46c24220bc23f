"""The functions that solve any instance: once, or for many sets of values."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import chain, islice
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.types import MAX_ANGLES
from gspcli.certification.equations.local_frames import Centring
from gspcli.defaults import PATIENCE, SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.solver.arguments import problems_of, value_rows, whole
from gspcli.solver.batch import Block, PoseBatch, joined
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.problem import Problem
from gspcli.solver.result import SolveResult
from gspcli.solver.solved_starts import STARTS
from gspcli.solver.solving import solved

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.certification.poses.many_values import ValueProofs

Array = NDArray[np.float64]
Index = NDArray[np.intp]

#: So many answers of the closed form are put together.
_BLOCK = 64


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
        That is always done where it costs nothing to speak of, and in special position.
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
    centring = Centring.of(instance)
    # Far from the bodies doubles have few digits left for what is asked.
    near = instance if centring.is_none else centring.applied(instance)
    problem = Problem(near, seed=seed, jobs=jobs, certify=certify, prove=prove)
    poses = _solved(problem)
    if centring.is_none:
        return SolveResult(instance, problem.arrangement, poses, seed)
    return SolveResult(instance, Arrangement.of(instance), poses.taken_back(centring), seed)


def _solved(problem: Problem) -> PoseSet:
    """Return all poses of a platform near the origins, in order."""
    poses = solved(problem)
    if problem.limit != 0 and poses.account.verdict == "infinite":
        if not any(motion.real for motion in poses.motions):
            from gspcli.solver.real_statements import lone_real_poses

            found = lone_real_poses(problem.instance, lambda other: _solved(problem.like(other)))
            poses = replace(poses, motions=(*(found or ()), *poses.motions))
    return poses.in_order(problem.arrangement.length)


def solve_values(
    instance: Instance,
    values: ArrayLike,
    *,
    seed: int = SEED,
    jobs: int = 1,
    certify: bool = True,
) -> Iterator[PoseSet]:
    """Yield all poses of an instance for each of many sets of values, in order.

    This is the quick way to many poses of one geometry: it is solved once for complex values, and
    from there the values alone are moved. The values of the instance itself are not used.

    Parameters
    ----------
    instance
        The geometry, units and sides.
    values
        Distances and angles in the units and order of the instance, shape (batch, 6).
    seed, jobs
        As for `solve`.
    certify
        Whether to prove each pose, and whether it is real, and so that there are no others. That
        is always done where it costs nothing to speak of, and in special position.

    Raises
    ------
    ArgumentError
        If an argument is of another sort or shape. A set of values that is wrong (not a number,
        a negative distance) only spoils its own `PoseSet`, whose `problem` says so.
    """
    return chain.from_iterable(_blocks(instance, values, seed, jobs, certify=certify))


def solve_batch(
    instance: Instance,
    values: ArrayLike,
    *,
    seed: int = SEED,
    jobs: int = 1,
    certify: bool = True,
    progress: Iterable[object] = (),
) -> PoseBatch:
    """Return all poses of an instance for each of many sets of values, as arrays.

    What `solve_values` yields, without an object for each set: 6-6 platforms take 8 kB each.

    Parameters
    ----------
    instance, values, seed, jobs, certify
        As for `solve_values`.
    progress
        Consumed one item a set of values.

    Raises
    ------
    ArgumentError
        As for `solve_values`.
    """
    blocks, steps = [], iter(progress)
    for block in _blocks(instance, values, seed, jobs, certify=certify):
        blocks.append(block)
        deque(islice(steps, len(block)), maxlen=0)
    return joined(Arrangement.of(instance), value_rows(values), blocks)


def _blocks(
    instance: Instance, values: ArrayLike, seed: int, jobs: int, *, certify: bool
) -> Iterator[Block]:
    """Return the poses for each set of values, wrong ones included."""
    checked(instance)
    seed, jobs = whole(seed, "seed", least=0), whole(jobs, "jobs", least=1)
    rows = value_rows(values)
    wrong = {
        k: PoseSet.unsolved(instance.expected, problem)
        for k, problem in problems_of(instance, rows).items()
    }
    if wrong:
        # Any right values do in their place.
        right = np.delete(rows, list(wrong), axis=0)
        rows = rows.copy()
        rows[list(wrong)] = right[0] if len(right) else np.nan
    if len(wrong) == len(rows):
        return iter([Block.of(list(wrong.values()))] if wrong else [])
    centring = Centring.of(instance, _distances(instance, rows))
    near = centring.applied(instance)
    blocks = _solve_rows(near, rows, wrong, seed, jobs, certify=certify)
    return blocks if centring.is_none else (block.taken_back(centring) for block in blocks)


def _distances(instance: Instance, rows: Array) -> list[float]:
    """Return those of the set of values whose largest distance is the smallest."""
    distances = [i for i, c in enumerate(instance.constraints) if c.kind.is_distance]
    lengths = np.abs(rows[:, distances])
    return list(lengths[lengths.max(axis=1).argmin()])


def _solve_rows(
    instance: Instance,
    rows: Array,
    wrong: Mapping[int, PoseSet],
    seed: int,
    jobs: int,
    *,
    certify: bool,
) -> Iterator[Block]:
    """Yield the poses for each set of values; those of special platforms are proved."""
    arrangement = Arrangement.of(instance)
    begin = 0
    for block, special in _quick_blocks(instance, arrangement, rows, seed, jobs, certify=certify):
        others = dict(block.others)
        for k in special.tolist():
            row = rows[begin + k]
            given = instance.with_values({i: Number.of(x) for i, x in enumerate(row.tolist())})
            problem = Problem(
                given, arrangement.with_values(row), seed=seed, jobs=jobs, certify=certify
            )
            others[k] = wrong.get(begin + k) or _solved(problem)
        others |= {k - begin: wrong[k] for k in wrong if begin <= k < begin + len(block)}
        yield replace(block, others=others)
        begin += len(block)


def _quick_blocks(
    instance: Instance,
    arrangement: Arrangement,
    rows: Array,
    seed: int,
    jobs: int,
    *,
    certify: bool,
) -> Iterator[tuple[Block, Index]]:
    """Yield the poses for sets of values, and which of them are not found for certain."""
    if len(arrangement.angles) == MAX_ANGLES:
        yield from _closed_form_blocks(instance, arrangement, rows, certify=certify)
        return
    from gspcli.certification.poses.many_values import ValueProofs
    from gspcli.solver.row_groups import solve_rows

    def count() -> ExactCount | None:
        return STARTS.count(instance, seed, PATIENCE)

    def proofs(group: Array) -> ValueProofs | None:
        return ValueProofs.of(instance, group)

    for size, found in solve_rows(
        arrangement, rows, count=count, proofs=proofs, seed=seed, jobs=jobs
    ):
        if found is None or (found.proof is None and certify):
            yield Block.nothing(size), np.arange(size)
        else:
            poses = found.poses
            fields = poses.quaternions, poses.R, poses.T, poses.real
            yield Block(*fields, found.account, found.proof), np.flatnonzero(~poses.complete)


def _closed_form_blocks(
    instance: Instance, arrangement: Arrangement, rows: Array, *, certify: bool
) -> Iterator[tuple[Block, Index]]:
    """Yield the same for platforms with three angles."""
    from gspcli.certification.poses.many_values import ValueProofs
    from gspcli.solver.closed_form import solve_closed_forms
    from gspcli.solver.closed_form_proofs import block_of, prove_closed_forms

    proofs = ValueProofs.of(instance, rows) if certify else None
    solved = solve_closed_forms(arrangement, rows)
    for begin in range(0, len(rows), _BLOCK):
        part = list(islice(solved, _BLOCK))
        general = {k: poses for k, poses in enumerate(part) if poses is not None}
        given = rows[begin : begin + len(part)]
        proved = prove_closed_forms(proofs, arrangement, given, part) if proofs else None
        if proved is None:
            special = [k for k in range(len(part)) if certify or k not in general]
            yield replace(Block.nothing(len(part)), others=general), np.array(special, np.intp)
            continue
        where, poses = proved
        # What is not proved has a row of its own, in which anything may be.
        source = np.zeros(len(part), np.intp)
        source[where] = np.arange(len(where))
        done = np.zeros(len(part), np.bool_)
        done[where] = poses.complete
        others = {k: one for k, one in general.items() if not done[k]}
        yield replace(block_of(poses, source), others=others), np.flatnonzero(~done)
