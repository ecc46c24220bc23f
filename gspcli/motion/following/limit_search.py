"""Searches for the nearest pose within ranges and cones, from a given pose.

The distance of two poses is ``sqrt(|p - p'|^2 + (L theta)^2)``: p is the position of a point of
the platform, theta the angle between the rotations, L the typical length of the platform. The
search is sequential quadratic programming (``gspcli/export/controller/nearest.c``). It does not
exclude nearer poses.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli import _kernel
from gspcli.errors import ArgumentError
from gspcli.geometry.drives import Drives, is_driven
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import joint_cones
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_quaternion
from gspcli.motion.following.limit_numbers import limit_numbers
from gspcli.motion.following.platform_numbers import NEVER, platform_numbers

Array = NDArray[np.float64]

#: How far inside its limits a pose is sought, relative to the length: rounding errors are less.
MARGIN = 1e-7
#: A pose is at a limit if it is nearer to it than this, relative to the length.
_MET = 2e-7


class FoundPose(NamedTuple):
    """A pose within the limits, locally nearest to the given one."""

    distance: float
    R: Array
    T: Array


class LimitSearch:
    """Searches for one platform.

    Parameters
    ----------
    instance
        The platform with its ranges and cones.
    R, T
        A pose, shapes (3, 3) and (3,), that decides the sides and knees.
    pivot
        The point of the platform whose position is compared, shape (3,).
    still
        Whether the platform keeps its rotation. Rods may share a drive then.

    Raises
    ------
    ArgumentError
        If a crank or slide does not reach the pose, or rods share a drive and the platform may
        rotate.
    """

    def __init__(
        self, instance: Instance, R: Array, T: Array, pivot: ArrayLike, *, still: bool = False
    ) -> None:
        self.instance = instance
        numbers = platform_numbers(instance, shared=still)
        limits = limit_numbers(instance, numbers, pivot=pivot, still=still)
        self._kernel = _kernel.Controller(numbers.kind, numbers.either, numbers.doubles)
        self._kernel.limit(*limits.arguments)
        #: The typical length of the platform, the factor of angles in distances.
        self.length = limits.weight * numbers.reach
        self._far = NEVER * numbers.reach / 10
        if self._kernel.start(_numbers(R, T)):
            message = "a crank or slide does not reach this pose, or lines are parallel there"
            raise ArgumentError(message, "R, T")

    @cached_property
    def begins(self) -> bool:
        """Whether the pose that decides sides is within the limits and allows a proved step."""
        at = np.concatenate((self._kernel.position(), self._kernel.rotation()))
        room = self._kernel.slack(at)[0]
        return bool(self._kernel.report()[0] == 1 and room.min() >= -MARGIN * self.length)

    def seek(self, goal: tuple[Array, Array], start: tuple[Array, Array]) -> FoundPose | None:
        """Return what is found from a start, or None if that is not within the limits."""
        found = self._kernel.seek(_numbers(*goal), _numbers(*start))
        if found is None:
            return None
        distance, pose = found
        return FoundPose(distance, rotation_from_quaternion(pose[3:]), pose[:3])

    def slack(self, R: Array, T: Array) -> Array:
        """Return how far a pose is within each limit, as lengths, negative outside, shape (c,).

        The limits are narrower by 1e-7 of the length. For a crank or slide it is by how much its
        rod would be too short or too long at the end of its range.
        """
        room = self._room(R, T)
        return room[room < self._far]

    def met(self, R: Array, T: Array) -> tuple[str, ...]:
        """Return the names of the limits that a pose meets."""
        near = self._room(R, T) < _MET * self.length
        return tuple(dict.fromkeys(self._name(k, R, T) for k in np.flatnonzero(near).tolist()))

    def _room(self, R: Array, T: Array) -> Array:
        return self._kernel.slack(_numbers(R, T))[0]

    @cached_property
    def _drives(self) -> Drives:
        return Drives.of(self.instance)

    def _name(self, slack: int, R: Array, T: Array) -> str:
        """Return the name of a limit: two of each constraint, then the cones."""
        if slack >= 12:
            one = joint_cones(self.instance)[slack - 12]
            return f"cone of {one.name} at leg {one.constraint + 1}"
        k = slack // 2
        if not is_driven(self.instance) or not self._drives.driven[k]:
            return f"range of {k + 1}"
        drives, (first, second) = self._drives, self._drives.roots(R, T)[k].tolist()
        drive = drives.index[k]
        apart = first - second
        if drives.sorts[drive] == "crank":
            apart = math.remainder(apart, 2 * math.pi)
        end = float((drives.high if slack % 2 else drives.low)[drive])
        # At the boundary of the reach of a rod both numbers of its drive are equal.
        what = "range" if min(abs(first - end), abs(second - end)) < abs(apart) / 2 else "reach"
        return f"{what} of {drives.names[drive].replace('.', ' ')}"


def _numbers(R: Array, T: Array) -> Array:
    return np.concatenate((T, quaternion_from_rotation(R)))
