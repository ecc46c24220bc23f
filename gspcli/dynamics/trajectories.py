"""Twists and accelerations of a platform along rows of poses or of values with times."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Array
from gspcli.geometry.quaternions import (
    conjugate,
    cross,
    quaternion_from_rotation,
    quaternion_product,
)

#: The columns of velocities and accelerations in files.
VELOCITY = ("wx", "wy", "wz", "vx", "vy", "vz")
ACCELERATION = ("alphax", "alphay", "alphaz", "ax", "ay", "az")
#: A quintic spline has this many coefficients at least, and a row for each.
_FEWEST_ROWS = 6
#: From row to row a platform turns by less than this (radians): further turns have two ways.
_LARGEST_TURN = np.pi / 2


class PoseRates(NamedTuple):
    """How a platform moves at n poses, each shape (n, 6): (omega, v) and its derivative.

    The angular velocity and the velocity of the origin of the platform, in the axes of the base;
    radians, and the unit of length that the poses have.
    """

    twists: Array
    accelerations: Array


def motion_of_platform(frame: PoseFrame, R: Array, expressed: PoseRates) -> PoseRates:
    """Return the motion of the platform's origin from an expressed motion.

    Parameters
    ----------
    frame
        The frame in which poses are expressed: an expressed motion is that of its point of the
        platform, along its axes of the base.
    R
        Rotations of the platform at n poses, shape (n, 3, 3).
    expressed
        The expressed motion.
    """
    axes, arm = frame.of_base.R, frame.of_platform.T
    if axes is not None:
        expressed = PoseRates(*(_turned(part, axes.T) for part in expressed))
    return expressed if arm is None else _at(expressed, R @ -arm)


def _turned(vectors: Array, axes: Array) -> Array:
    """Return rows of two vectors each in other axes, shape (n, 6)."""
    return (vectors.reshape(-1, 3) @ axes).reshape(vectors.shape)


def _at(motion: PoseRates, arm: Array) -> PoseRates:
    """Return the motion of a point at an arm from the one whose motion is given."""
    omega, alpha = motion.twists[:, :3], motion.accelerations[:, :3]
    twists, accelerations = motion.twists.copy(), motion.accelerations.copy()
    turned = cross(omega, arm)
    twists[:, 3:] += turned
    accelerations[:, 3:] += cross(alpha, arm) + cross(omega, turned)
    return PoseRates(twists, accelerations)


def at_rest(poses: int) -> PoseRates:
    """Return the motion of poses that stand still."""
    return PoseRates(np.zeros((poses, 6)), np.zeros((poses, 6)))


def spline_motion(t: Array, R: Array, T: Array) -> PoseRates:
    """Return twists and accelerations from quintic splines through positions and quaternions.

    Parameters
    ----------
    t
        Increasing times in seconds, shape (n,).
    R, T
        Poses, shapes (n, 3, 3) and (n, 3).

    Raises
    ------
    ArgumentError
        If there are fewer than six rows, if times do not increase, or if the platform turns by
        more than 90 degrees from one row to the next.
    GspError
        If SciPy is missing.
    """
    try:
        from scipy.interpolate import make_interp_spline
    except ImportError as error:
        message = "rows with times need SciPy, which is missing: pip install 'gspcli[dynamics]'"
        raise GspError(message) from error
    if len(t) < _FEWEST_ROWS:
        message = (
            f"found {len(t)} rows with times, expected at least {_FEWEST_ROWS} for a quintic "
            "spline; or give the velocities and accelerations of each row"
        )
        raise ArgumentError(message)
    check_times(t)
    e = quaternion_from_rotation(R)
    turns = (e[1:] * e[:-1]).sum(axis=-1)
    far = np.abs(turns) < np.cos(_LARGEST_TURN / 2)
    if far.any():
        row = int(far.argmax())
        angle = np.degrees(2 * np.arccos(abs(turns[row])))
        message = (
            f"the platform turns by {angle:.3g} degrees from row {row + 1} to row {row + 2}, "
            "expected less than 90: give more rows"
        )
        raise ArgumentError(message)
    e[1:] *= np.where(turns < 0, -1.0, 1.0).cumprod()[:, None]
    # Splines of what is small keep their digits: from the first row on.
    offset = np.concatenate((T[0], np.zeros(4)))
    spline = make_interp_spline(t - t[0], np.concatenate((T, e), axis=1) - offset, k=5)
    first, second = (spline.derivative(k)(t - t[0]) for k in (1, 2))
    # With e' = p e and e'' = (p' + p p) e: the vector of p is omega / 2, and its scalar is the
    # change of the norm, which splines do not keep.
    rate, bend = (quaternion_product(part[:, 3:], conjugate(e)) for part in (first, second))
    omega = 2 * rate[:, 1:]
    alpha = 2 * bend[:, 1:] - 2 * rate[:, :1] * omega
    return PoseRates(
        np.concatenate((omega, first[:, :3]), axis=1),
        np.concatenate((alpha, second[:, :3]), axis=1),
    )


def check_times(t: Array) -> None:
    """Refuse times that do not increase.

    Raises
    ------
    ArgumentError
        Naming the first row that is not later than the one before.
    """
    late = np.diff(t) <= 0
    if late.any():
        row = int(late.argmax())
        message = (
            f"found {t[row + 1]:g} at row {row + 2} after {t[row]:g}, expected times that increase"
        )
        raise ArgumentError(message, "t")
