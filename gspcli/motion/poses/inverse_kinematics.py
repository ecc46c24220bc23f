"""Inverse kinematics: the values of the constraints at given poses, and their derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gspcli.catalogue.kinds import DLL
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement, Array
from gspcli.geometry.checking import real_array
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import measured
from gspcli.geometry.readings import readings_of

#: Poses measured at a time: their intermediate arrays stay in the cache of a core.
_CHUNK = 2000
#: Largest entry of R R^T - 1 for a rotation whose entries are rounded to three decimals.
_ROTATION = 4e-3


def measure(instance: Instance, R: Any, T: ArrayLike | None = None) -> Array:
    """Return the values of all constraints at poses, in the units of the instance.

    The values of the instance itself are not used. Distances to planes (DPH and DHP) are signed:
    positive on the side to which the normal points. All other distances are at least zero. Where
    a constraint has an offset it is subtracted: the results are the readings of the machine.

    Parameters
    ----------
    instance
        The geometry and units.
    R
        Rotations, shape (..., 3, 3), ``x_base = R x_platform + T``, or a `Rotation` of SciPy.
        Without T a pose: a pair (R, T), or a mode of a result.
    T
        Translations, shape (..., 3), in length units.

    Returns
    -------
    Array
        Distances and angles in the order of the instance, shape (..., 6).

    Raises
    ------
    ArgumentError
        If the arrays have other shapes or numbers that are not finite.
    """
    return readings_of(instance, values_at(instance, R, T))


def values_at(instance: Instance, R: Any, T: ArrayLike | None = None) -> Array:
    """Return the distances and angles at poses; as `measure`, but without offsets."""
    R, T = checked_poses(R, T)
    arrangement = Arrangement.of(instance)
    rotations, translations = R.reshape(-1, 3, 3), T.reshape(-1, 3)
    values = np.empty((len(rotations), len(arrangement.kinds)))
    for start in range(0, len(rotations), _CHUNK):
        rows = slice(start, start + _CHUNK)
        values[rows] = measured(arrangement, rotations[rows], translations[rows])
    skew = [kind is DLL for kind in arrangement.kinds]
    values[:, skew] = np.abs(values[:, skew])
    values[:, arrangement.angles] /= arrangement.in_radians
    return values.reshape(*T.shape[:-1], len(arrangement.kinds))


def pose_parts(pose: Any, name: str) -> tuple[Any, Any]:
    """Return R and T of a pose: of a pair, or of what has both, such as a mode of a result.

    Raises
    ------
    ArgumentError
        If it is neither; `name` is that of the argument.
    """
    if hasattr(pose, "R") and hasattr(pose, "T") and not isinstance(pose, np.ndarray):
        return pose.R, pose.T
    if isinstance(pose, tuple | list) and len(pose) == 2:
        return pose[0], pose[1]
    raise ArgumentError(
        f"found a {type(pose).__name__}, expected a pose: (R, T), or a mode of a result", name
    )


def checked_poses(R: Any, T: Any = None) -> tuple[Array, Array]:
    """Return poses as arrays of shapes (..., 3, 3) and (..., 3).

    Parameters
    ----------
    R
        Rotations, as arrays or as a `Rotation` of SciPy. Without T a pose: a pair (R, T), or what
        has both, such as a mode of `SolveResult`.
    T
        Translations. One rotation may stand for many translations, and one translation for many
        rotations.

    Raises
    ------
    ArgumentError
        If they have other shapes or numbers that are not finite, or R is no rotation.
    """
    if T is None:
        R, T = pose_parts(R, "R")
    R, T = real_array(R.as_matrix() if hasattr(R, "as_matrix") else R, "R"), real_array(T, "T")
    try:
        if R.shape[-2:] != (3, 3) or T.shape[-1:] != (3,):
            raise ValueError
        leading = np.broadcast_shapes(R.shape[:-2], T.shape[:-1])
    except ValueError:
        raise ArgumentError(
            f"R has shape {R.shape} and T {T.shape}, expected (..., 3, 3) and (..., 3) with the "
            "same leading axes"
        ) from None
    R, T = np.broadcast_to(R, (*leading, 3, 3)).copy(), np.broadcast_to(T, (*leading, 3)).copy()
    for name, part in (("R", R), ("T", T)):
        if not np.isfinite(part).all():
            index = tuple(np.argwhere(~np.isfinite(part))[0].tolist())
            raise ArgumentError(
                f"found {part[index]}, expected a finite number", f"{name}{list(index)}"
            )
    off = np.abs(R @ R.swapaxes(-1, -2) - np.eye(3)).max(axis=(-1, -2))
    wrong = np.argwhere((off > _ROTATION) | (np.linalg.det(R) < 0))
    if len(wrong):
        place = wrong[0].tolist()
        raise ArgumentError("found a matrix that is no rotation", f"R{place if place else ''}")
    return R, T


def drive_values(
    instance: Instance, R: ArrayLike, T: ArrayLike, *, along: bool = True
) -> tuple[Machine, Array]:
    """Return the drives of an instance and their numbers at poses, in lengths and radians.

    A crank or slide reaches a pose with two numbers. The working mode of the stated home pose
    chooses one of them (`gspcli.geometry.machine`). Without a stated home it is the working mode of
    the first pose that the drive reaches if poses are a path; otherwise at each pose the number
    nearer to zero.

    Parameters
    ----------
    instance
        The platform.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3), ``x_base = R x_platform + T``, in length units.
    along
        Whether the poses are a path. The angles of cranks without a range do not jump by half a
        turn or more along it.

    Returns
    -------
    drives, q
        Of shape (n, m); NaN where a rod does not reach, and where the rods of one carriage ask for
        different numbers.

    Raises
    ------
    ArgumentError
        If a point with a drive belongs to another constraint than distances of two points, or the
        working modes at home are not known.
    """
    rotations, translations = checked_poses(R, T)
    rotations, translations = rotations.reshape(-1, 3, 3), translations.reshape(-1, 3)
    drives = Machine.of(instance)
    if along:
        return drives, drives.along(rotations, translations)
    if drives.home_working_modes is None:
        return drives, drives.nearest(rotations, translations)
    return drives, drives.inverse(rotations, translations)


def changed_value(drives: Machine, k: int, value: float) -> str:
    """Return in words that a value that stays is another one at a pose."""
    stated = drives.instance.constraints[k].value.value
    return f"value {k + 1} is {value:.6g} and stays at {stated:.6g}"


def refusals(drives: Machine, R: Array, T: Array, q: Array) -> dict[int, str]:
    """Return why a machine cannot take poses, by their rows.

    Parameters
    ----------
    drives, R, T, q
        The drives, poses of shapes (n, 3, 3) and (n, 3), and the numbers there, shape (n, m).
    """
    found: dict[int, str] = {}
    if not np.isnan(q).any():
        return found
    wanted = drives.wanted(R, T)
    there = values_at(drives.instance, R, T)
    for row, k in np.argwhere(np.isnan(q)).tolist():
        users, name = drives.users(k), drives.names[k]
        numbers = wanted[row, users] / drives.units[k]
        if drives.stays[users[0]]:
            reason = changed_value(drives, users[0], there[row, users[0]])
        elif np.isnan(numbers).any():
            first = users[int(np.isnan(numbers).argmax())]
            alone = len(users) == 1 and not drives.planes[first]
            reason = f"the {'leg' if alone else drives.user(first)} of {name} does not reach"
        else:
            rods = " and ".join(str(one + 1) for one in users)
            asked = " and ".join(f"{x:.6g}" for x in numbers)
            what = "constraints" if drives.planes[users].any() else "rods"
            reason = f"{what} {rods} ask for {asked} of {name}"
        found[row] = f"{found[row]}; {reason}" if row in found else reason
    return found
