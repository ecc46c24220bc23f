"""Poses of many platforms of one geometry, as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.residuals import condition_numbers, proved_residuals, residuals
from gspcli.records import EqualByContent, dataclass
from gspcli.solver.results.pose_set import PoseSet

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


#: Poses that are measured together: enough that their number does not matter.
_BLOCK = 4096


@dataclass(frozen=True, eq=False)
class PoseBatch(EqualByContent):
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
        For which of them that is proved, for certain or up to a random prime, shape (b,).
    others
        The `PoseSet` of each set with special or wrong values, with account, motions and proof.
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
        there = np.nonzero(self.multiplicity)
        lengths = np.array([self.arrangement.length_with(row) for row in self.values])
        given = self.R[there], self.T[there], lengths[there[0]]
        result = np.full(self.real.shape, np.nan)
        result[there] = condition_numbers(self.arrangement, *given)
        return result
