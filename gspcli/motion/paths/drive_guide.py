"""Straight ways of drives: all cranks, slides and driven values change linearly.

A mode is followed along them by `MovingGeometry`, which proves that it exists, is regular and is
the only one near. Ranges are intervals, so a way keeps those that its ends keep; cones are proved
by `limit_events`. No drive passes a dead point: each half of the way between two rows is in a box
about the row at its end in which all drives are proved to keep their knees.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose
from gspcli.geometry.enclosures import OUT
from gspcli.motion.following.branch_follower import FollowOptions
from gspcli.motion.following.branch_runs import Run
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.row_instances import over_rows
from gspcli.motion.following.tracks import Track
from gspcli.motion.paths.between import PathRows
from gspcli.motion.paths.ends import PathEnd
from gspcli.motion.paths.guides import GuideRows, RowsOnWay, on_polygon
from gspcli.motion.paths.limit_events import limit_events
from gspcli.motion.paths.motors import Motors
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.value_ways import ValueWays
from gspcli.motion.singularities.neighbourhoods import DrivenNeighbourhood

Array = NDArray[np.float64]

#: How often steps between rows are halved at most for knees to be proved.
_HALVINGS = 5


class DriveGuide:
    """Straight ways of drives between two poses.

    Parameters
    ----------
    motors
        The drives of the platform.
    ways
        Straight ways of poses of the platform, for the rows.
    start, goal
        The ends.
    clear
        The clearance of the drives that every pose must have.
    gap
        The least gap between legs and bodies; None if gaps are not tested.
    """

    along = "drives"

    def __init__(
        self,
        motors: Motors,
        ways: PoseWays,
        start: PathEnd,
        goal: PathEnd,
        clear: float = 0.0,
        gap: float | None = None,
    ) -> None:
        self.motors, self.ways, self.start, self.goal = motors, ways, start, goal
        self.clear, self.gap = clear, gap
        drives = motors.drives
        moved = np.flatnonzero(drives.moved).tolist()
        self._chosen = choose(motors.instance, [drives.names[k] for k in moved])
        self._moved = moved
        self.sizes = np.ones(drives.count)

    @property
    def corners(self) -> Array:
        """The numbers of the drives at both ends, in the units of the instance, (2, m)."""
        R, T = (np.stack([getattr(end, n) for end in (self.start, self.goal)]) for n in ("R", "T"))
        found: Array = self.motors.numbers(R, T) / self.motors.drives.units
        return found

    def trace(self, corners: Array, rows: NDArray[np.int64]) -> GuideRows | None:
        """Return rows along a polygon, or None; see `Guide`."""
        return self.through(on_polygon(corners, rows))

    def through(self, given: RowsOnWay) -> GuideRows | None:
        """Return given rows with their poses, or None if the way through them is not proved."""
        drives = self.motors.drives
        q = given.numbers * drives.units
        followed = self._followed(given.numbers)
        if followed.events or np.isnan(followed.T).any() or limit_events(followed):
            return None
        R, T = followed.R[0], followed.T[0]
        geometry = MovingGeometry(followed.followed, self._chosen)
        ends = ValueWays.same(*(geometry.points(*one) for one in self._ends(R, T)))
        if not ends.all():
            return None
        proofs = np.zeros(int(given.part[-1]) + 1, np.int64)
        for k, part in enumerate(given.part[:-1].tolist()):
            pieces = self._keeps_knees(given.numbers[k : k + 2], R[k], T[k], _HALVINGS)
            if not pieces:
                return None
            proofs[part] += pieces
        rows = PathRows(
            self.ways, followed.values, R, T, motors=self.motors, numbers=q, geometry=geometry
        )
        trace = GuideRows(given.part, given.fraction, followed.values, R, T, proofs, rows, q)
        return trace if trace.keeps(self.clear, self.gap) else None

    def placed(self, corner: Array) -> Array:
        """Return a corner unchanged."""
        return corner

    def unproved(self, corners: Array, rows: NDArray[np.int64]) -> None:
        """Return nothing: poses for drives are found by following them."""
        del corners, rows

    def _ends(self, R: Array, T: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        first, last = self.start, self.goal
        wanted = np.stack((first.R, last.R)), np.stack((first.T, last.T))
        return (R[[0, -1]], T[[0, -1]]), wanted

    def _followed(self, numbers: Array) -> Track:
        """Follow the mode of the start along rows of drives, in the units of the instance."""
        instance, drives = self.motors.instance, self.motors.drives
        a = Arrangement.of(instance)
        stated = np.where(a.sides < 0, -a.values, a.values)
        values = np.tile(stated, (len(numbers), 1))
        for k in range(drives.count):
            if not drives.moved[k]:
                values[:, drives.users(k)[0]] = numbers[:, k]
        rows = np.column_stack((values, numbers[:, self._moved]))
        geometry = MovingGeometry(over_rows(instance, rows), self._chosen)
        run = Run(instance, geometry, np.arange(1.0, len(rows) + 1), rows, FollowOptions())
        return run.follow(self.start.R[None], self.start.T[None], np.ones(1, np.int64))

    def _keeps_knees(self, numbers: Array, R: Array, T: Array, halvings: int) -> int:
        """Return in how many boxes all knees are proved to be kept after a row; 0 without proof."""
        drives = self.motors.drives
        q = numbers * drives.units
        near = DrivenNeighbourhood(drives, R, T, q[0])
        widths = near.widths(np.abs(q[1] - q[0])[drives.index] * OUT)[None]
        if near.keeps_knees(widths, near.box(widths))[0]:
            return 1
        if not halvings:
            return 0
        there = self._middle(q, R, T)
        if there is None:
            return 0
        middle = numbers.mean(axis=0)
        first = self._keeps_knees(np.stack((numbers[0], middle)), R, T, halvings - 1)
        second = first and self._keeps_knees(np.stack((middle, numbers[1])), *there, halvings - 1)
        return first + second if second else 0

    def _middle(self, q: Array, R: Array, T: Array) -> tuple[Array, Array] | None:
        """Return the pose in the middle of a way of drives from a pose; None if it is not found.

        Parameters
        ----------
        q
            The drives at both ends, shape (2, m).
        R, T
            The pose at the first.
        """
        numbers = np.stack((q[0], q.mean(axis=0))) / self.motors.drives.units
        begin = PathEnd("", np.zeros(6), R, T)
        followed = DriveGuide(self.motors, self.ways, begin, begin)._followed(numbers)
        if followed.events or np.isnan(followed.T).any():
            return None
        return followed.R[0, -1], followed.T[0, -1]
