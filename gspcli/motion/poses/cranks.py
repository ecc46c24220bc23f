"""Inverse kinematics of rotary platforms: the angles of cranks at given poses."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.coordinates import Coordinate, coordinates
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.primitives import Point, as_array
from gspcli.motion.poses.inverse_kinematics import checked_poses

Array = NDArray[np.float64]

#: The cosine of an angle above one by less is one: at the end of what a crank can reach.
_END = 1e-12


def crank_angles(
    instance: Instance, R: ArrayLike, T: ArrayLike, *, along: bool = True
) -> tuple[tuple[Coordinate, ...], Array]:
    """Return the angles of all cranks of an instance at poses; its values stay the same.

    The circle of a crank meets the sphere about the other end of the leg in two points. At the
    first pose the point nearer to the stated one is taken. At each other pose the point nearer to
    that at the pose before is taken if poses are a path; otherwise the one nearer to the stated
    one.

    Parameters
    ----------
    instance
        Its points with cranks have one point-point distance each; other values are not used.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3), ``x_base = R x_platform + T``, in length units.
    along
        Whether the poses are a path, one after the other.

    Returns
    -------
    cranks, angles
        The cranks, m of them, and their angles in the unit of the instance, shape (n, m); NaN where
        a leg does not reach the circle. Along a way they do not jump by half a turn or more.

    Raises
    ------
    ArgumentError
        If there is no crank, or one that is not at the end of exactly one leg.
    """
    rotations, translations = checked_poses(R, T)
    rotations, translations = rotations.reshape(-1, 3, 3), translations.reshape(-1, 3)
    cranks = tuple(one for one in coordinates(instance) if one.vector == "crank")
    if not cranks:
        message = "no point has a crank: state crank: {centre: [...], axis: [...]} at a point"
        raise ArgumentError(message)
    choose = _continuous if along else _nearest
    angles = [
        choose(_angles(_leg(instance, one), one.body, rotations, translations)) for one in cranks
    ]
    return cranks, np.stack(angles, axis=1) / instance.units.angle.in_radians


def _leg(instance: Instance, crank: Coordinate) -> Constraint:
    name = f"{crank.body}_name"
    legs = [row for row in instance.constraints if getattr(row, name) == crank.primitive]
    if len(legs) != 1 or legs[0].kind is not DPP:
        kinds = ", ".join(row.kind.name for row in legs) or "none"
        message = f"{crank.name}: the constraints of its point are {kinds}, expected one DPP"
        raise ArgumentError(message)
    return legs[0]


def _angles(leg: Constraint, body: str, R: Array, T: Array) -> Array:
    """Return the two angles of the crank of a leg in radians, shape (n, 2)."""
    platform, base = leg.platform, leg.base
    assert isinstance(platform, Point)
    assert isinstance(base, Point)
    if body == "base":
        point, other = base, R @ platform.point + T
    else:
        point, other = platform, np.einsum("nji,nj->ni", R, base.point - T)
    crank = point.crank
    assert crank is not None
    axis, centre = as_array(crank.axis), as_array(crank.centre)
    axis = axis / np.linalg.norm(axis)
    arm = point.point - centre
    height = axis @ arm
    arm = arm - height * axis
    across = np.cross(axis, arm)
    # |other - centre - height axis - arm cos - across sin|^2 = d^2 is linear in cos and sin.
    apart = other - centre - height * axis
    along, beside = apart @ arm, apart @ across
    right = (np.sum(apart**2, axis=1) + arm @ arm - leg.value.value**2) / 2
    with np.errstate(all="ignore"):
        cosine = right / np.hypot(along, beside)
        reached = np.abs(cosine) <= 1 + _END
        half = np.arccos(np.clip(cosine, -1, 1))
    middle = np.arctan2(beside, along)
    both = np.stack((middle - half, middle + half), axis=1)
    both[~reached] = np.nan
    return both


def _nearest(both: Array) -> Array:
    """Return of two angles each the one nearest to zero, by whole turns."""
    near = both - 2 * np.pi * np.round(both / (2 * np.pi))
    least: Array = near[np.arange(len(near)), np.abs(near).argmin(axis=1)]
    return least


def _continuous(both: Array) -> Array:
    """Return of two angles each the one nearest to that before, by whole turns; NaN is left out."""
    found, last = np.full(len(both), np.nan), 0.0
    for k, pair in enumerate(both):
        if np.isnan(pair[0]):
            continue
        near = pair - 2 * np.pi * np.round((pair - last) / (2 * np.pi))
        last = found[k] = near[np.abs(near - last).argmin()]
    return found
