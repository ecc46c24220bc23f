"""Rows of values and drives at the nodes of a scan, and the platform that moves along them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose, drive_corrections
from gspcli.geometry.drives import Drives
from gspcli.geometry.quaternions import Field
from gspcli.geometry.readings import values_of
from gspcli.motion.files.value_files import nominal_values
from gspcli.motion.following.branch_follower import FollowOptions, MovingPlatform
from gspcli.motion.following.branch_runs import Run
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.row_instances import at_values
from gspcli.motion.following.tracks import Track
from gspcli.motion.following.trajectories import track
from gspcli.motion.singularities.value_scans import Scan, moved_to
from gspcli.solver import solve, solve_batch

Array = NDArray[np.float64]


class ScanRows:
    """The rows of a scan: six values, then the numbers of the drives that vary.

    Parameters
    ----------
    found
        The scan; its values have no offsets and scales any more, its drives have theirs.

    Attributes
    ----------
    varied
        The entries of a row that vary, one of each axis.
    scales, added
        The number of each axis is its reading times the scale, plus what is added; shape (axes,).
    """

    def __init__(self, found: Scan) -> None:
        self.found = found
        drives = [axis.drive for axis in found.axes if axis.drive]
        self._chosen = choose(found.instance, drives)
        self._values = nominal_values(found.instance)
        self.varied = [
            6 + drives.index(axis.drive) if axis.drive else axis.constraint for axis in found.axes
        ]
        self.scales, self.added = np.ones(len(found.axes)), np.zeros(len(found.axes))
        moves = np.array([bool(axis.drive) for axis in found.axes])
        self.added[moves], self.scales[moves] = drive_corrections(found.instance, self._chosen)

    @property
    def low(self) -> Array:
        """The first node of each axis, as it is read."""
        return np.array([axis.values[0] for axis in self.found.axes])

    @property
    def high(self) -> Array:
        """The last node of each axis, as it is read."""
        return np.array([axis.values[-1] for axis in self.found.axes])

    def read(self, node: Sequence[int]) -> Array:
        """Return what varies at a node, as it is read, shape (axes,)."""
        pairs = zip(self.found.axes, node, strict=True)
        return np.array([axis.values[k] for axis, k in pairs])

    def row(self, read: Array) -> Array:
        """Return the row of what varies, as it is read: values and numbers of drives."""
        row = np.concatenate((self._values, np.zeros(len(self._chosen))))
        row[self.varied] = read * self.scales + self.added
        return row

    def platform(self) -> MovingPlatform | MovingGeometry:
        """Return the platform that moves with what varies."""
        there = at_values(self.found.instance, self.row(self.high))
        return MovingGeometry(there, self._chosen) if self._chosen else MovingPlatform(there)

    def track(self, start: Sequence[int], goal: Sequence[int], seed: int) -> Track:
        """Follow all real modes from one node to another, with proof; t is 1 and 2 there."""
        ends = np.stack([self.row(self.read(start)), self.row(self.read(goal))])
        # From the first node, so that the numbers of modes need not be carried along.
        if not self._chosen:
            begin = values_of(self.found.instance, ends[:1])[0]
            return track(at_values(self.found.instance, begin), ends, seed=seed)
        there = moved_to(self.found, Drives.of(self.found.instance), start)
        result = solve(there, seed=seed)
        R, T = result.R[result.real].real, result.T[result.real].real
        platform = MovingGeometry(at_values(self.found.instance, ends[0]), self._chosen)
        run = Run(self.found.instance, platform, np.array([1.0, 2.0]), ends, FollowOptions())
        return run.follow(R, T, np.arange(1, len(R) + 1))

    def solved(
        self, read: Array, seed: int
    ) -> list[tuple[Arrangement, Field, Field, NDArray[np.bool_]]]:
        """Return all poses at some places: where the joints are, R, T, and which are real.

        Parameters
        ----------
        read
            What varies, as it is read, shape (n, axes).
        seed
            As for `solve`.
        """
        if not self._chosen:
            stated = [constraint.value.value for constraint in self.found.instance.constraints]
            values = np.tile(stated, (len(read), 1))
            values[:, self.varied] = read
            batch = solve_batch(self.found.instance, values, seed=seed)
            still = Arrangement.of(self.found.instance)
            return [(still, *of) for of in zip(batch.R, batch.T, batch.real, strict=True)]
        moving = MovingGeometry(self.found.instance, self._chosen)
        every = []
        for row in map(self.row, read):
            there = at_values(moving.instance_at(row), row)
            one = solve(there, seed=seed)
            every.append((Arrangement.of(there), one.R, one.T, one.real))
        return every
