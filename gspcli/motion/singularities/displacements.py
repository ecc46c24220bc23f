"""Poses about home poses, in coordinates whose norm is the extrinsic distance.

About a pose whose platform points have the centre c, other poses are displacements
``x -> c + t + Q (x - c)``. With the quaternion (w, v) of Q, w not negative, the mean of the squared
displacements of the points is ``|t|^2 + 4 v . I v``, I being the second moments of the points about
axes through c. So the coordinates

    s = (t, 2 I^(1/2) v)

have the extrinsic distance of poses as their norm (G. Nawratil, Singularity distance for parallel
manipulators of Stewart Gough type, Advances in Mechanism and Machine Science, 2019). All poses
within a distance are a ball, for any distance.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.quaternions import (
    apply,
    dot,
    quaternion_from_rotation,
    rotation_from_quaternion,
)
from gspcli.ties import definite_vectors

Array = NDArray[np.float64]

#: Moments smaller than this part of the greatest are those of points on a line.
_LINE = 1e-9


class Displacements:
    """Displacements from home poses, by the coordinates s.

    Parameters
    ----------
    instance
        Geometry and units; its values are not used.
    R, T
        The home poses, shapes (n, 3, 3) and (n, 3).
    points
        The points of the platform, in its frame, whose displacements define the distance, (m, 3);
        by default those of the distance constraints, one for each.

    Raises
    ------
    ArgumentError
        If the points lie on a line.
    """

    def __init__(
        self, instance: Instance, R: ArrayLike, T: ArrayLike, points: ArrayLike | None = None
    ) -> None:
        self.arrangement = arrangement = Arrangement.of(instance)
        given = arrangement.y[arrangement.distances] if points is None else points
        self.points = np.asarray(given, float).reshape(-1, 3)
        self.centre = self.points.mean(axis=0)
        self.R = rotation_from_quaternion(quaternion_from_rotation(np.asarray(R, float)))
        self.T = np.asarray(T, float)
        offsets = self.points - self.centre
        square = offsets.T @ offsets / len(self.points)
        moments, axes = np.linalg.eigh(np.trace(square) * np.eye(3) - square)
        axes = definite_vectors(moments, axes)
        if not moments[0] > _LINE * moments[2]:
            message = "the points of the platform lie on a line, expected three that do not"
            raise ArgumentError(message, "points")
        #: Columns: the principal axes in the base, shape (n, 3, 3); square roots of the moments.
        self.axes = self.R @ axes
        self.radii = np.sqrt(moments)

    @property
    def farthest(self) -> float:
        """The least distance at which half a turn is reached."""
        return float(2 * self.radii[0])

    @cached_property
    def centres(self) -> Array:
        """The centres of the points at home, in the base, shape (n, 3)."""
        return np.asarray(self.T + apply(self.R, self.centre))

    def turns(self, s: Array) -> Array:
        """Return the sines of half the angles, ``(..., 6) -> (...)``; at most one."""
        return np.asarray(np.linalg.norm(s[..., 3:] / (2 * self.radii), axis=-1))

    def poses(self, s: Array) -> tuple[Array, Array]:
        """Return poses (R, T) by their coordinates, ``(n, 6) -> (n, 3, 3), (n, 3)``."""
        Q = rotation_from_quaternion(self.quaternions(s))
        R = Q @ self.R
        T = self.centres + s[..., :3] - apply(R, self.centre)
        return R, T

    def quaternions(self, s: Array) -> Array:
        """Return the turns (w, v), ``(..., 6) -> (..., 4)``; NaN where there is none."""
        v = apply(self.axes, s[..., 3:] / (2 * self.radii))
        with np.errstate(invalid="ignore"):
            w = np.sqrt(1 - dot(v, v)[..., None])
        return np.concatenate((w, v), axis=-1)

    def determinants(self, s: Array) -> Array:
        """Return determinants of the Jacobian matrices, 0 where there is none, ``(n, 6) -> (n,)``.

        In the units of the instance; numbers, not proofs.
        """
        with np.errstate(all="ignore"):
            rows = jacobian(self.arrangement, *self.poses(s))
            regular = np.asarray(np.isfinite(rows).all(axis=(1, 2)))
            return np.asarray(np.linalg.det(np.where(regular[:, None, None], rows, 0.0)))
