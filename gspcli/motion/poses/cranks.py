"""Inverse kinematics of platforms with arms and rails: the numbers of the drives at given poses."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.coordinates import Coordinate, coordinates
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.motion.poses.inverse_kinematics import checked_poses, values_at

Array = NDArray[np.float64]


def drive_values(
    instance: Instance, R: ArrayLike, T: ArrayLike, *, along: bool = True
) -> tuple[Drives, Array]:
    """Return the drives of an instance and their numbers at poses, in lengths and radians.

    A crank or slide reaches a pose with two numbers. The knee of the stated home pose chooses one
    of them (`gspcli.geometry.drives`). Without a stated home it is the knee of the first pose that
    the drive reaches if poses are a path; otherwise at each pose the number nearer to zero.

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
        knees at home are not known.
    """
    rotations, translations = checked_poses(R, T)
    rotations, translations = rotations.reshape(-1, 3, 3), translations.reshape(-1, 3)
    drives = Drives.of(instance)
    if along or drives.home_knees is not None:
        q = drives.inverse(rotations, translations)
    else:
        q = drives.nearest(rotations, translations)
    if along:
        for k in range(drives.count):
            if drives.sorts[k] == "crank" and not np.isfinite(drives.high[k] - drives.low[k]):
                known = np.isfinite(q[:, k])
                q[known, k] = np.unwrap(q[known, k])
    return drives, q


def refusals(drives: Drives, R: Array, T: Array, q: Array) -> dict[int, str]:
    """Return why a machine cannot take poses, by their rows.

    Parameters
    ----------
    drives, R, T, q
        The drives, poses of shapes (n, 3, 3) and (n, 3), and the numbers there, shape (n, m).
    """
    found: dict[int, str] = {}
    wanted = drives.wanted(R, T)
    there = values_at(drives.instance, R, T)
    for row, k in np.argwhere(np.isnan(q)).tolist():
        users, name = drives.users(k), drives.names[k]
        numbers = wanted[row, users] / drives.units[k]
        if drives.stays[users[0]]:
            stated = drives.instance.constraints[users[0]].value.value
            reason = f"value {name} is {there[row, users[0]]:.6g} and stays at {stated:.6g}"
        elif np.isnan(numbers).any():
            rod = "leg" if len(users) == 1 else f"rod {users[int(np.isnan(numbers).argmax())] + 1}"
            reason = f"the {rod} of {name} does not reach"
        else:
            rods = " and ".join(str(one + 1) for one in users)
            asked = " and ".join(f"{x:.6g}" for x in numbers)
            reason = f"rods {rods} ask for {asked} of {name}"
        found[row] = f"{found[row]}; {reason}" if row in found else reason
    return found


def crank_angles(
    instance: Instance, R: ArrayLike, T: ArrayLike, *, along: bool = True
) -> tuple[tuple[Coordinate, ...], Array]:
    """Return the angles of all cranks of an instance at poses; its values stay the same.

    Arguments as for `drive_values`.

    Returns
    -------
    cranks, angles
        The cranks, k of them, and their angles as `coordinates` has them, in the unit of the
        instance, shape (n, k); NaN where a rod does not reach.

    Raises
    ------
    ArgumentError
        If there is no crank, or one that is not at the end of exactly one leg.
    """
    cranks = tuple(one for one in coordinates(instance) if one.vector == "crank")
    if not cranks:
        message = "no point has a crank: state crank: {centre: [...], axis: [...]} at a point"
        raise ArgumentError(message)
    for one in cranks:
        name = f"{one.body}_name"
        legs = [row for row in instance.constraints if getattr(row, name) == one.primitive]
        if any(leg.kind is not DPP for leg in legs):
            kinds = ", ".join(row.kind.name for row in legs)
            message = f"{one.name}: the constraints of its point are {kinds}, expected one DPP"
            raise ArgumentError(message)
    drives, q = drive_values(instance, R, T, along=along)
    chosen = [drives.names.index(one.name) for one in cranks]
    return cranks, q[:, chosen] / instance.units.angle.in_radians
