"""Cranks and slides along paths: what they are at poses, and the platform with its points there."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import out_of_cone, out_of_motor_range, out_of_range
from gspcli.geometry.machine import Machine, is_driven, shares_drives
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.workspace.pose_boxes import working_modes_of

Array = NDArray[np.float64]


class Motors:
    """The drives of a platform with cranks or slides, in the working modes of one pose.

    Parameters
    ----------
    instance
        The platform.
    R, T
        A pose, shapes (3, 3) and (3,), whose working modes are taken if no home is stated.
    working_modes
        The working modes, shape (6,), if they are known.
    """

    def __init__(
        self,
        instance: Instance,
        R: Array | None = None,
        T: Array | None = None,
        *,
        working_modes: NDArray[np.int64] | None = None,
    ) -> None:
        self.instance = instance
        self.drives = Machine.of(instance)
        self.working_modes = (
            working_modes_of(instance, R, T) if working_modes is None else working_modes
        )
        self.shared = shares_drives(instance)

    @staticmethod
    def of(instance: Instance, R: ArrayLike, T: ArrayLike) -> Motors | None:
        """Return the drives of a platform; None if only values are driven."""
        if not is_driven(instance):
            return None
        return Motors(instance, np.asarray(R, float), np.asarray(T, float))

    def numbers(self, R: Array, T: Array) -> Array:
        """Return what the drives are at along rows of poses, lengths and radians, shape (r, m).

        Cranks do not jump by whole turns from row to row. NaN where a rod does not reach.
        """
        found = self.drives.inverse(R, T, self.working_modes)
        free = np.array([sort == "crank" for sort in self.drives.sorts])
        free &= ~np.isfinite(self.drives.low)
        if len(found) > 1 and free.any():
            found[:, free] = np.unwrap(found[:, free], axis=0)
        return found

    def arrangement(self, R: Array, T: Array) -> Arrangement:
        """Return the platform with its points where poses have them."""
        return self.drives.arrangement(self.drives.inverse(R, T, self.working_modes))

    def values(self, R: Array, T: Array) -> Array:
        """Return the values at poses, those of rods the stated ones, shape (r, 6)."""
        drives = self.drives
        return np.where(drives.driven, drives.rods, values_at(self.instance, R, T))

    def kept(self, R: Array, T: Array) -> NDArray[np.bool_]:
        """Return whether ranges and cones are kept at poses, shape (r,)."""
        q = self.drives.inverse(R, T, self.working_modes)
        reached = ~np.isnan(q).any(axis=-1)
        left = (
            out_of_motor_range(self.drives, q),
            out_of_range(self.instance, self.values(R, T)),
            out_of_cone(self.instance, R, T, q),
        )
        return np.asarray(reached & ~np.concatenate(left, axis=-1).any(axis=-1))
