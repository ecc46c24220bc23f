"""All poses for each of many sets of values: in groups, and one by one where some are missing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Instance
from gspcli.geometry.readings import problems_of, value_rows, values_of
from gspcli.solver.all_poses import all_poses, first_poses
from gspcli.solver.arguments import whole
from gspcli.solver.ledger import Ledger
from gspcli.solver.problem import Problem
from gspcli.solver.results.pose_batch import PoseBatch
from gspcli.solver.results.pose_set import PoseSet
from gspcli.solver.starts.solved_starts import SolvedStarts

Array = NDArray[np.float64]
Index = NDArray[np.intp]

#: This many sets of values are solved together in closed form.
_TOGETHER = 64


class Together(NamedTuple):
    """Sets of values that were solved together, by their indices, and the rows of their ledger."""

    rows: Index
    places: Index
    ledger: Ledger


class Answers(NamedTuple):
    """The poses for some sets of values, one after the other.

    Attributes
    ----------
    rows
        Their indices.
    together
        Those of which the first strategies have found all poses, in groups.
    alone
        The poses for each of the others.
    """

    rows: range
    together: list[Together]
    alone: Mapping[int, PoseSet]

    def poses(self) -> Iterator[PoseSet]:
        """Yield the poses for each set of values."""
        places = {
            k: (part.ledger, place)
            for part in self.together
            for k, place in zip(part.rows.tolist(), part.places.tolist(), strict=True)
        }
        for k in self.rows:
            if k in self.alone:
                yield self.alone[k]
            else:
                ledger, place = places[k]
                yield ledger.poses(place)


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
    from gspcli.solver.strategies.row_groups import groups_of

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
    ledger = first_poses(group.part(places))
    done = np.delete(np.arange(len(rows)), ledger.left)
    if not local_frames.is_none and ledger.proved is not None:
        back = local_frames.doubles_back(ledger.proved.R, ledger.proved.T)
        ledger.proved = ledger.proved._replace(T=back)
    return Together(rows[done], done, ledger)


def batch_of(arrangement: Arrangement, values: Array, answers: list[Answers]) -> PoseBatch:
    """Return answers, one after the other, as one batch (see its attributes)."""
    others = {k: poses for each in answers for k, poses in each.alone.items()}
    together = [part for each in answers for part in each.together if len(part.rows)]
    widths = [len(poses.R) for poses in others.values()] + [len(part.ledger) for part in together]
    shape = len(values), max(widths, default=0)
    batch = PoseBatch(
        arrangement=arrangement,
        values=values,
        number=np.zeros(len(values), np.int64),
        R=np.full((*shape, 3, 3), np.nan, np.complex128),
        T=np.full((*shape, 3), np.nan, np.complex128),
        real=np.zeros(shape, np.bool_),
        certified=np.zeros(shape, np.bool_),
        multiplicity=np.zeros(shape, np.int64),
        complete=np.zeros(len(values), np.bool_),
        proved=np.zeros(len(values), np.bool_),
        others=others,
    )
    for rows, places, ledger in together:
        found, width = ledger.proved, len(ledger)
        assert found is not None
        batch.R[rows, :width], batch.T[rows, :width] = found.R[places], found.T[places]
        batch.real[rows, :width] = found.real[places]
        batch.certified[rows, :width] = batch.multiplicity[rows, :width] = 1
        batch.number[rows] = width
        batch.complete[rows] = batch.proved[rows] = True
    for k, poses in others.items():
        number = len(poses.R)
        for name in ("R", "T", "real", "certified", "multiplicity"):
            getattr(batch, name)[k, :number] = getattr(poses, name)
        batch.number[k] = number
        batch.complete[k] = poses.problem is None and poses.account.verdict == "complete"
        batch.proved[k] = batch.complete[k] and poses.proof is not None
    return batch
