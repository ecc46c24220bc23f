"""Bounds of how far cranks and slides move their points while the platform moves a little.

At a pose the number q of a drive is where the distance of the two ends of the rod is the length l
of the rod, on the knee of home. Let one end of the rod move by at most d. Suppose that the distance
is below ``l - d`` at one of ``q - e`` and ``q + e``, and above ``l + d`` at the other. Then the new
number is between both: the distance passes l there, in the direction of the knee. For a crank and
for a slide there is only one such number for each direction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.drives import Drives
from gspcli.geometry.quaternions import apply

Array = NDArray[np.float64]

#: Changes of drives that are tried, as multiples of the change for linear lengths.
_TRIED = (1.05, 1.3, 2.0, 4.0)
_OUTWARD = 1 + 2.0**-30
#: Rounding errors of lengths, relative to the largest coordinate.
_ROUNDING = 2.0**-44


def point_moves(drives: Drives, R: Array, T: Array, q: Array, moves: Array) -> Array:
    """Return bounds of how far driven points move in their bodies, shape (n, 6).

    Parameters
    ----------
    drives
        The drives of a platform.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3).
    q
        The numbers of the drives at the poses, shape (n, m).
    moves
        How far the other end of each rod moves, in the frame of the body of the driven point, shape
        (n, 6).

    Returns
    -------
    Array
        Zero where no crank or slide moves the point, infinite where nothing is proved.
    """
    gains = drives.gains(R, T, q)
    size = np.abs(T).max(axis=1) + max(np.abs(drives.rods[drives.driven]).max(), 1e-300)
    size += np.abs(drives.points(q)).max(axis=(1, 2))
    room = moves * _OUTWARD + _ROUNDING * size[:, None]
    found = np.where(drives.driven, np.inf, 0.0) * np.ones_like(moves)
    with np.errstate(all="ignore"):
        linear = room / np.abs(gains)
        for factor in _TRIED:
            for k in np.flatnonzero(drives.driven).tolist():
                change = np.zeros_like(q)
                change[:, drives.index[k]] = factor * linear[:, k]
                low, high = (
                    np.linalg.norm(drives.ends(R, T, q + sign * change)[2][:, k], axis=-1)
                    - drives.rods[k]
                    for sign in (-1, 1)
                )
                # If the platform does not move, the derivative of the length of the rod is minus
                # the gain.
                knee = -np.sign(gains[:, k])
                fits = (knee * low < -room[:, k]) & (knee * high > room[:, k])
                # The two numbers of a crank differ by less than a turn.
                if drives.sorts[drives.index[k]] == "crank":
                    fits &= factor * linear[:, k] < np.pi / 2
                far = drives.arms[k] * factor * linear[:, k] * _OUTWARD
                found[:, k] = np.where(fits, np.minimum(found[:, k], far), found[:, k])
    return np.asarray(found)


def slips_near(
    drives: Drives, R: Array, T: Array, q: Array, shifts: Array, turns: Array, centre: Array
) -> Array:
    """Return bounds of how far driven points move near poses, shape (n, 6); see `point_moves`.

    Parameters
    ----------
    drives
        The drives of a platform.
    R, T, q
        Poses and the numbers of the drives there, shapes (n, 3, 3), (n, 3) and (n, m).
    shifts, turns
        The largest distance that a point of the platform moves, and the largest angle, in radians,
        by which the platform rotates; shapes (n,).
    centre
        This point of the platform, in its frame, shape (3,).
    """
    placed = drives.arrangement(q)
    places = T + apply(R, np.broadcast_to(centre, T.shape))
    own = np.linalg.norm(placed.y - centre, axis=-1)
    away = np.linalg.norm(places[:, None] - placed.x, axis=-1)
    # In the frame of the body of the driven point the other body moves.
    arms = np.where(drives.on_platform, away, own)
    return point_moves(drives, R, T, q, shifts[:, None] + turns[:, None] * arms)
