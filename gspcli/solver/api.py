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
from gspcli.solver.result import SolveResult

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.certification.poses.many_values import ValueProofs
    from gspcli.continuation.pursuit import Pursuit

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
    arrangement = Arrangement.of(instance)
    centring = Centring.of(instance)
    if not centring.is_none:
        # Far from the bodies doubles have few digits left for what is asked.
        near = solve(centring.applied(instance), seed=seed, jobs=jobs, certify=certify, prove=prove)
        return SolveResult(instance, arrangement, near.poses.taken_back(centring), seed)
    poses = _solved(instance, arrangement, seed, jobs, certify=certify, prove=prove)
    return SolveResult(instance, arrangement, poses.in_order(arrangement.length), seed)


def _solved(
    instance: Instance,
    arrangement: Arrangement,
    seed: int,
    jobs: int,
    *,
    certify: bool,
    prove: bool | None,
) -> PoseSet:
    """Return all poses of an instance, in any order."""
    pursuits: list[Pursuit] | None = None
    proofs: ValueProofs | None = None
    # Each method is imported when it is needed: start-up is most of the time of one solve.
    if len(arrangement.angles) == MAX_ANGLES:
        poses: PoseSet | None = _in_closed_form(instance, arrangement, certify=certify)
    else:
        from gspcli.solver.direct import proofs_of, proved_directly

        proofs = proofs_of(instance, arrangement)
        poses = proved_directly(proofs, arrangement) if proofs else None
        if poses is None and proofs and prove is not False:
            from gspcli.solver.special_geometry import proved_by_geometry

            poses = proved_by_geometry(instance, proofs, arrangement, seed=seed, limit=PATIENCE)
        if poses is None and proofs:
            poses = _proved_shortly(arrangement, proofs, seed, jobs)
        if poses is None:
            from gspcli.solver import tracking

            _, pursuits = next(tracking.pursue_each([arrangement], seed=seed, jobs=jobs))
            regular = _all_regular(pursuits)
            # Proving all poses is cheaper than counting them because a few paths went wrong.
            if proofs:
                poses = tracking.proved_by_paths(proofs, arrangement, pursuits)
            if poses is None and regular:
                poses = tracking.poses_by_paths(arrangement, pursuits)
    if poses is not None and certify and len(poses.R) and poses.proof is None:
        poses = _proved(instance, poses)
    if poses is None or not _is_general(poses, certify):
        limit = {True: None, False: 0.0, None: PATIENCE}[prove]
        poses = _special(instance, arrangement, pursuits, seed, jobs, limit, proofs)
    return poses


def _in_closed_form(
    instance: Instance, arrangement: Arrangement, *, certify: bool
) -> PoseSet | None:
    """Return the poses of a platform with three angles, proved as far as doubles prove them.

    None if it is not in general position.
    """
    from gspcli.solver.closed_form import solve_closed_form

    if not certify:
        return solve_closed_form(arrangement)
    from gspcli.certification.poses.many_values import ValueProofs
    from gspcli.solver.closed_form_proofs import proved_closed_form, proved_general_form

    proofs = ValueProofs.of(instance, None)
    poses = proved_general_form(proofs, arrangement) if proofs else None
    return poses or proved_closed_form(proofs, arrangement, solve_closed_form(arrangement))


def _proved_shortly(
    arrangement: Arrangement,
    proofs: ValueProofs,
    seed: int,
    jobs: int,
) -> PoseSet | None:
    """Return as many poses as the type has, all proved, by paths of short series.

    None if they do not lead to them, or if those are not the quickest there are.
    """
    from gspcli.solver import tracking

    for pursuits in tracking.short_pursuits(arrangement, seed=seed, jobs=jobs):
        poses = tracking.proved_by_paths(proofs, arrangement, pursuits)
        if poses is not None:
            return poses
    return None


def _all_regular(pursuits: Iterable[Pursuit]) -> bool:
    return all(pursuit.is_regular for pursuit in pursuits)


def _special(
    instance: Instance,
    arrangement: Arrangement,
    pursuits: list[Pursuit] | None,
    seed: int,
    jobs: int,
    limit: float | None,
    proofs: ValueProofs | None = None,
) -> PoseSet:
    """Return the poses of a platform that is not in general position."""
    from gspcli.solver.special import solve_special

    if pursuits is None:
        from gspcli.solver.tracking import pursue_each

        _, pursuits = next(pursue_each([arrangement], seed=seed, jobs=jobs))
    poses = solve_special(instance, arrangement, pursuits, proofs, seed=seed, limit=limit)
    if limit == 0 or poses.account.verdict != "infinite" or any(m.real for m in poses.motions):
        return poses
    from gspcli.solver.real_statements import lone_real_poses

    found = lone_real_poses(instance, lambda other: solve(other, seed=seed, jobs=jobs).poses)
    return replace(poses, motions=(*(found or ()), *poses.motions))


def _proved(instance: Instance, poses: PoseSet) -> PoseSet:
    """Return poses with certificates, and with a proof if they are as many as the type has."""
    from gspcli.certification import decide

    poses = poses.decided(decide(instance, poses.R, poses.T))
    return replace(poses, proof=poses.proof_by_type or poses.proof)


def _is_general(poses: PoseSet, certify: bool) -> bool:
    """Whether there are as many distinct simple poses as the type has, as asked proved or not."""
    if certify:
        return poses.proof is not None
    return int((poses.multiplicity == 1).sum()) == poses.account.expected


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
            others[k] = wrong.get(begin + k) or _solved(
                given, arrangement.with_values(row), seed, jobs, certify=certify, prove=None
            )
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
        from gspcli.solver.special_geometry import kept_count

        return kept_count(instance, seed, PATIENCE)

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
