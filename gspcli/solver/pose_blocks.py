"""Many sets of values of one geometry in blocks: together where that proves all, else singly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Instance
from gspcli.geometry.readings import values_of
from gspcli.solver.all_poses import all_poses
from gspcli.solver.arguments import problems_of, value_rows, whole
from gspcli.solver.batch import Block
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.problem import Problem
from gspcli.solver.solved_starts import SolvedStarts

Array = NDArray[np.float64]
Index = NDArray[np.intp]

#: So many answers of the closed form are put together.
_BLOCK = 64


def pose_blocks(
    instance: Instance,
    values: ArrayLike,
    *,
    seed: int,
    jobs: int,
    starts: SolvedStarts,
) -> Iterator[Block]:
    """Return the poses for each set of values, wrong ones included.

    Parameters and errors are those of `gspcli.solve_values`.
    """
    checked(instance)
    seed, jobs = whole(seed, "seed", least=0), whole(jobs, "jobs", least=1)
    rows = values_of(instance, value_rows(values), signed=False)
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
    local_frames = LocalFrames.of(instance, _distances(instance, rows))
    near = local_frames.applied(instance)
    problem = Problem(near, seed=seed, jobs=jobs, starts=starts)
    blocks = _solve_rows(problem, rows, wrong)
    return blocks if local_frames.is_none else (block.taken_back(local_frames) for block in blocks)


def _distances(instance: Instance, rows: Array) -> list[float]:
    """Return those of the set of values whose largest distance is the smallest."""
    distances = [i for i, c in enumerate(instance.constraints) if c.kind.is_distance]
    lengths = np.abs(rows[:, distances])
    return list(lengths[lengths.max(axis=1).argmin()])


def _solve_rows(problem: Problem, rows: Array, wrong: Mapping[int, PoseSet]) -> Iterator[Block]:
    """Yield the poses for each set of values; those of special platforms are proved."""
    begin = 0
    quick_blocks = _closed_form_blocks if problem.has_closed_form else _geometry_blocks
    for block, special in quick_blocks(problem, rows):
        others = dict(block.others)
        for k in special.tolist():
            if begin + k not in wrong:
                one = problem.with_values(rows[begin + k])
                others[k] = all_poses(one).in_order(one.arrangement.length)
        others |= {k - begin: wrong[k] for k in wrong if begin <= k < begin + len(block)}
        yield replace(block, others=others)
        begin += len(block)


def _geometry_blocks(problem: Problem, rows: Array) -> Iterator[tuple[Block, Index]]:
    """Yield the poses for sets of values, and which of them are not found for certain."""
    from gspcli.certification.poses.many_values import ValueProofs
    from gspcli.solver.kept_geometry import kept_among
    from gspcli.solver.row_groups import solve_rows

    for size, found in solve_rows(
        problem.arrangement,
        rows,
        count=problem.count_geometry,
        proofs=partial(ValueProofs.of, problem.instance),
        seed=problem.seed,
        jobs=problem.jobs,
        starts=problem.starts,
        kept=partial(kept_among, problem, all_poses),
    ):
        if found is None or found.proof is None:
            yield Block.nothing(size), np.arange(size)
        else:
            poses = found.poses
            fields = poses.quaternions, poses.R, poses.T, poses.real
            yield Block(*fields, found.account, found.proof), np.flatnonzero(~poses.complete)


def _closed_form_blocks(problem: Problem, rows: Array) -> Iterator[tuple[Block, Index]]:
    """Yield the same for platforms with three angles."""
    from gspcli.certification.poses.many_values import ValueProofs
    from gspcli.solver.closed_form import solve_closed_forms
    from gspcli.solver.closed_form_proofs import block_of, prove_closed_forms

    arrangement, proofs = problem.arrangement, ValueProofs.of(problem.instance, rows)
    solved = solve_closed_forms(arrangement, rows)
    for begin in range(0, len(rows), _BLOCK):
        part = list(islice(solved, _BLOCK))
        given = rows[begin : begin + len(part)]
        proved = prove_closed_forms(proofs, arrangement, given, part) if proofs else None
        if proved is None:
            yield Block.nothing(len(part)), np.arange(len(part))
            continue
        where, poses = proved
        # What is not proved has a row of its own, in which anything may be.
        source = np.zeros(len(part), np.intp)
        source[where] = np.arange(len(where))
        done = np.zeros(len(part), np.bool_)
        done[where] = poses.complete
        yield block_of(poses, source), np.flatnonzero(~done)
