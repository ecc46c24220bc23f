"""Poses of many platforms of one geometry, as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.continuation.paths import PathAccount
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.residuals import condition_numbers, proved_residuals, residuals
from gspcli.records import dataclass
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.proof import Proof

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Block:
    """Sets of values that all have the same number of certified poses, or another answer.

    Attributes
    ----------
    quaternions, R, T, real
        Shapes (b, n, 4), (b, n, 3, 3), (b, n, 3) and (b, n); see `PoseSet`.
    account, proof
        Of each set.
    others
        The sets that have another answer; their rows in the arrays have no meaning.
    """

    quaternions: Complex
    R: Complex
    T: Complex
    real: NDArray[np.bool_]
    account: PathAccount
    proof: Proof | None
    others: Mapping[int, PoseSet] = field(default_factory=dict)

    @classmethod
    def nothing(cls, size: int) -> Block:
        """Return a block of so many sets of values, each of which is to get its own answer."""
        empty = np.zeros((size, 0), np.complex128)
        return cls(
            quaternions=empty.reshape(size, 0, 4),
            R=empty.reshape(size, 0, 3, 3),
            T=empty.reshape(size, 0, 3),
            real=np.zeros((size, 0), np.bool_),
            account=PathAccount(expected=0),
            proof=None,
        )

    @classmethod
    def of(cls, answers: Sequence[PoseSet]) -> Block:
        """Return a block of sets of values with these answers."""
        return replace(cls.nothing(len(answers)), others=dict(enumerate(answers)))

    def __len__(self) -> int:
        return len(self.R)

    @cached_property
    def _ones(self) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        number = self.real.shape[1]
        return np.ones(number, np.bool_), np.ones(number, np.int64)

    def pose_set(self, k: int) -> PoseSet:
        """Return the answer for one set of values; its arrays are parts of those here."""
        other = self.others.get(k)
        if other is not None:
            return other
        certified, once = self._ones
        return PoseSet(
            quaternions=self.quaternions[k],
            R=self.R[k],
            T=self.T[k],
            real=self.real[k],
            certified=certified,
            multiplicity=once,
            motions=(),
            account=self.account,
            proof=self.proof,
        )

    def __iter__(self) -> Iterator[PoseSet]:
        return map(self.pose_set, range(len(self)))

    def taken_back(self, local_frames: LocalFrames) -> Block:
        """Return poses that were found near the bodies in the frames of the instance."""
        others = {k: poses.taken_back(local_frames) for k, poses in self.others.items()}
        return replace(self, T=local_frames.doubles_back(self.R, self.T), others=others)


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


def joined(arrangement: Arrangement, values: Array, blocks: list[Block]) -> PoseBatch:
    """Return blocks, one after the other, as one batch (see its attributes)."""
    others: dict[int, PoseSet] = {}
    begin, widths = 0, [0]
    for block in blocks:
        others |= {begin + k: poses for k, poses in block.others.items()}
        widths += [len(poses.R) for poses in block.others.values()]
        widths.append(block.real.shape[1] if len(block.others) < len(block) else 0)
        begin += len(block)
    shape = begin, max(widths)
    batch = PoseBatch(
        arrangement=arrangement,
        values=values,
        number=np.zeros(begin, np.int64),
        R=np.full((*shape, 3, 3), np.nan, np.complex128),
        T=np.full((*shape, 3), np.nan, np.complex128),
        real=np.zeros(shape, np.bool_),
        certified=np.zeros(shape, np.bool_),
        multiplicity=np.zeros(shape, np.int64),
        complete=np.zeros(begin, np.bool_),
        proved=np.zeros(begin, np.bool_),
        others=others,
    )
    begin = 0
    for block in blocks:
        rows, width = slice(begin, begin + len(block)), block.real.shape[1]
        if len(block.others) < len(block):
            batch.R[rows, :width], batch.T[rows, :width] = block.R, block.T
            batch.real[rows, :width] = block.real
            batch.certified[rows, :width] = batch.multiplicity[rows, :width] = 1
            batch.number[rows] = width
            batch.complete[rows] = True
            batch.proved[rows] = block.proof is not None
        for k, poses in block.others.items():
            _enter(batch, begin + k, poses)
        begin += len(block)
    return batch


def _enter(batch: PoseBatch, k: int, poses: PoseSet) -> None:
    """Write one answer into its row."""
    number = len(poses.R)
    rest: dict[str, Any] = {"R": np.nan, "T": np.nan, "real": 0, "certified": 0, "multiplicity": 0}
    for name, nothing in rest.items():
        part = getattr(batch, name)
        part[k, :number], part[k, number:] = getattr(poses, name), nothing
    batch.number[k] = number
    batch.complete[k] = poses.problem is None and poses.account.verdict == "complete"
    batch.proved[k] = batch.complete[k] and poses.proof is not None
