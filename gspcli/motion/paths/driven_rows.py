"""Rows of a path of a machine with cranks or slides.

Clearances are those of the drives (`drive_clearances`). Between two rows they follow as those of
values do (`between_rows`), from how far each drive moves. On a way of drives that is the difference
of its numbers. On a way of poses the speed of each drive is bounded (`Rates`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.taylor import MovingSystem
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.paths.between_rows import PathRows
from gspcli.motion.paths.drive_travels import drive_travels
from gspcli.motion.paths.motors import Motors
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.singularities.drive_clearances import drive_clearances, drive_weights
from gspcli.records import dataclass

Array = NDArray[np.float64]

_OUTWARD = 1 + 2.0**-30
_HALVINGS = 2


@dataclass(frozen=True, eq=False)
class DrivenRows(PathRows):
    """Rows of a path of a machine with cranks or slides.

    Attributes
    ----------
    motors
        The drives, on the knees of the path.
    numbers
        What they are at in the rows, shape (r, m), for ways of drives.
    middle
        Returns the pose in the middle of a way of drives from a row, by numbers of shape (2, m) and
        the pose there; None if it is not found.
    clear
        Whether clearances are asked for. They take long.
    geometry
        The platform with the drives that move, for ways of drives; None if bounds that need it are
        not asked for.
    """

    motors: Motors | None = None
    numbers: Array | None = None
    middle: Callable[[Array, Array, Array], tuple[Array, Array] | None] | None = None
    clear: bool = False
    geometry: MovingGeometry | None = None

    @property
    def most_halvings(self) -> int:
        """How often ways between rows are halved at most: clearances of drives take long."""
        return _HALVINGS

    def drive_numbers(self) -> Array:
        """Return what the drives are at in the rows, shape (r, m)."""
        assert self.motors is not None
        return self.motors.numbers(self.R, self.T) if self.numbers is None else self.numbers

    def followed(self) -> tuple[MovingSystem, Array] | None:
        """Return the machine with its drives, and values and drives at the rows, (r, 6 + d)."""
        if self.geometry is None or self.numbers is None:
            return None
        assert self.motors is not None
        drives = self.motors.drives
        places = (self.numbers / drives.units)[:, drives.moved]
        return self.geometry.system, np.column_stack((self.values, places))

    def halved(self, gaps: NDArray[np.int64]) -> DrivenRows | None:
        """Return the rows with one more in the middle of some ways; None if one is not found."""
        if self.bulges is not None and self.bulges[gaps].any():
            return None
        assert self.motors is not None
        parameters, numbers = self.parameters, self.numbers
        if numbers is None:
            assert parameters is not None
            assert isinstance(self.ways, PoseWays)
            half = (parameters[gaps] + parameters[gaps + 1]) / 2
            R, T = self.ways.poses(half)
            parameters = np.insert(parameters, gaps + 1, half, axis=0)
        else:
            if self.middle is None:
                return None
            there = [self.middle(numbers[[k, k + 1]], self.R[k], self.T[k]) for k in gaps]
            poses = [one for one in there if one is not None]
            if len(poses) < len(there):
                return None
            R, T = (np.stack(part) for part in zip(*poses, strict=True))
            half = (numbers[gaps] + numbers[gaps + 1]) / 2
            numbers = np.insert(numbers, gaps + 1, half, axis=0)
        found = self._with(gaps, self.motors.values(R, T), R, T)
        assert isinstance(found, DrivenRows)
        return replace(found, parameters=parameters, numbers=numbers)

    def conditions(self) -> Array:
        """Return condition numbers at the rows, with the drives still, shape (r,)."""
        assert self.motors is not None
        return condition_numbers(self.motors.arrangement(self.R, self.T), self.R, self.T)

    def clearances(self) -> Array:
        """Return proved clearances of the drives, shape (r,); zeros if they are not asked for."""
        if not self.clear:
            return np.zeros(len(self.T))
        assert self.motors is not None
        return drive_clearances(self.instance, self.R, self.T, knees=self.motors.knees)[0]

    def condition_bounds(self) -> Array:
        """Return infinite bounds, shape (r - 1,)."""
        return np.full(len(self.T) - 1, np.inf)

    def travels(self) -> Array:
        """Bound how far drives move on the ways between rows, by their weights, shape (r - 1,).

        Infinite where there is no bound.
        """
        assert self.motors is not None
        weights = drive_weights(self.instance)[0]
        if self.numbers is not None:
            moved = np.abs(np.diff(self.numbers, axis=0)) * _OUTWARD
        else:
            assert self.parameters is not None
            assert isinstance(self.ways, PoseWays)
            moved = drive_travels(self.ways, self.parameters[:-1], self.parameters[1:])
        found = (moved / weights).max(axis=1) * _OUTWARD
        if self.bulges is not None:
            found = np.where(self.bulges.any(axis=1), np.inf, found)
        return np.asarray(found)
