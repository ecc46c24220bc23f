"""Bounds of condition numbers over all poses that are near to given ones.

If the centre of the platform moves by at most d and the platform turns by at most t, each row of
the Jacobian matrix changes by a bounded amount. It changes by more if cranks or slides move the
points of legs. Rows are (moment / L, force) as in `condition_numbers`, of norm one; let e be the
root of the sum of the squares of the bounds of their changes. No singular value changes by more
than e, by Weyl's inequality. So the condition number is at most ``(s_1 + e) / (s_6 - e)``, if e is
below the least singular value s_6.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.quaternions import apply

Array = NDArray[np.float64]

#: Rounding errors of rows and of singular values, relative to the largest.
_ROUNDING = 2.0**-40
_OUTWARD = 1 + 2.0**-30


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
        How far cranks and slides move the points of legs (DPP) in their bodies, at most: those of
        the platform and those of the base, shape (2, n, 6); None if no point moves.
    """
    with np.errstate(all="ignore"):
        rows = jacobian(arrangement, R, T)
        offset = apply(R, np.broadcast_to(arrangement.platform_centre, T.shape))[:, None]
        rows[..., :3] -= np.cross(np.broadcast_to(offset, rows[..., 3:].shape), rows[..., 3:])
        rows[..., :3] /= length
        norms = np.linalg.norm(rows, axis=-1)
        changes = _changes(arrangement, R, T, shifts, turns, length, slips)
        known = np.isfinite(norms) & np.isfinite(changes) & (changes < norms)
        # Vectors of norm one differ by at most 2 |a - b| / (|a| + |b|).
        moved = changes / (norms - changes / 2) * _OUTWARD
        good = known.all(axis=1)
        unit = np.where(good[:, None, None], rows / norms[..., None], np.eye(6))
        values = np.linalg.svd(unit, compute_uv=False)
        room = np.linalg.norm(moved, axis=1) * _OUTWARD + _ROUNDING * values[:, 0]
        least = values[:, -1] - room
        found = (values[:, 0] + room) / least
    return np.where(good & (least > 0), found, np.inf)


def _changes(
    a: Arrangement,
    R: Array,
    T: Array,
    shifts: Array,
    turns: Array,
    length: float,
    slips: Array | None,
) -> Array:
    """Bound the changes of the rows before they are scaled, shape (n, 6)."""
    turned = np.swapaxes(R, -1, -2)
    centre = a.platform_centre
    at = T + apply(R, np.broadcast_to(centre, T.shape))
    arms = (a.y - centre) @ turned
    offsets = at[:, None] - a.x
    w = a.u @ turned
    # The coordinates themselves have rounding errors.
    far = np.abs(T).max(axis=-1) + max(np.abs(a.x).max(), np.abs(a.y).max())
    d = shifts + 2.0**-48 * far
    t = 2 * np.sin(np.minimum(turns, np.pi) / 2) * _OUTWARD + 2.0**-48
    found = np.empty(offsets.shape[:2])
    own, other = np.zeros((2, *found.shape)) if slips is None else slips
    for k, kind in enumerate(a.kinds):
        if kind is DPP:
            moment, force = _of_leg(arms[:, k], offsets[:, k], d, t, own[:, k], other[:, k])
        else:
            moment, force = _of_kind(kind, arms[:, k], offsets[:, k], w[:, k], a.v[k], d, t)
        found[:, k] = np.hypot(moment / length, force)
    return found * _OUTWARD


def _of_leg(
    arm: Array, offset: Array, d: Array, t: Array, own: Array, other: Array
) -> tuple[Array, Array]:
    """Bound the changes of moment and force of a leg, shape (n,) each.

    Parameters
    ----------
    arm, offset, d, t
        As for `_of_kind`.
    own, other
        How far drives move its points on the platform and on the base, shape (n,).
    """
    a = _size(arm)
    # The arm of a point that moves is ``E (y + s)`` with the turn E and the move s.
    moved = t * a + own
    force = _direction(arm + offset, d + moved + other)
    return moved + a * force, force


def _of_kind(
    kind: Kind, arm: Array, offset: Array, w: Array, v: Array, d: Array, t: Array
) -> tuple[Array, Array]:
    """Bound the changes of moment and force of a constraint that is no leg, shape (n,) each.

    Parameters
    ----------
    kind
        Of the constraint.
    arm, offset, w
        From the centre to the platform's point, from the base's point to the centre, and the
        platform's direction, shape (n, 3).
    v
        The direction of the base, shape (3,).
    d, t
        How far the centre moves, and how far a unit vector of the platform.
    """
    zero = np.zeros_like(d)
    a, s = _size(arm), _size(offset)
    r = arm + offset
    moves = d + t * a
    if kind is DPL:
        force = _direction(r - (r @ v)[:, None] * v, moves)
        return t * a + a * force, force
    if kind is DPH:
        return t * a, zero
    if kind is DLP:
        # The force is at right angles to w. It passes through the point of the base.
        along = np.einsum("ni,ni->n", r, w)
        change = moves + 2 * _size(r) * t + moves * t
        force = _direction(r - along[:, None] * w, change)
        return d + s * force, force
    if kind is DHP:
        return d + s * t, t
    normal = np.cross(w, np.broadcast_to(v, w.shape))
    sine = _size(normal)
    force = _direction(normal, t)
    if kind is not DLL:
        return force, zero
    # d = r . n with the unit normal n; its derivative by w is g = v x (r - d n) / sine.
    n = normal / sine[:, None]
    distance = np.einsum("ni,ni->n", r, n)
    across = r - distance[:, None] * n
    change = moves + (moves + (_size(r) + moves) * force) + (np.abs(distance) + moves) * force
    size = _size(across)
    left = sine - t
    steeper = np.where(left > 0, change / left + size * (1 / left - 1 / sine), np.inf)
    gradient = size / sine + steeper
    return t * a + a * force + t * gradient + steeper, force


def _size(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=-1))


def _direction(vectors: Array, changes: Array) -> Array:
    """Bound the change of the direction of vectors that change by this much, shape (n,)."""
    left = _size(vectors) - changes / 2
    # |a / |a| - b / |b|| is at most 2 |a - b| / (|a| + |b|).
    return np.where(left > 0, changes / np.where(left > 0, left, 1.0), np.inf)
