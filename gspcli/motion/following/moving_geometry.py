"""An instance whose coordinates and values move, prepared for following branches.

It is slower than `MovingPlatform`, in which only values move.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.arcs import follow_closely
from gspcli.certification.branches.taylor import MovingSystem
from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.errors import ArgumentError
from gspcli.geometry.coordinates import Coordinate, moved
from gspcli.geometry.instance import Instance
from gspcli.motion.following.branch_follower import Branches, FollowOptions, Stop, StudyUnits
from gspcli.motion.following.followed_rows import FRAME_ERROR, RowFollower, Segments

Array = NDArray[np.float64]
Index = NDArray[np.int64]


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
