"""Rows of a path of a machine with cranks or slides."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.paths.between_rows import PathRows
from gspcli.motion.paths.motors import Motors
from gspcli.records import dataclass

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DrivenRows(PathRows):
    """Rows of a path of a machine with cranks or slides: clearances are not computed."""

    motors: Motors | None = None

    def halved(self, gaps: NDArray[np.int64]) -> None:
        """Return nothing: rows are not added."""
        del gaps

    def conditions(self) -> Array:
        """Return condition numbers at the rows, with the drives still, shape (r,)."""
        assert self.motors is not None
        return condition_numbers(self.motors.arrangement(self.R, self.T), self.R, self.T)

    def clearances(self) -> Array:
        """Return zeros: nothing is proved, shape (r,)."""
        return np.zeros(len(self.T))

    def condition_bounds(self) -> Array:
        """Return infinite bounds, shape (r - 1,)."""
        return np.full(len(self.T) - 1, np.inf)

    def travels(self) -> Array:
        """Return infinite bounds, shape (r - 1,)."""
        return np.full(len(self.T) - 1, np.inf)
