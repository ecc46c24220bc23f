"""Assembly modes followed while values and drives move, each step proved.

`MovingPlatform` moves its values only (native/branch_follower.cpp). `MovingGeometry`, which is
slower, also moves cranks and slides.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import DLL
from gspcli.certification.branches.curves import follow_closely
from gspcli.certification.branches.parametric_quadrics import (
    MovingEquations,
    Shape,
    ValueFunction,
    moving_equations,
)
from gspcli.certification.branches.taylor import MovingSystem, equations_at
from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.continuation.tracker import helpful
from gspcli.errors import ArgumentError
from gspcli.geometry.coordinates import Coordinate, moved
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import pose_from_study, study_from_pose
from gspcli.motion.following.follower import FRAME_ERROR, RowFollower, Segments
from gspcli.records import dataclass

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Stop(IntEnum):
    """How following a branch ended; the numbers are those of native/branch_follower.hpp."""

    END = 0
    """The branch was followed to the last row."""
    STEP = 1
    """The step became too small: a fold, or another singular pose."""
    START = 2
    """Newton's method found no pose at the first row."""


@dataclass(frozen=True)
class FollowOptions:
    """Options of following branches."""

    #: Whether each segment is proved to be one branch with no other near it. Without proof a branch
    #: may jump to another one: its points are solutions of Newton's method.
    certify: bool = True
    #: How often the step between two rows may be halved before the branch ends. After 40 halvings
    #: the step is 1e-12 of the distance between the rows.
    most_halvings: int = 40
    #: Threads. The answer does not depend on them.
    jobs: int = 1
    #: Name of the kernel's build; if empty, the quickest one for this processor.
    build: str = ""


@dataclass(frozen=True, eq=False)
class Branches:
    """Followed branches, n of them over r rows."""

    #: Study points of norm one, lengths in the unit of the equations, shape (n, r, 8); NaN after
    #: the end of a branch.
    points: Array
    #: A `Stop` each, shape (n,).
    stop: NDArray[np.int32]
    #: The last row reached (from 0), and the part of the step to the next one that was followed
    #: beyond it, shape (n,).
    reached: NDArray[np.int32]
    fraction: Array
    #: The last point, shape (n, 8).
    last: Array
    #: The numbers of segments that were proved and that were tried, shape (n,).
    segments: Index
    tries: Index
    #: The largest measure of a proof (it is below one), shape (n,).
    worst: Array
    #: A bound of the distance of ``last`` from the proved pose, in units of Study points of norm
    #: one, shape (n,).
    near: Array

    @classmethod
    def not_started(cls, start: Array, rows: int) -> Branches:
        """Return branches at the first row, before any step."""
        count = len(start)
        return cls(
            points=np.full((count, rows, 8), np.nan),
            stop=np.full(count, Stop.START, np.int32),
            reached=np.full(count, -1, np.int32),
            fraction=np.zeros(count),
            last=start.copy(),
            segments=np.zeros(count, np.int64),
            tries=np.zeros(count, np.int64),
            worst=np.zeros(count),
            near=np.zeros(count),
        )


class StudyUnits(ABC):
    """Study points with lengths in units of a scale, in frames near the bodies."""

    #: The shapes of the equations, shape (6,).
    shapes: NDArray[np.int32]

    def __init__(self, scale: float, local_frames: LocalFrames) -> None:
        self.scale = scale
        self.local_frames = local_frames

    def points(self, R: Array, T: Array) -> Array:
        """Return Study points of norm one of poses, shape (..., 8)."""
        places = self.local_frames.doubles(R, T)
        points = np.concatenate(study_from_pose(R, places / self.scale), axis=-1)
        return np.ascontiguousarray(points / np.linalg.norm(points, axis=-1, keepdims=True))

    def poses(self, points: Array) -> tuple[Array, Array]:
        """Return the poses (R, T) of Study points, ``(..., 8) -> (..., 3, 3), (..., 3)``.

        The pose of a point at infinity is not finite.
        """
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            R, T = pose_from_study(points[..., :4], points[..., 4:])
            return R, self.local_frames.doubles_back(R, T * self.scale)

    @abstractmethod
    def quadrics(self, row: Array) -> tuple[Array, Array]:
        """Return the equations at an internal row, as `MovingSystem.at`."""

    def jacobian(self, point: Array, row: Array) -> Array:
        """Return the derivatives of the seven equations at a Study point, shape (7, 8)."""
        rows: Array = equations_at(self.shapes, *self.quadrics(row), point[None])[1][0]
        return rows


def apart(instance: Instance) -> Instance:
    """Return an instance whose distances of lines are not zero, for values that move from zero.

    The mutual moment is the equation of lines that meet, but not that of a growing distance.
    """
    zero = {
        k: Number.of(1)
        for k, constraint in enumerate(instance.constraints)
        if constraint.kind is DLL and constraint.value.fraction == 0
    }
    return instance.with_values(zero) if zero else instance


class MovingPlatform(StudyUnits):
    """An instance whose values move, prepared for following many branches.

    Parameters
    ----------
    instance
        The geometry and units. Its values give the size of the platform, and a DLL of value zero
        stays zero; otherwise they are not used.
    local_frames
        The frames of the equations; None stands for frames near the bodies.
    """

    #: No coordinates move.
    chosen: tuple[Coordinate, ...] = ()

    def __init__(self, instance: Instance, local_frames: LocalFrames | None = None) -> None:
        self.instance = instance
        local_frames = local_frames or LocalFrames.of(instance)
        #: The instance in frames near the bodies.
        self.near = local_frames.applied(instance)
        self.equations: MovingEquations = moving_equations(self.near)
        self.shapes = self.equations.shapes
        super().__init__(self.equations.scale, local_frames)
        self._angles = np.isin(self.equations.laws, (ValueFunction.COSINE, ValueFunction.SINE))
        radian = instance.units.angle.in_radians
        self._units = np.where(self._angles, radian, 1 / self.equations.scale)

    @cached_property
    def system(self) -> MovingSystem:
        """The equations in ball arithmetic."""
        return MovingSystem(self.near, ())

    def instance_at(self, row: Array) -> Instance:
        """Return the instance; its values are not used."""
        return self.instance

    def internal(self, values: Array) -> Array:
        """Return values, shape (..., 6), with lengths in units of the scale, angles in radians."""
        return np.ascontiguousarray(values * self._units)

    def coefficients(self, values: Array) -> Array:
        """Return c of the equations for internal values, shape (..., 6)."""
        laws, signs = self.equations.laws, self.equations.signs
        return np.select(
            [
                laws == ValueFunction.SQUARE,
                laws == ValueFunction.LINEAR,
                laws == ValueFunction.COSINE,
            ],
            [values**2, values, signs * np.cos(values)],
            signs * np.sin(values),
        )

    def slopes(self, values: Array) -> Array:
        """Return the derivatives of c by internal values, shape (..., 6)."""
        laws, signs = self.equations.laws, self.equations.signs
        return np.select(
            [
                laws == ValueFunction.SQUARE,
                laws == ValueFunction.LINEAR,
                laws == ValueFunction.COSINE,
            ],
            [2 * values, np.ones_like(values), -signs * np.sin(values)],
            signs * np.cos(values),
        )

    def quadrics(self, values: Array) -> tuple[Array, Array]:
        """Return the equations at internal values, as `MovingSystem.at`."""
        c, lines = self.coefficients(values), self.equations.shapes == Shape.LINES
        found = self.equations.hessians.copy()
        found[:, 0] -= np.where(lines, 0.0, c)[:, None, None] * np.diag([2.0] * 4 + [0.0] * 4)
        return found[None], np.where(lines, c, 0.0)[None]

    def follow(
        self,
        values: Array,
        trajectory: Index,
        start: Array,
        options: FollowOptions | None = None,
        near: Array | None = None,
    ) -> Branches:
        """Follow branches along trajectories of values, which are linear between their rows.

        Parameters
        ----------
        values
            Internal values, shape (trajectories, rows, 6).
        trajectory
            The trajectory of each branch, shape (n,).
        start
            Study points near the branches at the first rows, shape (n, 8).
        options
            How to follow branches.
        near
            The distance of the pose from its start, if another pose may be as near, shape (n,).
            Zero, or None for all, stands for the pose that Newton's method finds.
        """
        equations, options = self.equations, options or FollowOptions()
        low, high = self._bounds(values)
        points, stop, reached, part, last, _, segments, tries, worst, close, _ = _kernel.follow(
            equations.shapes,
            equations.laws,
            equations.signs,
            np.maximum(np.abs(low), np.abs(high)),
            equations.spectral_between(low, high),
            equations.hessians,
            equations.spectral,
            equations.moduli,
            np.ascontiguousarray(values),
            np.ascontiguousarray(trajectory, np.int64),
            np.ascontiguousarray(start),
            np.zeros(len(start)) if near is None else near,
            certify=options.certify,
            most_halvings=options.most_halvings,
            jobs=helpful(options.jobs, len(start)),
            build=options.build,
        )
        return Branches(points, stop, reached, part, last, segments, tries, worst, close)

    def _bounds(self, values: Array) -> tuple[Array, Array]:
        """Return bounds of c over all trajectories, shapes (6,); the trivial ones for angles."""
        least, most = values.min(axis=(0, 1)), values.max(axis=(0, 1))
        laws = self.equations.laws
        square = laws == ValueFunction.SQUARE
        far = np.maximum(np.abs(least), np.abs(most))
        # A distance changes its sign along a segment only if its signs at the ends differ.
        low = np.where(square, np.where(least * most > 0, np.minimum(least**2, most**2), 0), least)
        high = np.where(square, far**2, most)
        outward = 1e-12 * far ** np.where(square, 2, 1)
        angles = self._angles
        return (np.where(angles, -1.0, low - outward), np.where(angles, 1.0, high + outward))


def over_rows(instance: Instance, rows: Array) -> Instance:
    """Return the instance for following along rows; a value is zero if it is so at all rows."""
    values = rows[:, :6]
    return at_values(instance, values[np.abs(values).argmax(axis=0), np.arange(6)])


def at_values(instance: Instance, values: Array) -> Instance:
    """Return an instance with other values; a signed distance to a plane becomes a side."""
    constraints = []
    for constraint, value in zip(instance.constraints, values[:6].tolist(), strict=True):
        side = constraint.side
        if constraint.kind.has_sides:
            side = Side.NEGATIVE if value < 0 else Side.POSITIVE
            value = abs(value)
        constraints.append(replace(constraint, value=Number.of(value), side=side))
    return replace(instance, constraints=tuple(constraints))


def along_rows(instance: Instance, rows: Array, R: Array) -> Instance:
    """Return the instance for following along rows, with points for lines that stay parallel.

    Lines are replaced if only values of DLL change and the lines are parallel at every pose that
    satisfies the other constraints: a plate that slides on a table. Lines that only pass through
    parallel positions are not replaced: their distance jumps there.

    Parameters
    ----------
    instance
        The platform.
    rows
        The values, shape (r, 6).
    R
        The rotations at the first row, shape (n, 3, 3).
    """
    return over_rows(_with_points(at_values(instance, rows[0]), rows[:, :6], R), rows)


def _with_points(instance: Instance, values: Array, R: Array) -> Instance:
    lines = np.array([row.kind is DLL for row in instance.constraints])
    still = (np.ptp(values[:, ~lines], axis=0) == 0).all()
    if not (lines.any() and still and len(R)):
        return instance
    # Counting is imported only here: few platforms have such lines.
    from gspcli.certification.counting import with_points_for_lines
    from gspcli.certification.poses.multiple import nearly_parallel

    if not nearly_parallel(instance, R.astype(complex)).any(axis=1).all():
        return instance
    return with_points_for_lines(instance) or instance


class MovingGeometry(StudyUnits):
    """An instance whose values and coordinates move, prepared for following branches.

    It is used like `MovingPlatform`; the rows have the six values and then the coordinates, in the
    units of the instance, inside as outside.

    Parameters
    ----------
    instance
        The units and all numbers that do not move.
    chosen
        The coordinates that move.
    """

    def __init__(self, instance: Instance, chosen: Sequence[Coordinate]) -> None:
        self.instance = instance
        self.chosen = tuple(chosen)
        self.system = MovingSystem(instance, chosen)
        self.shapes = self.system.shapes
        super().__init__(self.system.scale, LocalFrames.none())

    def internal(self, rows: Array) -> Array:
        """Return rows unchanged."""
        return np.ascontiguousarray(rows)

    def instance_at(self, row: Array) -> Instance:
        """Return the instance with the coordinates of a row; its values are not used."""
        return moved(self.instance, self.chosen, row[6:])

    @cached_property
    def rows(self) -> RowFollower | None:
        """The step along rows; None if it does not know such drives."""
        try:
            return RowFollower(self.instance, self.chosen)
        except ArgumentError:
            return None

    def quadrics(self, row: Array) -> tuple[Array, Array]:
        """Return the equations at a row, as `MovingSystem.at`."""
        return self.system.at((row, row), 0.0)

    def follow(
        self,
        values: Array,
        trajectory: Index,
        start: Array,
        options: FollowOptions,
        near: Array | None = None,
    ) -> Branches:
        """Follow branches along trajectories, which are linear between their rows.

        They are followed by the step of the controller or, where it does not know what moves, in
        arcs with ball arithmetic. Each segment is proved.

        Parameters
        ----------
        values
            Rows, shape (trajectories, rows, 6 + drives).
        trajectory, start, near
            As for `MovingPlatform.follow`.
        options
            Only ``most_halvings`` is used.
        """
        found = Branches.not_started(start, values.shape[1])
        for k, t in enumerate(trajectory.tolist()):
            room = 0.0 if near is None else float(near[k])
            if self.rows is not None and self.rows.knows(values[t]):
                self._in_steps(self.rows, found, k, values[t], room, options)
            else:
                self._in_arcs(found, k, values[t], room)
        return found

    def _in_steps(
        self,
        follower: RowFollower,
        found: Branches,
        k: int,
        rows: Array,
        near: float,
        options: FollowOptions,
    ) -> None:
        """Follow a branch by the step of the controller."""
        R, T = self.poses(found.last[k])
        twist = self._twist(found.last[k], T, near) if near else 0.0
        if not (np.isfinite(T).all() and np.isfinite(twist)):
            return
        mode = follower.follow(rows, R, T, twist, shortest=2.0**-options.most_halvings, keep=True)
        if mode.reached < 0:
            return
        points = _of_one_sign(self.points(mode.R, mode.T), found.last[k])
        found.points[k, : len(points)] = points
        found.last[k] = _of_one_sign(self.points(*mode.last)[None], points[-1])[0]
        found.stop[k] = Stop.END if mode.reached + 1 == len(rows) else Stop.STEP
        found.reached[k], found.fraction[k] = mode.reached, mode.part
        found.near[k] = near
        if mode.steps and found.stop[k] == Stop.STEP:
            self._back_up(follower, found, k, mode.segments)
        found.segments[k], found.tries[k], found.worst[k] = mode.steps, mode.tries, mode.worst

    def _back_up(self, follower: RowFollower, found: Branches, k: int, segments: Segments) -> None:
        """Go back to the last segment whose end is known so well that no other pose is as near."""
        found.near[k] = np.nan
        for j in range(len(segments.row) - 1, -1, -1):
            part = float(segments.end[j])
            if segments.row[j] < found.reached[k]:
                if segments.row[j] + 1 < found.reached[k] or part < 1:
                    return
                part = 0.0
            R, T = (x[0] for x in segments.chord(np.array([j]), np.ones(1)))
            T = T * follower.reach + follower.origin - R @ follower.middle
            point = _of_one_sign(self.points(R, T)[None], found.last[k])[0]
            distance = self._distance(float(segments.error[j]) * follower.reach)
            if self._twist(point, T, distance) < segments.alone[j] * follower.reach:
                found.last[k], found.fraction[k], found.near[k] = point, part, distance
                return

    def _in_arcs(self, found: Branches, k: int, rows: Array, near: float) -> None:
        """Follow a branch in arcs."""
        found.stop[k], found.points[k, 0], found.near[k] = Stop.STEP, found.last[k], near
        for row in range(len(rows) - 1):
            found.reached[k], found.fraction[k] = row, 0.0
            ends = rows[row], rows[row + 1]
            way = follow_closely(self.system, ends, found.last[k], 0.0, float(found.near[k]))
            if way is None:
                return
            found.last[k], found.fraction[k], found.near[k], count = way
            found.segments[k] += count
            if found.fraction[k] < 1:
                return
            found.points[k, row + 1] = found.last[k]
        found.stop[k], found.reached[k], found.fraction[k] = Stop.END, len(rows) - 1, 0.0

    def _distance(self, error: float) -> float:
        """Bound the distance of Study points of norm one, from that of poses (a twist, a length).

        A twist (w, t) moves e by |w| / 2 at most, and T e / 2 by half the shift of the origin and
        by |T| |w| / 4: less, since the norm is at least |T| / 2, when it is scaled to one.
        """
        assert self.rows is not None
        reach, away = self.rows.reach, float(np.linalg.norm(self.rows.middle))
        return 1.01 * error / reach * (1 + (reach + away) / (2 * self.scale)) + FRAME_ERROR

    def _twist(self, point: Array, T: Array, distance: float) -> float:
        """Bound the twist between poses, as a length, from the distance of their Study points.

        With d the distance divided by |e|, the directions of e differ by less than 4 d / 3, so that
        the angle is below 4.2 d, and T differs by less than (3 + 3 |T|) d.
        """
        assert self.rows is not None
        d = distance / float(np.linalg.norm(point[:4]))
        if not d < 0.01:
            return np.inf
        reach, away = self.rows.reach, float(np.linalg.norm(self.rows.middle))
        far = 3 * (self.scale + float(np.linalg.norm(T)))
        return d * (4.2 * (reach + away) + far) + FRAME_ERROR * (reach + far + away)


def _of_one_sign(points: Array, like: Array) -> Array:
    """Return Study points of a branch with the sign of the first one, like another point."""
    before = np.concatenate((like[None], points[:-1]))
    signs = np.where(np.sum(points * before, axis=1) < 0, -1.0, 1.0)
    return points * np.cumprod(signs)[:, None]
