"""The nearest pose within the limits: where to go if the given pose is out of reach.

Sequential quadratic programming (``gspcli/export/controller/nearest.c``) finds it from several
poses. That is a search: it does not exclude nearer poses, and whether a way leads there is not its
question (`gsp path`). Cranks and slides keep their working modes. Rods that share a drive are
parallel at one orientation, which stays.

The distance of two poses is ``sqrt(|p - p'|^2 + (L theta)^2)``: p is the position of a point of
the platform, theta the angle between the rotations, L the typical length of the platform.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli import _kernel
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
    unit_quaternion,
    vector_from_rotation,
)
from gspcli.motion.following.follower import NEVER, limit_numbers, platform_numbers
from gspcli.motion.poses.inverse_kinematics import checked_poses
from gspcli.records import dataclass

Array = NDArray[np.float64]
#: What stands for the limits if no pose within them is found: then the platform stays.
NOT_FOUND = "none found"
#: Poses that are found are rounded to this many decimals of the quaternion and of the length.
_DECIMALS = 8
#: Poses that are so near are the same, relative to the length.
_SAME = 2e-7
#: How far inside its limits a pose is sought, relative to the length: rounding errors are less.
MARGIN = 1e-7
#: A pose is at a limit if it is nearer to it than this, relative to the length.
_MET = 2e-7


@dataclass(frozen=True, eq=False)
class NearestPose:
    """The nearest pose that was found within the limits."""

    #: The pose, shapes (3, 3) and (3,).
    R: Array
    T: Array
    #: The readings there, in the units of the instance: of the six values, or of all m drives of a
    #: machine with cranks or slides, shape (m,).
    values: Array
    #: The distance of the platform's point from the given place, and the angle between the
    #: rotations in the unit of the instance.
    shift: float
    turn: float
    #: The limits that the pose meets, in words; none if it is the given pose. ``none found`` if the
    #: search has found no pose: then it is the one where the platform is.
    limits: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {
            "R": self.R.tolist(),
            "T": self.T.tolist(),
            "values": self.values.tolist(),
            "shift": self.shift,
            "turn": self.turn,
            "limits": list(self.limits),
        }


class NearestPoses:
    """The nearest poses of one platform from where it is.

    Parameters
    ----------
    instance
        The platform with its ranges and cones; its values are not used.
    R, T
        The pose where it is, shapes (3, 3) and (3,), within the limits.
    pivot
        The point of the platform whose position is compared, shape (3,); its origin if None.

    Raises
    ------
    ArgumentError
        If the pose is singular, or not within the limits.

    Examples
    --------
    >>> import gspcli
    >>> platform = gspcli.example("workspace-study")
    >>> home = gspcli.solve(platform).home
    >>> nearest = gspcli.NearestPoses(platform, home.R.real, home.T.real)
    >>> found = nearest.of(home.R.real, home.T.real + [0, 0, 500])
    >>> found.limits[0]
    'range of 1'
    """

    def __init__(
        self, instance: Instance, R: ArrayLike, T: ArrayLike, *, pivot: ArrayLike | None = None
    ) -> None:
        self.instance = instance
        self.R, self.T = checked_poses(R, T)
        if self.T.shape != (3,):
            raise ArgumentError(f"found the shape {self.T.shape}, expected one pose: (3,)", "T")
        self.pivot = np.zeros(3) if pivot is None else np.asarray(pivot, float)
        self._machine = Machine.of(instance).at_home(self.R, self.T)
        self._still = self._machine.shared
        numbers = platform_numbers(instance, shared=self._still)
        limits = limit_numbers(instance, numbers, pivot=self.pivot, still=self._still)
        self._kernel = _kernel.Controller(numbers.kind, numbers.either, numbers.doubles)
        self._kernel.limit(*limits.arguments)
        #: What turns are multiplied by in distances: the typical length of the platform.
        self.length = limits.weight * numbers.reach
        self._far = NEVER * numbers.reach / 10
        #: Poses are rounded unless doubles near to a pose are not near enough.
        single = self._machine.low == self._machine.high
        self._rounds = not (self._machine.fixed.any() or single.any() or self._still)
        if self._kernel.start(_numbers(self.R, self.T)):
            raise ArgumentError(
                "a crank or slide does not reach this pose, or lines are parallel there", "R, T"
            )
        proved = self._kernel.report()[0] == 1
        if not (proved and self._room(self.R, self.T).min() >= -MARGIN * self.length):
            raise ArgumentError("the pose is singular, or not within all ranges and cones", "R, T")

    def slack(self, R: Array, T: Array) -> Array:
        """Return how far a pose is within each limit, as lengths, negative outside, shape (c,).

        The limits are narrower by 1e-7 of the length. Of a crank or slide it is how much its rod
        would be too short or too long at the end of its range.
        """
        room = self._room(R, T)
        return room[room < self._far]

    def _room(self, R: Array, T: Array) -> Array:
        return self._kernel.slack(_numbers(R, T))[0]

    def of(self, R: ArrayLike, T: ArrayLike) -> NearestPose:
        """Return the nearest pose within the limits that is found.

        Parameters
        ----------
        R, T
            The given pose, shapes (3, 3) and (3,).
        """
        goal = checked_poses(R, T)
        if goal[1].shape != (3,):
            raise ArgumentError(f"found the shape {goal[1].shape}, expected one pose: (3,)", "T")
        found = self._candidates(*goal)
        if not found:
            return self._answer((self.R, self.T), goal, (NOT_FOUND,))
        _, pose = min(found, key=lambda one: one[0])
        return self._answer(pose, goal, None if pose[1] is goal[1] else self._met(*pose))

    def along(self, R: ArrayLike, T: ArrayLike) -> Iterator[NearestPose]:
        """Yield the nearest pose to each of n given poses, each sought from the one before.

        Parameters
        ----------
        R, T
            The given poses, shapes (n, 3, 3) and (n, 3).
        """
        here = self
        for goal in zip(*checked_poses(R, T), strict=True):
            found = here.of(*goal)
            yield found
            here = here._moved(found)

    def _moved(self, to: NearestPose) -> NearestPoses:
        """Return the same where the platform is at another pose."""
        moved = copy(self)
        moved.R, moved.T = to.R, to.T
        return moved

    def _candidates(self, R: Array, T: Array) -> list[tuple[float, tuple[Array, Array]]]:
        """Return the ends of searches with their distances from the given pose."""
        reached = not self._still or np.array_equal(R, self.R)
        if reached and self.slack(R, T).min(initial=np.inf) >= 0:
            return [(0.0, (R, T))]
        half = rotation_from_vector(vector_from_rotation(self.R @ R.T) / 2) @ R
        starts = [(self.R, self.T), (R, T), (half, (self.T + T) / 2)]
        found: list[tuple[float, tuple[Array, Array]]] = []
        for start in starts:
            begin = self.R if self._still else start[0], start[1]
            one = self._kernel.seek(_numbers(R, T), _numbers(*begin))
            if one is None:
                continue
            distance, numbers = one
            pose = self._as_printed(rotation_from_quaternion(numbers[3:]), numbers[:3])
            if not any(_same(pose, other, self.length) for _, other in found):
                found.append((distance, pose))
        return found

    def _as_printed(self, R: Array, T: Array) -> tuple[Array, Array]:
        if self._still:
            return self.R, T
        return _rounded(R, T, self.length) if self._rounds else (R, T)

    def _answer(
        self, pose: tuple[Array, Array], goal: tuple[Array, Array], limits: tuple[str, ...] | None
    ) -> NearestPose:
        """Return a pose, by how far it is from the given one; that itself if it meets no limits."""
        R, T = pose
        shift = turn = 0.0
        if limits is not None:
            shift = float(np.linalg.norm(T + R @ self.pivot - goal[1] - goal[0] @ self.pivot))
            turn = float(np.linalg.norm(vector_from_rotation(R @ goal[0].T)))
        turn /= self.instance.units.angle.in_radians
        readings = self._machine.readings(self._machine.inverse(R, T))
        return NearestPose(R, T, readings, shift, turn, limits or ())

    def _met(self, R: Array, T: Array) -> tuple[str, ...]:
        """Return the names of the limits that a pose meets."""
        near = self._room(R, T) < _MET * self.length
        return tuple(dict.fromkeys(self._name(k, R, T) for k in np.flatnonzero(near).tolist()))

    def _name(self, slack: int, R: Array, T: Array) -> str:
        """Return the name of a limit: two of each constraint, then the cones."""
        machine, k = self._machine, slack // 2
        if slack >= 12:
            one = machine.cones[slack - 12]
            return f"cone of {one.name} at leg {one.constraint + 1}"
        if not machine.driven[k]:
            return f"range of {k + 1}"
        first, second = machine.roots(R, T)[k].tolist()
        drive = machine.index[k]
        apart = first - second
        if machine.sorts[drive] == "crank":
            apart = math.remainder(apart, 2 * math.pi)
        end = float((machine.high if slack % 2 else machine.low)[drive])
        # At the boundary of the reach of a rod both numbers of its drive are equal.
        what = "range" if min(abs(first - end), abs(second - end)) < abs(apart) / 2 else "reach"
        return f"{what} of {machine.names[drive].replace('.', ' ')}"


def _rounded(R: Array, T: Array, length: float) -> tuple[Array, Array]:
    """Return a pose with decimals that rounding errors of the search do not reach."""
    quaternion = np.round(quaternion_from_rotation(R), _DECIMALS)
    decimals = _DECIMALS - int(np.ceil(np.log10(length)))
    return rotation_from_quaternion(unit_quaternion(quaternion)), np.round(T, decimals)


def _same(a: tuple[Array, Array], b: tuple[Array, Array], length: float) -> bool:
    turn = float(np.abs(a[0] - b[0]).max())
    return turn < _SAME and float(np.abs(a[1] - b[1]).max()) < _SAME * length


def _numbers(R: Array, T: Array) -> Array:
    return np.concatenate((T, quaternion_from_rotation(R)))
