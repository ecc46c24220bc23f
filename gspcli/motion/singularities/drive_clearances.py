"""Clearance of machines with cranks and slides: how far their drives may move.

A clearance of r means that all drives together may move by up to r times their weights, in any
combination. Two numbers are proved. Up to the first the pose has exactly one continuation, which is
regular. Up to the second, which is at most the first, no drive comes to a dead point: all keep
their knees.
Beyond, the nearest fold and the nearest dead point that were found bound them: numbers, not proofs.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.motion.singularities.neighbourhoods import DrivenNeighbourhood
from gspcli.progress import Progress, silent
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Halvings of the interval of a clearance, and the ratio of its ends that suffices.
_HALVINGS, _CLOSE = 60, 1.002
#: The largest change that is tried, in weights.
_FARTHEST = 1e3
#: Steps along a line of drives: the first in clearances, their growth, and the least relatively.
_FIRST, _GROWTH, _LEAST, _STEPS = 1.0, 1.5, 1e-7, 400
#: Iterations of Newton's method, its residual, and the farthest that a step may move the pose.
_ITERATIONS, _RESIDUAL, _JUMP = 8, 1e-11, 0.1


@dataclass(frozen=True, eq=False)
class DriveClearance:
    """Bounds of the clearance of one pose in its drives.

    Attributes
    ----------
    lower
        Proved: up to here there is exactly one continuation, and no singularity.
    knees
        Proved: up to here no drive comes to a dead point; at most ``lower``.
    upper
        The change at the nearest fold that was found; infinite if there is none.
    dead_point
        The change at the nearest dead point that was found; infinite if there is none.
    drive
        The index of the drive that is at it, or None.
    q, R, T
        The drives and the pose at the fold: shapes (m,), (3, 3) and (3,), or None.
    """

    lower: float
    knees: float
    upper: float
    dead_point: float
    drive: int | None
    q: Array | None
    R: Array | None
    T: Array | None

    @property
    def ratio(self) -> float:
        """Upper bound by lower bound."""
        return self.upper / self.lower if self.lower > 0 else np.inf


def drive_weights(instance: Instance) -> tuple[Array, bool]:
    """Return the weights of the drives, lengths and radians, shape (m,).

    Also whether they are half the ranges; otherwise they are one in the unit of each drive.
    """
    drives = Drives.of(instance)
    half = (drives.high - drives.low) / 2
    if np.isfinite(half).all() and (half > 0).all():
        return half, True
    return drives.units.copy(), False


def drive_clearances(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    knees: ArrayLike | None = None,
) -> tuple[Array, Array]:
    """Return what is proved of poses: `DriveClearance.lower` and `knees`, shape (n,) each.

    Zero if there is no proof, or the drives do not reach the pose.

    Parameters
    ----------
    instance
        The machine; its home pose decides the knees, without one each pose does.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3).
    weights
        The unit of each drive's changes, lengths and radians, shape (m,); as `drive_weights`.
    knees
        The signs of the gains, shape (6,), instead of those of the home pose.
    """
    drives, units = _given(instance, weights)
    R, T = np.asarray(R, float), np.asarray(T, float)
    signs = None if knees is None else np.asarray(knees)
    proved = [_proved(drives, R[k], T[k], units, signs) for k in range(len(T))]
    return np.array([one for one, _ in proved]), np.array([one for _, one in proved])


def each_drive_clearance(
    instance: Instance, R: Array, T: Array, *, progress: Progress = silent
) -> list[DriveClearance]:
    """Return bounds of the clearance of each of some poses.

    For the upper bounds the pose is followed by Newton's method along the lines to all corners of
    the box of drives, until it ends in a fold, and until a gain changes its sign.

    Parameters
    ----------
    instance, R, T
        As for `drive_clearances`, with the weights of `drive_weights`.
    progress
        Receives each pose that is done.
    """
    drives, units = Drives.of(instance), drive_weights(instance)[0]
    found = []
    for k in progress(range(len(T)), total=len(T), label="poses"):
        lower, knees = _proved(drives, R[k], T[k], units)
        found.append(_Corners(drives, R[k], T[k], units, lower).bounds(lower, knees))
    return found


def _given(instance: Instance, weights: ArrayLike | None) -> tuple[Drives, Array]:
    drives = Drives.of(instance)
    units = drive_weights(instance)[0] if weights is None else np.asarray(weights, float)
    if units.shape != (drives.count,) or not (np.isfinite(units) & (units > 0)).all():
        message = f"found {units.tolist()}, expected {drives.count} positive numbers"
        raise ArgumentError(message, "weights")
    return drives, units


def _proved(
    drives: Drives, R: Array, T: Array, units: Array, knees: NDArray[np.int64] | None = None
) -> tuple[float, float]:
    q = drives.inverse(R, T, knees)
    if np.isnan(q).any():
        return 0.0, 0.0
    near = DrivenNeighbourhood(drives, R, T, q)
    # Constraints that share a drive move together; it is proved for all their changes.
    widths = near.widths(units[drives.index])[None]

    def regular(size: float) -> bool:
        return bool(near.box(size * widths).measure[0] < 1)

    def kept(size: float) -> bool:
        return bool(near.keeps_knees(size * widths, near.box(size * widths))[0])

    lower = _largest(regular, _FARTHEST)
    return lower, _largest(kept, lower)


def _largest(good: Callable[[float], bool], most: float) -> float:
    """Return a size for which something is proved, nearly the largest, found by halving."""
    if good(most):
        return most
    low, high = 0.0, most
    for _ in range(_HALVINGS):
        # Any order of magnitude is possible; it is found first.
        size = (low + high) / 2 if low > 0 else high / 8
        low, high = (size, high) if good(size) else (low, size)
        if low > 0 and high <= low * _CLOSE:
            break
    return low


class _Corners:
    """A pose followed to the corners of the box of its drives.

    Parameters
    ----------
    drives, R, T
        The machine and the pose.
    units
        The weights, shape (m,).
    lower
        The clearance that is proved: the first step.
    """

    def __init__(self, drives: Drives, R: Array, T: Array, units: Array, lower: float) -> None:
        signs = product((1.0, -1.0), repeat=drives.count)
        self.drives, self.units = drives, units
        self.q = drives.inverse(R, T)
        self.ways = np.array(list(signs)) * units
        count = len(self.ways)
        self.R, self.T = np.repeat(R[None], count, axis=0), np.repeat(T[None], count, axis=0)
        self.far = np.zeros(count)
        self.step = np.full(count, max(_FIRST * lower, 1e-9))
        self.length = float(np.nanmax(drives.rods))

    def bounds(self, lower: float, knees: float) -> DriveClearance:
        """Return the bounds, with the nearest fold and dead point."""
        nothing = DriveClearance(lower, knees, np.inf, np.inf, None, None, None, None)
        if lower == 0:
            return nothing
        drives = self.drives
        J = drives.jacobian(self.R[:1], self.T[:1], self.q[None])
        sign = np.sign(np.linalg.det(J))[0]
        gains = np.sign(drives.gains(self.R[:1], self.T[:1], self.q[None]))[0]
        upper, dead, drive, at = np.inf, np.inf, None, None
        active = np.ones(len(self.ways), bool)
        for _ in range(_STEPS):
            some = np.flatnonzero(active)
            if not len(some):
                break
            size = self.far[some] + self.step[some]
            R, T, good = self._newton(some, size)
            q = self.q + size[:, None] * self.ways[some]
            with np.errstate(all="ignore"):
                J = drives.jacobian(R, T, q)
                good &= np.isfinite(J).all(axis=(1, 2))
                J[~good] = np.eye(6)
                good &= np.sign(np.linalg.det(J)) == sign
                changed = (np.sign(drives.gains(R, T, q)) != gains) & drives.driven
            moved = some[good]
            if (crossed := good & changed.any(axis=1)).any():
                nearest = int(np.where(crossed, size, np.inf).argmin())
                if size[nearest] < dead:
                    dead = float(size[nearest])
                    drive = int(drives.index[int(changed[nearest].argmax())])
            self.R[moved], self.T[moved], self.far[moved] = R[good], T[good], size[good]
            self.step[some] *= np.where(good, _GROWTH, 0.5)
            ended = self.step < _LEAST * self.far
            for k in np.flatnonzero(ended & active):
                if self.far[k] < upper:
                    upper, at = float(self.far[k]), int(k)
            active &= ~ended & (self.far < min(upper, _FARTHEST))
        if at is None:
            return DriveClearance(lower, knees, np.inf, dead, drive, None, None, None)
        q = self.q + upper * self.ways[at]
        return DriveClearance(lower, knees, upper, dead, drive, q, self.R[at], self.T[at])

    def _newton(
        self, some: NDArray[np.intp], size: Array
    ) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Return the poses at some corners and sizes, and which are solutions nearby."""
        drives = self.drives
        R, T = self.R[some].copy(), self.T[some].copy()
        q = self.q + size[:, None] * self.ways[some]
        arrangement = drives.arrangement(q)
        wanted = np.where(drives.driven, drives.rods, q[:, drives.index])
        with np.errstate(all="ignore"):
            for _ in range(_ITERATIONS):
                off = wanted - measured(arrangement, R, T)
                J = drives.jacobian(R, T, q)
                fine = np.isfinite(J).all(axis=(1, 2)) & np.isfinite(off).all(axis=1)
                J[~fine], off[~fine] = np.eye(6), 0.0
                J[np.abs(np.linalg.det(J)) == 0] = np.eye(6)
                twist = np.linalg.solve(J, off[..., None])[..., 0]
                R, T = _turned(twist[:, :3]) @ R, T + twist[:, 3:]
            off = np.abs(wanted - measured(arrangement, R, T)).max(axis=1)
            far = np.linalg.norm(T - self.T[some], axis=1) / self.length
            far += np.abs(R - self.R[some]).max(axis=(1, 2))
            good = (off <= _RESIDUAL * self.length) & (far < _JUMP)
        return R, T, np.asarray(good)


def _turned(omega: Array) -> Array:
    """Return the rotations by vectors, ``(n, 3) -> (n, 3, 3)``."""
    half = np.linalg.norm(omega, axis=1, keepdims=True) / 2
    with np.errstate(invalid="ignore", over="ignore"):
        part = np.where(half > 0, np.sin(half) / np.where(half > 0, 2 * half, 1.0), 0.5)
        quaternion = np.concatenate((np.cos(half), omega * part), axis=1)
    quaternion[~np.isfinite(quaternion).all(axis=1)] = [1, 0, 0, 0]
    return np.asarray(rotation_from_quaternion(quaternion))
