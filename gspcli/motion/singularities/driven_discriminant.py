"""The discriminant over cranks and slides, followed as curves.

The equations are those of `discriminant`; all their coefficients move. They and their derivatives
come from the equations of folds (`gspcli.certification.branches.fold_system`), once along each of
the two axes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.fold_system import rounded_along
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.singularities.discriminant import Discriminant
from gspcli.motion.singularities.scan_rows import ScanRows

Array = NDArray[np.float64]


class DrivenDiscriminant(Discriminant):
    """The equations of singular poses over two numbers, of which a crank or slide has at least one.

    Parameters
    ----------
    rows
        The rows of the scan.
    platform
        The equations.
    """

    def __init__(self, rows: ScanRows, platform: MovingGeometry) -> None:
        self._of = rows
        self._system = platform.system
        self._low, self._span = rows.low, rows.high - rows.low

    def _rows(self, point: Array, w: Array) -> Array:
        return self._along(np.concatenate((point, point, w)), 0)[0][1][:7, :8]

    def _terms(self, x: Array) -> tuple[Array, Array, Array, tuple[Array, Array]]:
        (values, rows), (_, bent) = self._along(x, 0)
        (_, other_rows), (_, other_bent) = self._along(x, 1)
        first = np.column_stack((rows[:7, 8], other_rows[:7, 8]))
        second = np.column_stack((bent[:7, 8], other_bent[:7, 8]))
        return values[:7], rows[:7, :8], bent[:7, :8], (first, second)

    def _along(self, x: Array, axis: int) -> list[tuple[Array, Array]]:
        """Return F and F'u, each with its derivatives by z and by one w: shapes (8,), (8, 9)."""
        read = self.plane(x)
        row = self._of.row(read)
        ahead = row.copy()
        ahead[self._of.varied[axis]] += self._span[axis] * self._of.scales[axis]
        return rounded_along(self._system, (row, ahead), x[:8], x[8:16])
