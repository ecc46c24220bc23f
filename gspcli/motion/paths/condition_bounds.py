"""Bounds of condition numbers over all poses that are near to given ones.

The rows of the Jacobian matrix, (moment / L, force) of norm one, are enclosed by the formulas for
screws: all arms, offsets and directions are in balls. The singular values of all matrices of such
rows are bounded, and with them their condition numbers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.enclosures import OUT, Enclosure, joined, singular_values, size
from gspcli.geometry.quaternions import apply
from gspcli.motion.screws import screw

Array = NDArray[np.float64]


def condition_bounds(
    arrangement: Arrangement,
    R: Array,
    T: Array,
    shifts: Array,
    turns: Array,
    length: float,
    slips: Array | None = None,
) -> Array:
    """Return upper bounds of the condition numbers of poses near to given ones, shape (n,).

    Infinite where nothing is proved.

    Parameters
    ----------
    arrangement
        The geometry.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    shifts, turns
        How far the centre of the platform moves and by which angle, in radians, the platform turns,
        at most; shapes (n,).
    length
        The typical length, as for `condition_numbers`.
    slips
        How far cranks and slides move the points of constraints in their bodies, at most: those of
        the platform and those of the base, shape (2, n, 6); None if no point moves.
    """
    with np.errstate(all="ignore"):
        rows = rows_near(arrangement, R, T, shifts, turns, length, slips)
        known = np.asarray(
            np.isfinite(rows.rad).all(axis=1) & np.isfinite(rows.mid).all(axis=(1, 2))
        )
        safe = np.where(known[:, None, None], rows.mid, np.eye(6))
        least, most = singular_values(Enclosure(safe, rows.rad))
        return np.where(known & (least > 0), most / least * OUT, np.inf)


def rows_near(
    a: Arrangement,
    R: Array,
    T: Array,
    shifts: Array,
    turns: Array,
    length: float,
    slips: Array | None = None,
) -> Enclosure:
    """Enclose (moment / L, force) about the centre, of norm one, shape (n, 6, 6)."""
    chord = 2 * np.sin(np.minimum(turns, np.pi) / 2) * OUT
    own, other = np.zeros((2, len(T), 6)) if slips is None else slips
    centre = a.platform_centre

    def turned(vectors: Array) -> Enclosure:
        placed = Enclosure.rounded(apply(R[:, None], vectors), size(vectors) + size(centre))
        return placed.widened(chord[:, None] * size(vectors))

    arm = turned(a.y - centre).widened(own)
    at = T + apply(R, np.broadcast_to(centre, T.shape))
    far = size(T)[:, None] + size(centre) + size(a.x)
    offset = Enclosure.rounded(at[:, None] - a.x, far).widened(shifts[:, None] + other)
    w = turned(a.u)
    v = Enclosure.rounded(np.broadcast_to(a.v, w.mid.shape))
    mid, rad = np.zeros((len(T), 6, 6)), np.zeros((len(T), 6))
    for kind in set(a.kinds):
        k = [i for i, one in enumerate(a.kinds) if one is kind]
        moment, force = screw(kind, *(part.take(slice(None), k) for part in (arm, offset, w, v)))
        moment = (1 / length) * moment
        row = joined(moment, force or Enclosure(0 * moment.mid)).unit()
        mid[:, k], rad[:, k] = row.mid, row.rad
    return Enclosure(mid, rad)
