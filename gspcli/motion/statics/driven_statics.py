"""Torques, stiffness and errors of platforms that cranks and slides drive.

With J t = D q' (`gspcli.geometry.drives`) a force F in the rods needs the torques ``D^T F``.
Springs of drives and of rods are in series: the rods give by ``C = D k_q^-1 D^T + k_r^-1`` times F,
so that the stiffness of the platform is ``J^T C^-1 J``. It is finite at a dead point if the rods
give. An error dq of the drives and dL of the rods moves the platform by ``J^-1 (dL + D dq)``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.drives import Drives
from gspcli.motion.statics.wrenches import Wrenches
from gspcli.records import dataclass

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DrivenStatics:
    """The drives of a platform at poses.

    Attributes
    ----------
    given
        The wrenches of the constraints, with the points where the drives have them.
    drives
        The m drives.
    q
        Their numbers, lengths and radians, shape (n, m).
    gains
        The gain of the drive of each constraint, shape (n, 6).
    """

    given: Wrenches
    drives: Drives
    q: Array
    gains: Array

    @classmethod
    def of(cls, given: Wrenches) -> DrivenStatics | None:
        """Return the drives of wrenches; None if all drives are values."""
        if given.drives is None or given.q is None:
            return None
        gains = given.drives.gains(given.R, given.T, given.q)
        return cls(given, given.drives, given.q, gains)

    @property
    def matrix(self) -> Array:
        """D, shape (n, 6, m)."""
        return self.drives.matrix(self.gains)

    @property
    def transmissions(self) -> Array:
        """The transmission of each constraint, NaN where its value is the drive, shape (n, 6)."""
        share = self.drives.transmission(self.gains)
        return np.where(self.drives.driven, share, np.nan)

    def torques(self, reactions: Array) -> Array:
        """Return the loads of the drives that hold forces in the constraints, (n, 6) -> (n, m)."""
        torques: Array = np.einsum("...km,...k->...m", self.matrix, reactions)
        return torques

    def compliance(self, motors: ArrayLike | None, rods: ArrayLike | None) -> Array:
        """Return how far forces in the constraints move their values, C, shape (n, 6, 6).

        Parameters
        ----------
        motors
            Stiffnesses of the drives: force over length, moment over radian, shape (m,); None if
            they do not give.
        rods
            Of the constraints with cranks and slides, shape (6,); None if they do not give. For
            driven values the number is that of the drive.

        Raises
        ------
        ArgumentError
            If a stiffness is not positive.
        """
        n, driven = len(self.gains), self.drives.driven
        matrix = np.zeros((n, 6, 6))
        if motors is not None:
            held = _positive(motors)
            matrix += np.einsum("nkm,m,nlm->nkl", self.matrix, 1 / held, self.matrix)
        if rods is not None:
            given = 1 / _positive(rods)
            if motors is None:
                matrix += np.diag(given)
            else:
                matrix += np.diag(np.where(driven, given, 0.0))
        return matrix

    def stiffness(self, compliance: Array) -> Array:
        """Return ``J^T C^-1 J`` about the point, shape (n, 6, 6); NaN if it is not finite.

        It is not finite if the rods do not give and a drive is at a dead point or moves two rods.
        """
        scales = np.sqrt(np.abs(np.einsum("nkk->nk", compliance)))
        scaled = compliance / np.where(scales > 0, scales, 1.0)[:, :, None]
        scaled = scaled / np.where(scales > 0, scales, 1.0)[:, None, :]
        ranks = np.array([np.linalg.matrix_rank(one, tol=1e-9, hermitian=True) for one in scaled])
        regular = np.equal(ranks, self.gains.shape[1])
        safe = np.where(regular[:, None, None], compliance, np.eye(6))
        J = self.given.jacobian
        found: Array = np.swapaxes(J, -1, -2) @ np.linalg.solve(safe, J)
        found = (found + np.swapaxes(found, -1, -2)) / 2
        return np.where(regular[:, None, None], found, np.nan)

    def least_stiffness(self, compliance: Array) -> Array:
        """Return the least ratio of a force at the point to its shift, (n,); NaN if singular.

        As `Wrenches.least_stiffness`; infinite if nothing gives.
        """
        part = self.given.inverse[:, 3:, :]
        gives = part @ compliance @ np.swapaxes(part, -1, -2)
        known = np.asarray(np.isfinite(gives).all(axis=(-1, -2)))
        largest = np.linalg.eigvalsh(np.where(known[:, None, None], gives, np.eye(3)))[:, -1]
        with np.errstate(divide="ignore"):
            return np.where(known, 1 / np.maximum(largest, 0.0), np.nan)


def _positive(each: ArrayLike) -> Array:
    constants = np.asarray(each, float)
    if not (np.isfinite(constants) & (constants > 0)).all():
        message = f"found {constants.tolist()}, expected positive numbers"
        raise ArgumentError(message, "stiffness")
    return constants
