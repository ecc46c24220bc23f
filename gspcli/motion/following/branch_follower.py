"""Assembly modes followed while values change, each step proved (native/branch_follower.cpp)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import DLL
from gspcli.certification.branches.parametric_quadrics import (
    MovingEquations,
    Shape,
    ValueFunction,
    moving_equations,
)
from gspcli.certification.branches.taylor import MovingSystem, equations_at
from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.continuation.tracker import helpful
from gspcli.geometry.coordinates import Coordinate
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import pose_from_study, study_from_pose
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
    """Options of following branches.

    Attributes
    ----------
    certify
        Whether each segment is proved to be one branch with no other near it. Without proof a
        branch may jump to another one: its points are solutions of Newton's method.
    most_halvings
        How often the step between two rows may be halved before the branch ends. After 40 halvings
        the step is 1e-12 of the distance between the rows.
    jobs
        Threads. The answer does not depend on them.
    build
        Name of the kernel's build; if empty, the quickest one for this processor.
    """

    certify: bool = True
    most_halvings: int = 40
    jobs: int = 1
    build: str = ""


@dataclass(frozen=True, eq=False)
class Branches:
    """Followed branches, n of them over r rows.

    Attributes
    ----------
    points
        Study points of norm one, lengths in the unit of the equations, shape (n, r, 8); NaN after
        the end of a branch.
    stop
        A `Stop` each, shape (n,).
    reached, fraction
        The last row reached (from 0), and the part of the step to the next one that was followed
        beyond it, shape (n,).
    last
        The last point, shape (n, 8).
    segments, tries
        The numbers of segments that were proved and that were tried, shape (n,).
    worst
        The largest measure of a proof (it is below one), shape (n,).
    near
        A bound of the distance of ``last`` from the proved pose, in units of Study points of norm
        one, shape (n,).
    """

    points: Array
    stop: NDArray[np.int32]
    reached: NDArray[np.int32]
    fraction: Array
    last: Array
    segments: Index
    tries: Index
    worst: Array
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
