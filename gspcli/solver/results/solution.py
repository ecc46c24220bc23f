"""One pose that was found, and how many there are of which sort."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gspcli.geometry.limits import LeftLimit
from gspcli.geometry.printed_numbers import printed_condition, printed_residual
from gspcli.geometry.quaternions import Field
from gspcli.records import EqualByContent, dataclass


@dataclass(frozen=True)
class Counts:
    """How many poses of which sort.

    Attributes
    ----------
    found
        Distinct finite isolated solutions.
    real, certified, singular
        How many of those are real, are certified, have a multiplicity above one.
    """

    found: int
    real: int
    certified: int
    singular: int


@dataclass(frozen=True, eq=False)
class Solution(EqualByContent):
    """One pose.

    Attributes
    ----------
    number
        From 1 in the order of the result, as `gsp solve` and its CSV have it.
    real, certified
        Whether the pose is real, and whether that and its existence are proved.
    multiplicity
        How many paths end at it.
    R, T
        Rotation (3, 3) and translation (3,), complex for a pose that is not real.
    quaternion
        Of the rotation, scalar first, ``e.e = 1``, shape (4,).
    residual
        The largest difference between what a constraint measures and its value, in the units
        of the instance (lengths and angles alike).
    condition
        Condition number of the pose (`gspcli.geometry.residuals.condition_numbers`).
    sides
        For each DPH and DHP constraint, by its number from 1: ``positive`` or ``negative``.
        Without those at a height of zero, or whose sign neither doubles nor a proof tells.
    limits
        The ranges and cones that the pose does not keep; None if it is not real, or the instance
        has none.
    home
        Whether it is the home mode (`gspcli.geometry.home_mode`).
    """

    number: int
    real: bool
    certified: bool
    multiplicity: int
    R: Field
    T: Field
    quaternion: Field
    residual: float
    condition: float
    sides: Mapping[int, str]
    limits: tuple[LeftLimit, ...] | None = None
    home: bool = False

    def __repr__(self) -> str:
        sort = ("real" if self.real else "complex") + ", certified" * self.certified
        size = f"residual {self.residual:.1e}, condition {self.condition:.4g}"
        return f"<Solution: {sort}, {size}, T {np.array2string(self.T, precision=6)}>"

    def to_json(self, length: float = 0.0) -> dict[str, Any]:
        """Return the pose as plain data (see `SolveResult.to_json`).

        Parameters
        ----------
        length
            Of the platform: the residual is written up to the rounding errors of this length.
        """
        document: dict[str, Any] = {
            "number": self.number,
            "real": self.real,
            "certified": self.certified,
            "home": self.home,
            "multiplicity": self.multiplicity,
            "R": self.R.real.tolist(),
            "T": self.T.real.tolist(),
            "quaternion": self.quaternion.real.tolist(),
            "residual": printed_residual(self.residual, length),
            "condition": printed_condition(self.condition) if np.isfinite(self.condition) else None,
            "sides": {str(number): side for number, side in self.sides.items()},
        }
        if self.limits is not None:
            document["limits"] = [limit.to_json() for limit in self.limits]
        if not self.real:
            document["R_imag"] = self.R.imag.tolist()
            document["T_imag"] = self.T.imag.tolist()
            document["quaternion_imag"] = self.quaternion.imag.tolist()
        return document
