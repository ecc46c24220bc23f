"""The least gap between legs and bodies on the ways between the rows of a proved path.

On a piece of a way all poses are near to the one in its middle (`way_pieces`), and no gap changes
by more than the corners of its two shapes move.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import apply
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.paths.between_rows import PathRows
from gspcli.motion.paths.way_pieces import Near, least_on_ways

Array = NDArray[np.float64]


def least_gaps(rows: PathRows, wanted: float) -> tuple[Array, Array]:
    """Return proved lower bounds of the least gap at rows, (r,), and between them, (r - 1,).

    They are minus infinity where nothing is proved, and on ways with an end that is too near.

    Parameters
    ----------
    rows
        The rows of a platform with shapes.
    wanted
        The gap that is asked for.
    """
    compared = ComparedShapes(rows.instance)
    at = compared.bounds(rows.R, rows.T, rows.drive_numbers()).low.min(axis=1)
    if len(at) < 2:
        return at, at[:0]
    if rows.bulges is not None and rows.bulges.any():
        return at, np.minimum(np.minimum(at[:-1], at[1:]), rows.gap_bounds(compared))
    centre = Arrangement.of(rows.instance).platform_centre

    def measure(near: Near) -> tuple[Array, Array]:
        low = compared.bounds(near.R, near.T, near.q).low
        driven = None if near.q is None else (near.R, near.T, near.q)
        places = near.T + apply(near.R, np.broadcast_to(centre, near.T.shape))
        with np.errstate(invalid="ignore"):
            moves = compared.moves(near.shifts, near.turns, centre, places, driven, near.slips)
            bounds = np.nan_to_num((low - moves).min(axis=1), nan=-np.inf, neginf=-np.inf)
        return low.min(axis=1), bounds

    return at, least_on_ways(rows, at, measure, wanted)
