"""Rigid motions as matrices of shape (4, 4), and what they do to points and directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.geometry.quaternions import rotation_from_quaternion

Array = NDArray[np.float64]


def frame(R: ArrayLike | None = None, T: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Return the motion with a rotation, shape (3, 3), and a translation, shape (3,)."""
    X = np.eye(4)
    if R is not None:
        X[:3, :3] = R
    X[:3, 3] = T
    return X


def inverse(X: Array) -> Array:
    """Return the inverse of a motion."""
    R = X[:3, :3].T
    return frame(R, -R @ X[:3, 3])


def place(X: Array, point: Array) -> Array:
    """Return where a motion takes points, shape (..., 3)."""
    moved: Array = point @ X[:3, :3].T + X[:3, 3]
    return moved


def turn(X: Array, direction: Array) -> Array:
    """Return where a motion takes directions, shape (..., 3)."""
    turned: Array = direction @ X[:3, :3].T
    return turned


def from_quaternion(quaternion: ArrayLike) -> Array:
    """Return the rotation of a quaternion of any length but zero, scalar first, shape (3, 3)."""
    return np.asarray(rotation_from_quaternion(np.asarray(quaternion, float)), float)


def about(axis: Array, angle: float) -> Array:
    """Return the rotation about a unit vector by an angle in radians, shape (3, 3)."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation: Array = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * (K @ K)
    return rotation


def roll_pitch_yaw(angles: Array) -> Array:
    """Return R_z(yaw) R_y(pitch) R_x(roll), as SDF and URDF have it, shape (3, 3)."""
    x, y, z = np.eye(3)
    roll, pitch, yaw = angles
    rotation: Array = about(z, yaw) @ about(y, pitch) @ about(x, roll)
    return rotation


def unit(vector: Array) -> Array | None:
    """Return a vector divided by its length; None if that is zero or not finite."""
    length = float(np.linalg.norm(vector))
    return vector / length if 0 < length < np.inf else None
