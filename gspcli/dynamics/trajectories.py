"""Twists and accelerations of a platform along rows of poses or of values with times."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.dynamics.quintic_splines import FEWEST_ROWS, derivatives
from gspcli.errors import ArgumentError
from gspcli.geometry.quaternions import conjugate, quaternion_from_rotation, quaternion_product

Array = NDArray[np.float64]

#: The columns of velocities and accelerations in files.
VELOCITY = ("wx", "wy", "wz", "vx", "vy", "vz")
ACCELERATION = ("alphax", "alphay", "alphaz", "ax", "ay", "az")
#: From row to row a platform turns by less than this (radians): further turns have two ways.
_LARGEST_TURN = np.pi / 2


class Motion(NamedTuple):
    """How a platform moves at n poses, each shape (n, 6): (omega, v) and its derivative.

    The angular velocity and the velocity of the origin of the platform, in the axes of the base;
    radians, and the unit of length that the poses have.
    """

    twists: Array
    accelerations: Array


def at_rest(poses: int) -> Motion:
    """Return the motion of poses that stand still."""
    return Motion(np.zeros((poses, 6)), np.zeros((poses, 6)))


def spline_motion(t: Array, R: Array, T: Array) -> Motion:
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
    """
    if len(t) < FEWEST_ROWS:
        message = (
            f"found {len(t)} rows with times, expected at least {FEWEST_ROWS} for a quintic "
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
    first, second = derivatives(t - t[0], np.concatenate((T, e), axis=1) - offset)
    # With e' = p e and e'' = (p' + p p) e: the vector of p is omega / 2, and its scalar is the
    # change of the norm, which splines do not keep.
    rate, bend = (quaternion_product(part[:, 3:], conjugate(e)) for part in (first, second))
    omega = 2 * rate[:, 1:]
    alpha = 2 * bend[:, 1:] - 2 * rate[:, :1] * omega
    return Motion(
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
