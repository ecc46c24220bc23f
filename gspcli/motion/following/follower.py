"""The next pose, proved: the step of a controller (`gsp export --to c`) in Python."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli import _kernel
from gspcli.errors import ArgumentError
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_quaternion
from gspcli.motion.following.platform_numbers import limit_numbers, platform_numbers
from gspcli.motion.poses.inverse_kinematics import checked_poses
from gspcli.records import dataclass
from gspcli.wording import shortened

Array = NDArray[np.float64]


class FollowerStatus(IntEnum):
    """The result of a step; the numbers are those of the header that `gsp export --to c` writes."""

    PROVED = 0
    """The pose is the continuation along the straight line of values, and simple."""
    NOT_FINITE = 1
    """A value is not a finite number."""
    RANGE = 2
    """A value is outside the range of its constraint."""
    SINGULAR = 3
    """Refused: a singular pose is too near, to the start or on the line, or two lines meet."""
    TRIES_SPENT = 4
    """Refused: the line of values is too long for the tries of one step."""
    NOT_FOUND = 5
    """No pose within the limits was found."""


@dataclass(frozen=True)
class FollowerReport:
    """Numbers of the last step, or of the start before the first step.

    At a start ``fraction`` is 1, or 0 if the pose is so nearly singular that no step from it can be
    proved; ``sigma`` and ``alone`` are those of the pose.

    Attributes
    ----------
    fraction
        How much of the line of values was proved; 1 if all.
    sigma
        A lower bound, where the last part began, of the least singular value of the Jacobian matrix
        of the values. Twists are about the platform's middle, lengths are divided by its size
        (``reach`` and ``middle`` of `platform_numbers`). It is seldom less than a third of it.
    alone
        No other pose with these values is nearer than this: a length, or radians times the size.
    steps, tries
        How many parts of the line were proved, and tried.
    """

    fraction: float
    sigma: float
    alone: float
    steps: int
    tries: int


_STATUSES = tuple(FollowerStatus)


class Follower:
    """A platform that follows its values, each step proved: 1 to 5 µs.

    The program is the one that `gsp export --to c` writes, with the numbers of this platform.

    Parameters
    ----------
    instance
        The platform. Its values are used for the rods of cranks and slides only.
    R, T
        Its pose, shapes (3, 3) and (3,), ``x_base = R x_platform + T``; its values are measured at
        the pose. Cranks and slides have the numbers nearest to zero.

    Raises
    ------
    ArgumentError
        If the pose is not a pose, a crank or slide does not reach it, or a drive is not at the end
        of exactly one leg.

    Examples
    --------
    >>> import gspcli
    >>> from gspcli.resources import instance_files
    >>> platform = gspcli.load(instance_files()["nano-hexapod"])
    >>> pose = gspcli.solve(platform).real_solutions[0]
    >>> follower = gspcli.Follower(platform, pose.R.real, pose.T.real)
    >>> follower.forward(follower.values + 1e-5).name
    'PROVED'
    """

    def __init__(
        self, instance: Instance, R: ArrayLike, T: ArrayLike, *, margin: float = 0.0
    ) -> None:
        rotation, translation = checked_poses(R, T)
        if translation.shape != (3,):
            raise ArgumentError(
                f"found the shape {translation.shape}, expected one pose: (3,)", "T"
            )
        self.instance = instance
        numbers = platform_numbers(instance, margin)
        self._controller = _kernel.Controller(numbers.kind, numbers.either, numbers.doubles)
        pivot = PoseFrame.of(instance).tool.T
        self._controller.limit(*limit_numbers(instance, numbers, pivot=pivot).arguments)
        quaternion = quaternion_from_rotation(rotation)
        status = self._controller.start(np.concatenate((translation, quaternion)))
        if status:
            reasons = {
                FollowerStatus.RANGE: "a crank or slide does not reach this pose, or a value that "
                "stays is another one there",
                FollowerStatus.SINGULAR: "lines are parallel there",
            }
            nothing = "found no pose: a rotation and a translation"
            raise ArgumentError(reasons.get(FollowerStatus(status), nothing))

    def __reduce__(self) -> tuple[Any, ...]:
        return _moved, (self.instance, self.R, self.T, self.values)

    def forward(self, values: ArrayLike) -> FollowerStatus:
        """Move to the pose of other values, if it is proved to be the continuation of this one.

        Parameters
        ----------
        values
            Shape (6,), in the units of the instance, planes signed; of cranks and slides their
            angles and ways.

        Returns
        -------
        FollowerStatus
            PROVED: for every value on the straight line between, exactly one pose is near, it is
            not singular, and the new pose is its end. With any other status the follower has not
            moved.
        """
        try:
            array = np.ascontiguousarray(values, np.float64)
        except (TypeError, ValueError) as error:
            raise ArgumentError(
                f"found {shortened(repr(values))}, expected six numbers", "values"
            ) from error
        if array.shape != (6,):
            raise ArgumentError(f"found the shape {array.shape}, expected (6,)", "values")
        return _STATUSES[self._controller.forward(array)]

    def nearest(self, R: ArrayLike, T: ArrayLike) -> FollowerStatus:
        """Move to the nearest pose to a given one that keeps all ranges and cones: 10 to 60 µs.

        The distance adds the squares of the shift of the tool's point, or of the origin without a
        tool, and of the turn times the typical length of the platform. A search finds the pose; it
        does not exclude nearer ones. `NearestPoses` searches from more poses, and proves that cones
        are kept on the way, too.

        Parameters
        ----------
        R, T
            The given pose, shapes (3, 3) and (3,).

        Returns
        -------
        FollowerStatus
            PROVED: the follower is at the nearest pose that was found, within the limits, and a
            straight line of values leads there as for `forward`, or several do. With any other
            status it is at the end of the last proved line, or has not moved.
        """
        rotation, translation = checked_poses(R, T)
        if translation.shape != (3,):
            raise ArgumentError(
                f"found the shape {translation.shape}, expected one pose: (3,)", "T"
            )
        quaternion = quaternion_from_rotation(rotation)
        return _STATUSES[self._controller.nearest(np.concatenate((translation, quaternion)))]

    @property
    def T(self) -> Array:
        """The translation, shape (3,)."""
        return self._controller.position()

    @property
    def quaternion(self) -> Array:
        """The unit quaternion of the rotation, scalar first, shape (4,)."""
        return self._controller.rotation()

    @property
    def R(self) -> Array:
        """The rotation, shape (3, 3)."""
        return rotation_from_quaternion(self.quaternion)

    @property
    def values(self) -> Array:
        """The values of the pose, shape (6,)."""
        return self._controller.values()

    @property
    def jacobian(self) -> Array:
        """The derivatives of the values by a twist, shape (6, 6); NaN where one has none.

        In the units of the instance, by radians and length units (`geometry.measurement`).
        """
        found = self._controller.jacobian()
        return np.full((6, 6), np.nan) if found is None else found

    @property
    def error(self) -> float:
        """A bound of the distance of the exact pose: a length, or radians times the size."""
        return self._controller.error()

    @property
    def report(self) -> FollowerReport:
        """Numbers of the last step; before the first step, of the start."""
        return FollowerReport(*self._controller.report())

    def __repr__(self) -> str:
        return f"<Follower of {self.instance!r} at {self.T.tolist()}>"


def _moved(instance: Instance, R: Array, T: Array, values: Array) -> Follower:
    """Return a follower at a pose with given values (for unpickling)."""
    follower = Follower(instance, R, T)
    follower.forward(values)
    return follower
