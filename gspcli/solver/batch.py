"""Poses of many platforms of one geometry, as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.residuals import condition_numbers, proved_residuals, residuals
from gspcli.records import dataclass
from gspcli.solver.many_poses import Answers
from gspcli.solver.pose_set import PoseSet

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


#: Poses that are measured together: enough that their number does not matter.
_BLOCK = 4096


@dataclass(frozen=True, eq=False)
class PoseBatch:
    """All poses for each of b sets of values; rows are filled up to the longest with NaN.

    Attributes
    ----------
    arrangement, values
        The geometry, and the sets of values with the offsets of the instance added, shape (b, 6).
    number
        How many distinct poses each set has, shape (b,).
    R, T
        Rotations (b, n, 3, 3) and translations (b, n, 3), complex, in the frames and units of the
        instance; those of real poses are exactly real.
    real, certified
        Which are real, and which are proved; false where there is no pose; shape (b, n).
    multiplicity
        Of each pose, 0 where there is none, shape (b, n).
    complete
        For which sets the poses are all that there are: the account of paths adds up to the
        verdict ``complete``; shape (b,).
    proved
        For which of them that is proved, shape (b,).
    others
        The `PoseSet` of each set whose values are special (or wrong): its account, motions and
        proof say what is the matter.
    """

    arrangement: Arrangement
    values: Array
    number: NDArray[np.int64]
    R: Complex
    T: Complex
    real: NDArray[np.bool_]
    certified: NDArray[np.bool_]
    multiplicity: NDArray[np.int64]
    complete: NDArray[np.bool_]
    proved: NDArray[np.bool_]
    others: Mapping[int, PoseSet]

    def __len__(self) -> int:
        return len(self.number)

    def __repr__(self) -> str:
        parts = f"{len(self)} sets of values, {int(self.real.sum())} real poses"
        missing = f"{int((~self.complete).sum())} incomplete"
        return f"<PoseBatch: {parts}, {int(self.proved.sum())} proved complete, {missing}>"

    @cached_property
    def _there(self) -> tuple[NDArray[np.intp], ...]:
        return np.nonzero(self.multiplicity)

    @cached_property
    def residuals(self) -> Array:
        """The largest residual of a constraint at each pose, NaN where there is none, (b, n)."""
        result = np.full(self.real.shape, np.nan)
        for measure, chosen in ((proved_residuals, True), (residuals, False)):
            there = np.nonzero((self.multiplicity > 0) & (self.certified == chosen))
            # In blocks: what lies between takes some hundred numbers a pose.
            for begin in range(0, len(there[0]), _BLOCK):
                at = tuple(index[begin : begin + _BLOCK] for index in there)
                given = self.arrangement.with_values(self.values[at[0]])
                result[at] = measure(given, self.R[at], self.T[at]).max(axis=1)
        return result

    @cached_property
    def conditions(self) -> Array:
        """The condition number of each pose, NaN where there is none, shape (b, n)."""
        there = self._there
        lengths = np.array([self.arrangement.length_with(row) for row in self.values])
        given = self.R[there], self.T[there], lengths[there[0]]
        return self._filled(condition_numbers(self.arrangement, *given))

    def _filled(self, numbers: Array) -> Array:
        result = np.full(self.real.shape, np.nan)
        result[self._there] = numbers
        return result


def joined(arrangement: Arrangement, values: Array, answers: list[Answers]) -> PoseBatch:
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
