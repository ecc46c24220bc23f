"""The nearest pose within the limits: where to go if the given pose is out of reach.

The distance of two poses is ``sqrt(|p - p'|^2 + (L theta)^2)``: p is the position of a point of
the platform, theta the angle between the rotations, L the typical length of the platform. Ranges
and cones are inequalities. Sequential quadratic programming from several poses finds the nearest
pose that keeps them. That is a search: it does not exclude nearer poses.

The answer is proved: the pose keeps all ranges and cones and is not singular. A straight way from
the pose where the platform is leads to it, within the limits and without a singular pose.
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drive_numbers import is_driven
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import joint_cones
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.quaternions import (
    apply,
    cross,
    dot,
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
    unit_quaternion,
    vector_from_rotation,
)
from gspcli.geometry.readings import readings_of
from gspcli.geometry.shortest_step import nonnegative_least_squares, shortest_step
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.value_ways import ValueWays
from gspcli.motion.poses.inverse_kinematics import checked_poses, values_at
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: How far inside its limits a pose is sought, relative to the length: rounding errors are less.
_MARGIN = 1e-7
#: The search ends when a step is shorter, relative to the length, or after so many steps.
_SHORT, _STEPS = 1e-9, 40
#: No step is longer, relative to the length.
_LONGEST = 0.5
#: Step of the differences that second derivatives are made of: radians, or parts of the length.
_DIFFERENCE = 1e-6
#: The least curvature of the quadratic problem relative to that of the distance.
_CURVATURE = 0.2
#: Where no straight way is proved, the goal moves to the given pose in so many steps.
_GOALS = 8
#: How often a step is halved.
_HALVINGS = 12
#: Poses that are found are rounded to so many decimals of the quaternion and of the length.
_DECIMALS = 8
#: A limit is met if a pose is so near to it, relative to the length; so near poses are the same.
_MET = 2e-7


@dataclass(frozen=True, eq=False)
class NearestPose:
    """The nearest pose that was found within the limits.

    Attributes
    ----------
    R, T
        The pose, shapes (3, 3) and (3,).
    values
        The readings there, shape (6,), in the units of the instance.
    shift, turn
        The distance of the platform's point from the given place, and the angle between the
        rotations in the unit of the instance.
    limits
        The limits that the pose meets, in words; none if it is the given pose.
    way
        The straight way to it that is proved: ``values`` or ``poses``. Empty if none is: then the
        platform stays where it is, and `R` and `T` are that pose.
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
        If the pose is not proved to be regular and within the limits, or cranks or slides drive
        the platform.

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
        if is_driven(instance):
            message = (
                "nearest poses are for legs, and cranks or slides move joints here: gsp measure "
                '--require "range<=1" says which poses keep the ranges of the motors'
            )
            raise ArgumentError(message, "instance")
        self.instance = instance
        self.R, self.T = checked_poses(R, T)
        if self.T.shape != (3,):
            message = f"found the shape {self.T.shape}, expected one pose: (3,)"
            raise ArgumentError(message, "T")
        self.pivot = np.zeros(3) if pivot is None else np.asarray(pivot, float)
        values = values_at(instance, self.R, self.T)
        self._ways = ValueWays(instance, np.sign(values))
        self._slack = _Slack(instance, self._ways.low, self._ways.high)
        #: Which values have a range of one number, and so stay: shape (6,).
        self._fixed = self._ways.low == self._ways.high
        if not self.way(self.R, self.T):
            message = "the pose is not proved to be regular and within all ranges and cones"
            raise ArgumentError(message, "R, T")

    @property
    def length(self) -> float:
        """What turns are multiplied by in distances: the typical length of the platform."""
        return self._slack.length

    def slack(self, R: Array, T: Array) -> Array:
        """Return how far a pose is within each limit, as lengths, negative outside, shape (c,).

        The limits are narrower by 1e-7 of the length.
        """
        return self._slack.at(R, T)[0]

    @cached_property
    def _pose_ways(self) -> PoseWays:
        return PoseWays(self.instance, pivot=self.pivot)

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
        pose = self._by_small_steps(*goal)
        if way := self.way(*pose):
            return self._answer(pose, goal, way)
        return self._answer((self.R, self.T), goal, "")

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
        slack = self._slack
        if slack.at(R, T)[0].min(initial=np.inf) >= 0:
            return [(0.0, (R, T))]
        half = rotation_from_vector(vector_from_rotation(self.R @ R.T) / 2) @ R
        starts = [(self.R, self.T), (R, T), (half, (self.T + T) / 2)]
        found: list[tuple[float, tuple[Array, Array]]] = []
        for start in starts:
            pose, distance = _nearest(slack, (R, T), start, self.pivot)
            new = not any(_same(pose, one, slack.length) for _, one in found)
            # Within the limits that are a margin narrower, up to half of it.
            if new and slack.at(*pose)[0].min(initial=np.inf) > -_MARGIN * slack.length / 2:
                rounded = pose if self._fixed.any() else slack.rounded(*pose)
                found.append((distance, rounded))
        return found

    def _by_small_steps(self, R: Array, T: Array) -> tuple[Array, Array]:
        """Return the pose that follows a goal on the straight way to the given pose."""
        turn, pose = vector_from_rotation(R @ self.R.T), (self.R, self.T)
        for k in range(1, _GOALS + 1):
            part = k / _GOALS
            goal = rotation_from_vector(part * turn) @ self.R, self.T + part * (T - self.T)
            pose, _ = _nearest(self._slack, goal, pose, self.pivot)
        return pose if self._fixed.any() else self._slack.rounded(*pose)

    def way(self, R: Array, T: Array) -> str:
        """Return the straight way from the platform's pose that is proved; empty if none is.

        With fixed values poses are no doubles: the pose of the values is meant.
        """
        fixed = bool(self._fixed.any())
        begin, ways = self._parameters, self._pose_ways
        end = ways.nearest(begin, ways.parameters(R, T))
        if not fixed and ways.at(end).sign == 0:
            return ""
        followed = self._ways
        rotations, places = np.stack((self.R, R)), np.stack((self.T, T))
        values = values_at(self.instance, rotations, places)
        values = np.where(self._fixed, followed.low, values)
        if followed.kept(values).all():
            points = followed.points(rotations, places)
            found = followed.follow(values[None], np.zeros(1, np.int64), points[:1])
            arrived = bool(found.there[0]) and bool(followed.same(found.points[0, -1], points[1]))
            if arrived and followed.cones_kept(values, found.points[0]):
                return "values"
        return "poses" if not fixed and ways.prove(begin, end).sign else ""

    def _answer(
        self, pose: tuple[Array, Array], goal: tuple[Array, Array], way: str
    ) -> NearestPose:
        R, T = pose
        moved = R is not goal[0]
        shift = (
            np.linalg.norm(T + R @ self.pivot - goal[1] - goal[0] @ self.pivot) if moved else 0.0
        )
        turn = np.linalg.norm(vector_from_rotation(R @ goal[0].T)) if moved else 0.0
        radian = self.instance.units.angle.in_radians
        values = values_at(self.instance, R, T)
        met = self._slack.met(R, T) if moved else ()
        return NearestPose(
            R, T, readings_of(self.instance, values), float(shift), float(turn / radian), met, way
        )


class _Slack:
    """How far poses are within their limits, as lengths, and the derivatives by a twist.

    The limits are narrower by a margin. The order is: lower ends of ranges, upper ends, cones.
    """

    def __init__(self, instance: Instance, low: Array, high: Array) -> None:
        self.bodies = arrangement = Arrangement.of(instance)
        self.length = arrangement.length
        self.low_of, self.high_of = (
            np.flatnonzero(np.isfinite(low)),
            np.flatnonzero(np.isfinite(high)),
        )
        #: What a value is multiplied by: angles are in radians times the length.
        self.units = np.ones(6)
        self.units[arrangement.angles] = self.length
        radians = np.ones(6)
        radians[arrangement.angles] = arrangement.in_radians
        with np.errstate(invalid="ignore"):
            # A range of one number has no margin.
            margin = np.fmin(_MARGIN * self.length / self.units, (high - low) * radians / 4)
        self.low, self.high = low * radians + margin, high * radians - margin
        self.cones = joint_cones(instance)
        self.legs = np.array([one.constraint for one in self.cones], int)
        self.on_base = np.array([one.body == "base" for one in self.cones], bool)
        self.axes = np.array([one.cone.unit for one in self.cones]).reshape(-1, 3)
        angles = np.array([one.cone.half_angle.value for one in self.cones])
        self.half = angles * arrangement.in_radians - _MARGIN

    def at(self, R: Array, T: Array) -> tuple[Array, Array]:
        """Return the slack and its derivatives at poses, shapes (..., c) and (..., c, 6)."""
        value = measured(self.bodies, R, T) * self.units
        with np.errstate(all="ignore"):
            slope = np.nan_to_num(jacobian(self.bodies, R, T)) * self.units[:, None]
        low, high = self.low_of, self.high_of
        tilt, tilting = self._tilts(R, T)
        room = (
            value[..., low] - (self.low * self.units)[low],
            (self.high * self.units)[high] - value[..., high],
            self.length * (self.half - tilt),
        )
        slopes = (slope[..., low, :], -slope[..., high, :], -self.length * tilting)
        return np.concatenate(room, axis=-1), np.concatenate(slopes, axis=-2)

    def rounded(self, R: Array, T: Array) -> tuple[Array, Array]:
        """Return a pose with decimals that rounding errors of the search do not reach."""
        quaternion = np.round(quaternion_from_rotation(R), _DECIMALS)
        decimals = _DECIMALS - int(np.ceil(np.log10(self.length)))
        return rotation_from_quaternion(unit_quaternion(quaternion)), np.round(T, decimals)

    def met(self, R: Array, T: Array) -> tuple[str, ...]:
        """Return the names of the limits that a pose meets."""
        near = self.at(R, T)[0] < _MET * self.length
        names = [f"range of {k + 1}" for k in (*self.low_of.tolist(), *self.high_of.tolist())]
        names += [f"cone of {one.name} at leg {one.constraint + 1}" for one in self.cones]
        return tuple(dict.fromkeys(name for name, at in zip(names, near, strict=True) if at))

    def _tilts(self, R: Array, T: Array) -> tuple[Array, Array]:
        """Return the angles of legs to the axes of their cones, and the derivatives.

        Of a leg along its axis the angle has none, and zeros are returned.
        """
        if not len(self.legs):
            return np.zeros((*T.shape[:-1], 0)), np.zeros((*T.shape[:-1], 0, 6))
        placed = self.bodies.placed(R, T)
        sign = np.where(self.on_base, 1.0, -1.0)[:, None]
        leg, arm = sign * placed.r[..., self.legs, :], placed.arm[..., self.legs, :]
        base = self.on_base[:, None]
        axis = np.where(base, self.axes, apply(R[..., None, :, :], self.axes))
        size = np.sqrt(dot(leg, leg))[..., None]
        with np.errstate(all="ignore"):
            direction = leg / size
            along = dot(axis, direction)[..., None]
            sine = np.sqrt(dot(cross(axis, direction), cross(axis, direction)))[..., None]
            # The angle falls by how far the direction comes to the axis, and the axis to it.
            towards = sign * (axis - along * direction) / (size * sine)
            turned = cross(axis, direction) / sine
        known = np.isfinite(towards).all(axis=-1, keepdims=True)
        towards, turned = np.where(known, towards, 0.0), np.where(known, turned, 0.0)
        moment = cross(arm, towards) + np.where(base, 0.0, turned)
        slopes = -np.concatenate((moment, towards), axis=-1)
        tilt: Array = np.arctan2(sine, along)[..., 0]
        return np.nan_to_num(tilt), slopes


class _Distance(NamedTuple):
    """Half the square of the distance from a goal, with gradient and Hessian by a twist."""

    value: float
    gradient: Array
    hessian: Array


def _distance(
    pose: tuple[Array, Array], goal: tuple[Array, Array], pivot: Array, length: float
) -> _Distance:
    (R, T), (R0, T0) = pose, goal
    w = vector_from_rotation(R @ R0.T)
    arm = R @ pivot
    off = T + arm - T0 - R0 @ pivot
    theta = float(np.linalg.norm(w))
    value = float(off @ off + (length * theta) ** 2) / 2
    gradient = np.concatenate((length**2 * w + np.cross(arm, off), off))
    across = 1.0 if theta < 1e-6 else max(theta / 2 / np.tan(theta / 2), 0.0)
    axis = w / theta if theta > 0 else np.zeros(3)
    turning = across * np.eye(3) + (1 - across) * np.outer(axis, axis)
    # The velocity of the pivot is v + omega x arm.
    moved = np.concatenate((np.cross(np.eye(3), arm).T, np.eye(3)), axis=1)
    hessian = moved.T @ moved
    hessian[:3, :3] += length**2 * turning
    return _Distance(value, gradient, hessian)


def _nearest(
    slack: _Slack, goal: tuple[Array, Array], start: tuple[Array, Array], pivot: Array
) -> tuple[tuple[Array, Array], float]:
    """Return a pose within the limits to which no small motion leads nearer, and its distance.

    Sequential quadratic programming: the distance with the curvature of the limits, weighted by
    their multipliers, under linearized limits. If the search fails, a pose that violates limits is
    returned.
    """
    length = slack.length
    sizes = np.array([1 / length] * 3 + [1.0] * 3)
    pose, weight = start, 1.0
    room, slopes = slack.at(*pose)
    multipliers = np.zeros(len(room))
    now = _distance(pose, goal, pivot, length)
    for _ in range(_STEPS):
        step, multipliers = _step(slack, pose, now, room, slopes, multipliers, sizes)
        size = float(np.linalg.norm(step / sizes))
        if size > _LONGEST * length:
            step *= _LONGEST * length / size
            size = _LONGEST * length
        weight = max(weight, 2 * float(multipliers.sum()))
        before = now.value + weight * np.maximum(-room, 0).sum()
        for _ in range(_HALVINGS):
            moved = rotation_from_vector(step[:3]) @ pose[0], pose[1] + step[3:]
            room, slopes = slack.at(*moved)
            now = _distance(moved, goal, pivot, length)
            after = now.value + weight * np.maximum(-room, 0).sum()
            if after <= before * (1 + 1e-13) or size < _SHORT * length:
                break
            step, size = step / 2, size / 2
        pose = moved
        if size < _SHORT * length:
            break
    return pose, float(np.sqrt(2 * now.value))


def _step(
    slack: _Slack,
    pose: tuple[Array, Array],
    now: _Distance,
    room: Array,
    slopes: Array,
    multipliers: Array,
    sizes: Array,
) -> tuple[Array, Array]:
    """Return the twist of the quadratic problem, and the multipliers of the limits there."""
    hessian = now.hessian.copy()
    if multipliers.any():
        hessian -= _curvature(slack, pose, slopes, multipliers, sizes)
    # In lengths: a positive definite matrix near to the Hessian.
    size, axes = np.linalg.eigh(sizes[:, None] * hessian * sizes)
    root = sizes[:, None] * axes / np.sqrt(np.maximum(size, _CURVATURE))
    # With twist = root z the distance is |z + pull|^2 / 2 up to a constant.
    pull = root.T @ now.gradient
    normals = slopes @ root
    norms = np.linalg.norm(normals, axis=1)
    norms = np.where(norms > 0, norms, 1.0)
    shortest = shortest_step(normals / norms[:, None], (normals @ pull - room) / norms)
    if shortest is None:
        # The linearized limits contradict each other: reduce the violation.
        bad = room < 0
        scaled = slopes[bad] * sizes
        step = sizes * np.linalg.lstsq(scaled, -room[bad], rcond=1e-3)[0]
        return step, np.zeros(len(room))
    step = root @ (shortest - pull)
    found = np.zeros(len(room))
    met = room + slopes @ step < 1e-7 * slack.length
    if met.any():
        # Of the gradient in lengths: ``gradient + hessian step = slopes^T multipliers``.
        rest = root.T @ (slopes[met].T)
        found[met] = nonnegative_least_squares(rest, shortest)
    return step, found


def _curvature(
    slack: _Slack, pose: tuple[Array, Array], slopes: Array, multipliers: Array, sizes: Array
) -> Array:
    """Return the second derivatives of the slack, weighted, by differences of the slopes."""
    R, T = pose
    steps = _DIFFERENCE * np.array([1.0] * 3 + [slack.length] * 3)
    turned = np.stack(
        [rotation_from_vector(h * e) @ R for h, e in zip(steps[:3], np.eye(3), strict=True)]
        + [R] * 3
    )
    shifted = T + np.concatenate((np.zeros((3, 3)), np.diag(steps[3:])))
    change = np.einsum("c,jci->ji", multipliers, slack.at(turned, shifted)[1] - slopes)
    matrix = change / steps[:, None]
    return np.asarray((matrix + matrix.T) / 2)


def _same(a: tuple[Array, Array], b: tuple[Array, Array], length: float) -> bool:
    turn = float(np.abs(a[0] - b[0]).max())
    return turn < _MET and float(np.abs(a[1] - b[1]).max()) < _MET * length
