"""Condition numbers and transmissions of machines with motors, on the ways between rows.

On a piece of a way all poses are near to the one in its middle, and so are the points that cranks
and slides move (`way_pieces`). The condition number is bounded as that of legs is
(`condition_bounds`).

The transmission is ``|f.b|``. Here f is the unit vector of the rod, and b is the velocity of the
driven point as the drive moves, divided by the length of the arm. Let the rod vector r change by at
most d. Then f changes by at most ``2 d / (2 |r| - d)``. The vector b is constant for a slide, and
turns with the arm of a crank.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drives import Drives
from gspcli.geometry.quaternions import apply
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.paths.condition_bounds import condition_bounds
from gspcli.motion.paths.driven_rows import DrivenRows
from gspcli.motion.paths.way_pieces import Near, least_on_ways

Array = NDArray[np.float64]

#: Rounding errors of transmissions, relative to the largest coordinate by the length of the rod.
_ROUNDING = 2.0**-44
_OUTWARD = 1 + 2.0**-30


def largest_driven_conditions(rows: DrivenRows, wanted: float) -> tuple[Array, Array]:
    """Return condition numbers at rows, (r,), and bounds on the ways between them, (r - 1,).

    With the drives still, as `DrivenRows.conditions`.
    """
    assert rows.motors is not None
    drives = rows.motors.drives
    length = Arrangement.of(rows.instance).length

    def measure(near: Near) -> tuple[Array, Array]:
        assert near.q is not None
        assert near.slips is not None
        placed = drives.arrangement(near.q)
        at = condition_numbers(placed, near.R, near.T, length)
        sides = np.stack(
            [np.where(drives.on_platform == side, near.slips, 0.0) for side in (True, False)]
        )
        most = condition_bounds(placed, near.R, near.T, near.shifts, near.turns, length, sides)
        return -at, -most

    at = rows.conditions()
    return at, -least_on_ways(rows, -at, measure, -wanted)


def least_transmissions(rows: DrivenRows, wanted: float) -> tuple[Array, Array]:
    """Return the least transmission of all drives at rows, (r,), and bounds between them, (r - 1,).

    Parameters
    ----------
    rows
        The rows.
    wanted
        The transmission that is asked for.
    """
    assert rows.motors is not None
    drives = rows.motors.drives
    centre = Arrangement.of(rows.instance).platform_centre

    def measure(near: Near) -> tuple[Array, Array]:
        low, changes = _transmissions(drives, near, centre)
        bounds = np.nan_to_num((low - changes).min(axis=1), nan=-np.inf, neginf=-np.inf)
        return low.min(axis=1), bounds

    q = rows.drive_numbers()
    driven = drives.transmission(drives.gains(rows.R, rows.T, q))[:, drives.driven]
    at = driven.min(axis=1)
    return at, least_on_ways(rows, at, measure, wanted)


def _transmissions(drives: Drives, near: Near, centre: Array) -> tuple[Array, Array]:
    """Return transmissions of the driven rods, and bounds of their changes, shapes (n, d)."""
    assert near.q is not None
    assert near.slips is not None
    base, arm, r = drives.ends(near.R, near.T, near.q)
    places = near.T + apply(near.R, np.broadcast_to(centre, near.T.shape))
    # Seen from the body of the driven point; r is a vector of that body.
    own = np.linalg.norm(arm - (places - near.T)[:, None], axis=-1)
    away = np.linalg.norm(places[:, None] - base, axis=-1)
    arms = np.where(drives.on_platform, away, own)
    with np.errstate(all="ignore"):
        change = near.shifts[:, None] + near.turns[:, None] * arms + near.slips
        size = np.linalg.norm(r, axis=-1)
        left = size - change / 2
        turned = np.where(left > 0, change / left, np.inf)
        cranks = np.array([drives.sorts[k] == "crank" for k in drives.index])
        turned += np.where(cranks, near.slips / drives.arms, 0.0)
        far = (
            np.abs(near.T).max(axis=1)[:, None]
            + np.abs(base).max(axis=-1)
            + np.abs(arm).max(axis=-1)
        )
        turned = turned * _OUTWARD + _ROUNDING * (1 + far / size)
    at = drives.transmission(drives.gains(near.R, near.T, near.q))
    return at[:, drives.driven], turned[:, drives.driven]
