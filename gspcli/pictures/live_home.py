"""What a live page needs to go home a safe way: limits, and a small map of poses.

The page tries the straight way of values, then that of poses, then the poses of the map
(`gspcli.motion.paths.home_map`). It proves with the kernel that no pose on the way is singular, and
looks at the limits itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.errors import GspError
from gspcli.geometry.drive_numbers import is_driven
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import joint_cones
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.geometry.readings import readings_of

if TYPE_CHECKING:
    from gspcli.solver.result import SolveResult

Array = NDArray[np.float64]

#: Digits of the poses of the map, relative to their sizes: any pose near to them will do.
_DIGITS = 9


def live_home(result: SolveResult) -> dict[str, Any]:
    """Return what a page needs to bring a platform home.

    Returns
    -------
    dict
        ``within``: of each value or motor the least and the largest reading that the file allows,
        or None (distances to planes without sign). ``cones``: of each cone the
        ``points`` of its leg on the platform and the base, its ``body``, its unit ``axis`` in the
        frame of the body and its half ``angle`` in radians; None if cones turn with arms, so that a
        page does not look at them. ``middle``: the middle of the
        points of the platform, which straight ways of poses move on a line. ``signed``: whether
        poses with different signs of det J are apart. ``poses`` of the map: seven numbers each,
        position and quaternion; home is not among them. ``after``: the index of the next pose on
        its way, -1 for home.
    """
    instance = result.instance
    return {
        "within": _within(instance),
        "cones": _cones(result),
        "middle": _middle(result),
        # A distance of two lines turns at zero, where no pose need be singular.
        "signed": all(row.kind is not DLL for row in instance.constraints),
        **_map(result),
    }


def _within(instance: Instance) -> list[list[float] | None]:
    """Return the ranges of values, or of motors, as readings."""
    ends = np.full((2, 6), np.nan)
    for k, row in enumerate(instance.constraints):
        if row.limits is not None:
            ends[:, k] = [limit.value for limit in row.limits]
    found = _pairs(readings_of(instance, ends, signed=False))
    if not is_driven(instance):
        return found
    drives = Drives.of(instance)
    moved = _pairs(drives.readings(np.stack((drives.low, drives.high))))
    return [
        moved[k] if sort != "value" else found[drives.users(k)[0]]
        for k, sort in enumerate(drives.sorts)
    ]


def _pairs(ends: Array) -> list[list[float] | None]:
    return [sorted(pair) if np.isfinite(pair).all() else None for pair in ends.T.tolist()]


def _cones(result: SolveResult) -> list[dict[str, Any]] | None:
    instance = result.instance
    cones, joints = joint_cones(instance), result.arrangement
    if cones and is_driven(instance):
        return None
    return [
        {
            "body": one.body,
            "axis": one.cone.unit.tolist(),
            "points": [points[one.constraint].tolist() for points in (joints.y, joints.x)],
            "angle": one.cone.half_angle.value * result.arrangement.in_radians,
        }
        for one in cones
    ]


def _middle(result: SolveResult) -> list[float]:
    return [float(x) for x in result.arrangement.platform_centre]


def _map(result: SolveResult) -> dict[str, Any]:
    from gspcli.motion.paths.home_map import home_map

    try:
        found = home_map(result, 0 if result.home is None else result.home.number - 1)
    except GspError:
        # Such as knees that are not known: then there are straight ways alone.
        found = None
    if found is None:
        return {"poses": [], "after": []}
    size = float(np.abs(found.T).max()) or 1.0
    decimals = _DIGITS - int(np.floor(np.log10(size)))
    numbers = np.concatenate(
        (found.T.round(decimals), quaternion_from_rotation(found.R).round(_DIGITS)), axis=1
    )
    return {"poses": numbers[1:].tolist(), "after": (found.after[1:] - 1).tolist()}
