"""Rotations by three angles about coordinate axes, in the letter case of SciPy."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import GspError
from gspcli.wording import shown

Array = NDArray[np.float64]

_AXES = "xyz"
#: Cosines of the middle angle below this leave the two other angles undetermined.
_LOCKED = 1e-9


#: The orders of makers that a public source states (`docs/tables.md`), by lower-case names.
MAKERS = {"pi": "XYZ", "linuxcnc": "ZYX", "symetrie": "ZYX", "symétrie": "ZYX"}
#: Names that are refused, and why.
_REFUSED = {
    "simhub": "was found in no public source: look in the manual of the controller, and give the "
    "axes, such as ZYX",
    "kuka": "begins with z: A is about z, B about y, C about x. Name the columns rz, ry, rx in the "
    "place of A, B, C (--columns does), and give the order ZYX",
}


def named_order(text: str) -> str:
    """Return the order of axes that a text names: a maker, or the axes themselves.

    Raises
    ------
    GspError
        If it names none.
    """
    name = text.strip().lower()
    if name in MAKERS:
        return MAKERS[name]
    if name in _REFUSED:
        raise GspError(f"the order of {shown(text)} {_REFUSED[name]}")
    return check_sequence(text)


def check_sequence(sequence: str) -> str:
    """Return a sequence of axes unchanged if it names three different axes in one case.

    Raises
    ------
    GspError
        If it does not.
    """
    if not re.fullmatch("[xyz]{3}|[XYZ]{3}", sequence) or len(set(sequence)) != 3:
        raise GspError(
            f"found the Euler sequence {shown(sequence)}, expected three different axes: such as "
            "ZYX (about the axes of the platform, one after the other) or xyz (about those of the "
            "base)"
        )
    return sequence


def rotation_from_euler(sequence: str, angles: Any) -> Array:
    """Return rotations by angles about three axes.

    Parameters
    ----------
    sequence
        The order of the axes, as ``scipy.spatial.transform.Rotation.from_euler`` has it: capital
        letters turn about the axes of the moving frame, ``ZYX = R_z R_y R_x``, small ones about
        those of the fixed frame, ``zyx = R_x R_y R_z``.
    angles
        The angles about x, y and z (for any order of the axes), in radians, shape (..., 3).

    Returns
    -------
    Array
        Rotations, shape (..., 3, 3).

    Raises
    ------
    GspError
        If the sequence does not name three different axes in one case.
    """
    check_sequence(sequence)
    angles = np.asarray(angles, float)
    R: Array = np.broadcast_to(np.eye(3), (*angles.shape[:-1], 3, 3))
    for letter in sequence:
        turn = _about(_AXES.index(letter.lower()), angles)
        R = R @ turn if letter.isupper() else turn @ R
    return R


def _about(axis: int, angles: Array) -> Array:
    """Return the rotations about one coordinate axis by its angle, (..., 3) -> (..., 3, 3)."""
    sine, cosine = np.sin(angles[..., axis]), np.cos(angles[..., axis])
    j, k = (axis + 1) % 3, (axis + 2) % 3
    turn = np.zeros((*angles.shape[:-1], 3, 3))
    turn[..., axis, axis] = 1
    turn[..., j, j] = turn[..., k, k] = cosine
    turn[..., k, j], turn[..., j, k] = sine, -sine
    return turn


def euler_from_rotation(sequence: str, R: Any) -> Array:
    """Return the angles about three axes that make a rotation; see `rotation_from_euler`.

    Parameters
    ----------
    sequence
        The order of the axes.
    R
        Rotations, shape (..., 3, 3).

    Returns
    -------
    Array
        The angles about x, y and z, in radians, shape (..., 3): the middle one of the sequence
        between -pi/2 and pi/2, the others between -pi and pi. Where the middle one is at an end
        of its range only a sum or difference of the others is determined; the last turn about
        an axis of the platform is zero then.

    Raises
    ------
    GspError
        If the sequence does not name three different axes in one case.
    """
    check_sequence(sequence)
    R = np.asarray(R, float)
    # Turns about fixed axes are those about moving ones in the opposite order.
    order = sequence if sequence.isupper() else sequence[::-1]
    i, j, k = (_AXES.index(letter) for letter in order.lower())
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    angles = np.empty(R.shape[:-1])
    sine = sign * R[..., i, k]
    # Where the sine is near one, the cosine is more accurate.
    angles[..., j] = np.arctan2(sine, np.hypot(R[..., i, i], R[..., i, j]))
    locked = np.hypot(R[..., i, i], R[..., i, j]) < _LOCKED
    first = np.arctan2(-sign * R[..., j, k], R[..., k, k])
    angles[..., i] = np.where(locked, np.arctan2(sign * R[..., k, j], R[..., j, j]), first)
    angles[..., k] = np.where(locked, 0.0, np.arctan2(-sign * R[..., i, j], R[..., i, i]))
    return angles
