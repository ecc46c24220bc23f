"""Poses in arrays: what there is of each pose, whatever found it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from gspcli.records import EqualByContent, dataclass

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Bits = NDArray[np.bool_]


@dataclass(frozen=True, eq=False, kw_only=True)
class Poses(EqualByContent):
    """Poses; all arrays have the same leading axes (...), of which the last one counts poses."""

    #: Of the rotations, ``e.e = 1``, with the sign of `quaternion_from_rotation`, shape (..., 4),
    #: complex.
    quaternions: Complex
    #: Rotations (..., 3, 3) and translations (..., 3), complex; those of real poses are exactly
    #: real.
    R: Complex
    T: Complex
    #: Which of them are real, shape (...).
    real: Bits
    #: Which of them are proved to exist, to be simple, and to be real or not, shape (...).
    certified: Bits
    #: How many paths end at each, shape (...): 1 for certified ones, 0 where there is no pose.
    multiplicity: NDArray[np.int64]

    #: What there is one of for each pose.
    OF_POSES: ClassVar[tuple[str, ...]] = (
        "quaternions",
        "R",
        "T",
        "real",
        "certified",
        "multiplicity",
    )

    @staticmethod
    def none(*shape: int) -> dict[str, Any]:
        """Return the arrays of places for poses: numbers that are none, nothing certified."""
        return {
            "quaternions": np.full((*shape, 4), np.nan, np.complex128),
            "R": np.full((*shape, 3, 3), np.nan, np.complex128),
            "T": np.full((*shape, 3), np.nan, np.complex128),
            "real": np.zeros(shape, np.bool_),
            "certified": np.zeros(shape, np.bool_),
            "multiplicity": np.zeros(shape, np.int64),
        }

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return what there is one of for each pose, by name."""
        given = ((name, getattr(self, name)) for name in self.OF_POSES)
        return {name: array for name, array in given if array is not None}

    def __getitem__(self, index: Any) -> Self:
        """Return some of the poses, or all in another order."""
        return replace(self, **{name: array[index] for name, array in self.arrays().items()})

    def put(self, index: Any, others: Poses) -> None:
        """Put other poses in the place of some, in what both have of each."""
        for name in self.OF_POSES:
            if name in others.OF_POSES:
                getattr(self, name)[index] = getattr(others, name)

    @classmethod
    def together(cls, parts: Sequence[Self], axis: int = 0) -> Self:
        """Return the first with the poses of all parts, one after the other along an axis."""
        first = parts[0].arrays()
        names = [name for name in first if all(name in part.arrays() for part in parts)]
        joined: dict[str, Any] = dict.fromkeys(first)
        for name in names:
            joined[name] = np.concatenate([getattr(part, name) for part in parts], axis=axis)
        return replace(parts[0], **joined)


@dataclass(frozen=True, eq=False, kw_only=True)
class PoseProofs(Poses):
    """Poses near approximate ones, and what is proved of each."""

    #: For which certified ones the numbers are settled, shape (...): each number of a real one is
    #: proved to be rounded correctly (`correct_rounding`), those of others are within 2^-53 of the
    #: largest.
    rounded: Bits
    #: Bounds of the errors of certified ones in any entry of R, and of T by the scale; shape (...).
    deviation: Array

    OF_POSES: ClassVar[tuple[str, ...]] = (*Poses.OF_POSES, "rounded", "deviation")

    @property
    def conjugates(self) -> PoseProofs:
        """The conjugate poses, which are proved likewise, as equations are real."""
        # Zero has one sign.
        R, T, e = (array.conj() + 0.0 for array in (self.R, self.T, self.quaternions))
        return replace(self, R=R, T=T, quaternions=e)

    def entries(self, scale: float) -> Complex:
        """Return the entries of R, and of T in a unit of length, shape (..., 12)."""
        flat = self.R.reshape(*self.R.shape[:-2], 9)
        return np.concatenate((flat, self.T / scale), axis=-1)
