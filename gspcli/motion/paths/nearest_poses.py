"""The nearest pose within the limits: where to go if the given pose is out of reach.

`LimitSearch` finds it from several poses. That is a search: it does not exclude nearer poses.

The answer is proved: the pose keeps all ranges and cones and is not singular. A straight way from
the pose where the platform is leads to it, within the limits and without a singular pose. Cranks
and slides keep their knees, and reach their rods all the way. Rods that share a drive are parallel
at one orientation, which stays.
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
    unit_quaternion,
    vector_from_rotation,
)
from gspcli.geometry.readings import readings_of
from gspcli.motion.following.limit_search import LimitSearch
from gspcli.motion.paths.drive_guide import DriveGuide
from gspcli.motion.paths.ends import PathEnd
from gspcli.motion.paths.motors import Motors
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.value_ways import ValueWays
from gspcli.motion.poses.inverse_kinematics import checked_poses, values_at
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: What is among the limits of a pose if no straight way is proved to the nearest one found.
FARTHER = "no way farther"
#: Where no straight way is proved, the goal moves to the given pose in this many steps.
_GOALS = 8
#: Poses that are found are rounded to this many decimals of the quaternion and of the length.
_DECIMALS = 8
#: Poses that are so near are the same, relative to the length.
_SAME = 2e-7


@dataclass(frozen=True, eq=False)
class NearestPose:
    """The nearest pose that was found within the limits.

    Attributes
    ----------
    R, T
        The pose, shapes (3, 3) and (3,).
    values
        The readings there, in the units of the instance: of the six values, or of all m drives of
        a machine with cranks or slides, shape (m,).
    shift, turn
        The distance of the platform's point from the given place, and the angle between the
        rotations in the unit of the instance.
    limits
        The limits that the pose meets, in words; none if it is the given pose. ``no way farther``
        is among them if no straight way is proved to the nearest pose that was found. The platform
        then goes as far as one is proved, in eighths of the way to the given pose.
    way
        The straight way to it that is proved: ``values``, ``drives`` or ``poses``. Empty if none
        is: then the platform stays where it is, and `R` and `T` are that pose.
    """

    R: Array
    T: Array
    values: Array
    shift: float
    turn: float
    limits: tuple[str, ...]
    way: str

    def to_json(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {
            "R": self.R.tolist(),
            "T": self.T.tolist(),
            "values": self.values.tolist(),
            "shift": self.shift,
            "turn": self.turn,
            "limits": list(self.limits),
            "way": self.way or None,
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
        If the pose is not proved to be regular and within the limits.

    Examples
    --------
    >>> import gspcli
    >>> platform = gspcli.example("workspace-study")
    >>> home = gspcli.solve(platform).home
    >>> nearest = gspcli.NearestPoses(platform, home.R.real, home.T.real)
    >>> found = nearest.of(home.R.real, home.T.real + [0, 0, 500])
    >>> found.way, found.limits[0]
    ('values', 'range of 1')
    """

    def __init__(
        self, instance: Instance, R: ArrayLike, T: ArrayLike, *, pivot: ArrayLike | None = None
    ) -> None:
        self.instance = instance
        self.R, self.T = checked_poses(R, T)
        if self.T.shape != (3,):
            message = f"found the shape {self.T.shape}, expected one pose: (3,)"
            raise ArgumentError(message, "T")
        self.pivot = np.zeros(3) if pivot is None else np.asarray(pivot, float)
        self._motors = Motors.of(instance, self.R, self.T)
        self._still = self._motors is not None and self._motors.shared
        self._search = LimitSearch(instance, self.R, self.T, self.pivot, still=self._still)
        drives = Drives.of(instance)
        #: Which values have a range of one number, and so stay: shape (6,).
        self._fixed = (drives.low == drives.high)[drives.index]
        #: Poses are rounded unless doubles near to a pose are not near enough.
        self._rounds = not (self._fixed.any() or self._still)
        if not self.way(self.R, self.T):
            message = "the pose is not proved to be regular and within all ranges and cones"
            raise ArgumentError(message, "R, T")

    @property
    def length(self) -> float:
        """What turns are multiplied by in distances: the typical length of the platform."""
        return self._search.length

    def slack(self, R: Array, T: Array) -> Array:
        """Return how far a pose is within each limit, as lengths, negative outside, shape (c,).

        The limits are narrower by 1e-7 of the length. Of a crank or slide it is how much its rod
        would be too short or too long at the end of its range.
        """
        return self._search.slack(R, T)

    @cached_property
    def _ways(self) -> ValueWays:
        return ValueWays(self.instance, np.sign(values_at(self.instance, self.R, self.T)))

    @cached_property
    def _pose_ways(self) -> PoseWays:
        return PoseWays(self.instance, pivot=self.pivot, motors=self._motors)

    @cached_property
    def _parameters(self) -> Array:
        return self._pose_ways.parameters(self.R, self.T)

    def of(self, R: ArrayLike, T: ArrayLike) -> NearestPose:
        """Return the nearest pose within the limits to which a way is proved.

        Parameters
        ----------
        R, T
            The given pose, shapes (3, 3) and (3,).
        """
        goal = checked_poses(R, T)
        if goal[1].shape != (3,):
            message = f"found the shape {goal[1].shape}, expected one pose: (3,)"
            raise ArgumentError(message, "T")
        found = sorted(self._candidates(*goal), key=lambda one: one[0])
        for _, pose in found:
            if way := self.way(*pose):
                return self._answer(pose, goal, way)
        for pose in reversed(self._by_small_steps(*goal)):
            if way := self.way(*pose, drives=False):
                found_there = self._answer(pose, goal, way)
                return replace(found_there, limits=(*found_there.limits, FARTHER))
        return replace(self._answer((self.R, self.T), goal, ""), limits=(FARTHER,))

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
        """Return the same where the platform is at another pose, which is proved."""
        moved = copy(self)
        moved.R, moved.T = to.R, to.T
        moved.__dict__["_parameters"] = self._pose_ways.parameters(to.R, to.T)
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
            one = self._search.seek((R, T), (self.R, start[1]) if self._still else start)
            if one is None:
                continue
            pose = self._as_printed(one.R, one.T)
            if not any(_same(pose, other, self.length) for _, other in found):
                found.append((one.distance, pose))
        return found

    def _as_printed(self, R: Array, T: Array) -> tuple[Array, Array]:
        if self._still:
            return self.R, T
        return _rounded(R, T, self.length) if self._rounds else (R, T)

    def _by_small_steps(self, R: Array, T: Array) -> list[tuple[Array, Array]]:
        """Return the poses that follow a goal on the straight way to the given pose."""
        poses: list[tuple[Array, Array]] = []
        turn, pose = vector_from_rotation(R @ self.R.T), (self.R, self.T)
        for k in range(1, _GOALS + 1):
            part = k / _GOALS
            goal = rotation_from_vector(part * turn) @ self.R, self.T + part * (T - self.T)
            found = self._search.seek(goal, pose)
            if found is not None:
                pose = found.R, found.T
                poses.append(self._as_printed(*pose))
        return poses

    def way(self, R: Array, T: Array, *, drives: bool = True) -> str:
        """Return the straight way from the platform's pose that is proved; empty if none is.

        With fixed values poses are no doubles: the pose of the values is meant.

        Parameters
        ----------
        R, T
            The pose, shapes (3, 3) and (3,).
        drives
            Whether straight ways of cranks and slides are tried, too: some tenths of a second.
        """
        begin, ways = self._parameters, self._pose_ways
        end = ways.nearest(begin, ways.parameters(R, T))
        fixed = bool(self._fixed.any())
        if not fixed and ways.at(end).sign == 0:
            return ""
        # With cones or motors the proof of straight values takes 20 times as long as that of poses.
        last = self._motors is not None or bool(self._ways.cones)
        if not last and self._follows_values(R, T):
            return "values"
        if not fixed and ways.prove(begin, end).sign:
            return "poses"
        if self._motors is not None:
            found = drives and not self._still and self._follows_drives(R, T)
            return "drives" if found else ""
        return "values" if last and self._follows_values(R, T) else ""

    def _follows_values(self, R: Array, T: Array) -> bool:
        """Return whether a straight way of values is proved."""
        followed = self._ways
        rotations, places = np.stack((self.R, R)), np.stack((self.T, T))
        values = values_at(self.instance, rotations, places)
        values = np.where(self._fixed, followed.low, values)
        if not followed.kept(values).all():
            return False
        points = followed.points(rotations, places)
        found = followed.follow(values[None], np.zeros(1, np.int64), points[:1])
        arrived = bool(found.there[0]) and bool(followed.same(found.points[0, -1], points[1]))
        return arrived and followed.cones_kept(values, found.points[0])

    def _follows_drives(self, R: Array, T: Array) -> bool:
        """Return whether a straight way of cranks, slides and driven values is proved."""
        assert self._motors is not None
        drives = self._motors.drives
        start, goal = (PathEnd("", np.zeros(6), *one) for one in ((self.R, self.T), (R, T)))
        guide = DriveGuide(self._motors, self._pose_ways, start, goal)
        corners = guide.corners
        locked = drives.low == drives.high
        corners[:, locked] = (drives.low / drives.units)[locked]
        if (corners[0] == corners[1]).all():
            return self._search.begins
        return guide.trace(corners, np.ones(1, np.int64)) is not None

    def _answer(
        self, pose: tuple[Array, Array], goal: tuple[Array, Array], way: str
    ) -> NearestPose:
        R, T = pose
        moved = T is not goal[1]
        shift = (
            np.linalg.norm(T + R @ self.pivot - goal[1] - goal[0] @ self.pivot) if moved else 0.0
        )
        turn = np.linalg.norm(vector_from_rotation(R @ goal[0].T)) if moved else 0.0
        radian = self.instance.units.angle.in_radians
        met = self._search.met(R, T) if moved else ()
        return NearestPose(R, T, self._readings(R, T), float(shift), float(turn / radian), met, way)

    def _readings(self, R: Array, T: Array) -> Array:
        """Return the readings of the values, or of all drives, at a pose."""
        if self._motors is None:
            return readings_of(self.instance, values_at(self.instance, R, T))
        return self._motors.drives.readings(self._motors.numbers(R[None], T[None])[0])


def _rounded(R: Array, T: Array, length: float) -> tuple[Array, Array]:
    """Return a pose with decimals that rounding errors of the search do not reach."""
    quaternion = np.round(quaternion_from_rotation(R), _DECIMALS)
    decimals = _DECIMALS - int(np.ceil(np.log10(length)))
    return rotation_from_quaternion(unit_quaternion(quaternion)), np.round(T, decimals)


def _same(a: tuple[Array, Array], b: tuple[Array, Array], length: float) -> bool:
    turn = float(np.abs(a[0] - b[0]).max())
    return turn < _SAME and float(np.abs(a[1] - b[1]).max()) < _SAME * length
