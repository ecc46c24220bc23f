"""Drives that several rods share, such as the carriages of a linear delta."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.dynamics.arrays import RowError
from gspcli.dynamics.drives import DrivesAtPoses
from gspcli.geometry.quaternions import (
    apply,
)

Array = NDArray[np.float64]

#: Rates that differ by more than this part of the largest one are not those of one drive.
_SAME = 1e-6


def check_shared(drives: DrivesAtPoses, twists: Array) -> None:
    """Refuse motions, shape (n, 6), at which the rods of one drive ask for different rates.

    Raises
    ------
    RowError
        Naming the rods.
    """
    sharing = drives.model.sharing
    if sharing is None or drives.points is None:
        return
    rates = apply(drives.pulls, twists)
    means = rates @ sharing / sharing.sum(axis=0)
    apart = np.abs(rates - means @ sharing.T)
    wrong = apart > _SAME * np.abs(rates).max(axis=-1, keepdims=True)
    if wrong.any():
        row, k = np.argwhere(wrong)[0].tolist()
        known = drives.points.drives
        rods = (np.flatnonzero(known.index == known.index[k]) + 1).tolist()
        name = known.names[known.index[k]]
        message = (
            f"rods {' and '.join(map(str, rods))} ask for different speeds of {name}: the platform "
            "cannot move so"
        )
        raise RowError(row, message)
