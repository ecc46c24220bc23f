"""Determinants of the Jacobian matrix at many poses, quickly and independently of the proofs.

The rows are the screws of the ten constraints, written down once more for arrays whose last axis is
the pose. The determinants are those of LAPACK. Each row is a multiple of the derivative of what the
constraint measures. Its factor never changes its sign, so signs along a way can be compared.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.geometry.arrangement import Arrangement

Array = NDArray[np.float64]

#: Poses at a time: larger arrays take half as long again, since each is new memory of the system.
_BLOCK = 250


def determinants(a: Arrangement, pivot: Array, parameters: Array) -> Array:
    """Return determinants at n poses, up to positive factors, ``(n, 6) -> (n,)``.

    Parameters
    ----------
    a
        The platform.
    pivot
        The point of the platform whose position the first three parameters are, shape (3,).
    parameters
        Positions and angles of the order ``ZYX``, in radians.
    """
    blocks = range(0, len(parameters), _BLOCK)
    found = [_of_block(a, pivot, parameters[k : k + _BLOCK].T) for k in blocks]
    return np.concatenate(found)


def _of_block(a: Arrangement, pivot: Array, columns: Array) -> Array:
    place, (rx, ry, rz) = columns[:3], columns[3:]
    R = _rotations(rx, ry, rz)
    flat = R.transpose(1, 0, 2).reshape(3, -1)
    arms, w = (
        (own @ flat).reshape(-1, 3, columns.shape[1]) for own in ((a.y - pivot) / a.length, a.u)
    )
    r = arms + place / a.length - a.x[:, :, None] / a.length
    v = np.broadcast_to(a.v[:, :, None], r.shape)
    rows = np.empty((6, 6, columns.shape[1]))
    for k, kind in enumerate(a.kinds):
        force, turning = _screw(kind, r[k], w[k], v[k])
        rows[k] = 0.0
        if force is not None:
            rows[k, 3:], rows[k, :3] = force, _cross(arms[k], force)
        if turning is not None:
            rows[k, :3] += _cross(w[k], turning)
    return np.asarray(np.linalg.det(np.ascontiguousarray(rows.transpose(2, 0, 1))))


def _screw(kind: object, r: Array, w: Array, v: Array) -> tuple[Array | None, Array | None]:
    """Return multiples of the derivatives by r and by w, shapes (3, n); None for zero."""
    if kind is DPP:
        return r, None
    if kind is DPL:
        return r - _dot(r, v) * v, None
    if kind is DLP:
        along = _dot(r, w)
        return r - along * w, -along * r
    if kind is DPH:
        return v, None
    if kind is DHP:
        return w, r
    if kind is DLL:
        # The moment r.n over the sine |n| of the angle; c is its cosine.
        n, c = _cross(w, v), _dot(w, v)
        return n, _cross(v, r) + _dot(r, n) * c / _dot(n, n) * v
    return None, v


def _rotations(rx: Array, ry: Array, rz: Array) -> Array:
    """Return rotations about x, then y, then z, shape (3, 3, n)."""
    angles = np.stack((rx, ry, rz))
    (a, b, c), (s, t, u) = np.cos(angles), np.sin(angles)
    return np.array(
        [
            [c * b, c * t * s - u * a, c * t * a + u * s],
            [u * b, u * t * s + c * a, u * t * a - c * s],
            [-t, b * s, b * a],
        ]
    )


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _cross(a: Array, b: Array) -> Array:
    return np.stack(
        (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    )
