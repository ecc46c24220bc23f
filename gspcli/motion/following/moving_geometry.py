"""An instance whose coordinates and values move, prepared for following branches.

It is slower than `MovingPlatform`, in which only values move.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.taylor import MovingSystem
from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.geometry.coordinates import Coordinate, moved
from gspcli.geometry.instance import Instance
from gspcli.motion.following.branch_follower import Branches, FollowOptions, StudyUnits
from gspcli.motion.following.branch_steps import BranchSteps
from gspcli.motion.following.chord_equations import equations_at

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
        super().__init__(self.system.scale, LocalFrames.none())

    def internal(self, rows: Array) -> Array:
        """Return rows unchanged."""
        return np.ascontiguousarray(rows)

    def instance_at(self, row: Array) -> Instance:
        """Return the instance with the coordinates of a row; its values are not used."""
        return moved(self.instance, self.chosen, row[6:])

    def jacobian(self, point: Array, row: Array) -> Array:
        """Return the derivatives of the seven equations at a Study point, shape (7, 8)."""
        part = self.system.on_part((row, row), 0.0, 0.0)
        quadrics, factors = part.quadrics[None, :, :, 0], part.factors[None, :, 0]
        rows: Array = equations_at(self.system.shapes, quadrics, factors, point[None])[1][0]
        return rows

    def follow(
        self,
        values: Array,
        trajectory: Index,
        start: Array,
        options: FollowOptions,
        near: Array | None = None,
    ) -> Branches:
        """Follow branches along trajectories, which are linear between their rows.

        Parameters
        ----------
        values
            Rows, shape (trajectories, rows, 6 + coordinates).
        trajectory, start, options, near
            As for `MovingPlatform.follow`; `FollowOptions.jobs` and ``build`` are not used.
        """
        return BranchSteps(self.system, values, options).run(trajectory, start, near)
