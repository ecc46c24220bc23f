"""Limits of a machine at poses: ranges of values and cones of joints.

Limits do not change the poses for six values; they restrict which of them the machine can take.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Constraint, Instance, Side
from gspcli.geometry.machine import is_driven
from gspcli.geometry.primitives import Cone, Point
from gspcli.geometry.quaternions import apply
from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.geometry.machine import Machine

Array = NDArray[np.float64]

#: A value is outside a limit if it is so by more than this part of it (angles: of a radian).
ROUNDING = 1e-12
#: The least share above 1.
_ABOVE_ONE = float(np.nextafter(1.0, 2.0))


@dataclass(frozen=True)
class JointCone:
    """The cone of a joint as it limits one leg.

    Attributes
    ----------
    constraint
        The index of the leg.
    body
        The body of the joint, ``platform`` or ``base``.
    name
        The name of the joint.
    cone
        Its axis, fixed in the body, and its half angle.
    """

    constraint: int
    body: Literal["platform", "base"]
    name: str
    cone: Cone


def joint_cones(instance: Instance) -> tuple[JointCone, ...]:
    """Return the cones of an instance, one for each leg and joint that has one."""
    found = []
    for k, row in enumerate(instance.constraints):
        if row.kind is DPP:
            ends: Sequence[tuple[Literal["platform", "base"], str, object]] = (
                ("platform", row.platform_name, row.platform),
                ("base", row.base_name, row.base),
            )
            found += [
                JointCone(k, body, name, joint.cone)
                for body, name, joint in ends
                if isinstance(joint, Point) and joint.cone is not None
            ]
    return tuple(found)


@dataclass(frozen=True)
class LeftLimit:
    """A limit that a pose violates.

    Attributes
    ----------
    kind
        ``range``, ``cone`` or ``working mode``: a crank or slide acts on its rod from the other
        side than at home, so that it would pass a dead point on the way.
    constraint
        The index of the constraint or leg.
    body
        The body of the joint of the cone, or of the point of the drive; None for a range.
    """

    kind: Literal["range", "cone", "working mode"]
    constraint: int
    body: Literal["platform", "base"] | None

    def to_json(self) -> dict[str, Any]:
        """Return it as plain data, constraints numbered from 1."""
        return {"kind": self.kind, "constraint": self.constraint + 1, "body": self.body}


def has_limits(instance: Instance) -> bool:
    """Return whether any constraint has a range or any joint of a leg a cone."""
    ranges = any(row.limits is not None for row in instance.constraints)
    return ranges or bool(joint_cones(instance))


def restricts(instance: Instance) -> bool:
    """Return whether an instance has limits, or drives whose working modes at home are known."""
    return has_limits(instance) or (instance.home is not None and is_driven(instance))


def tilts(instance: Instance, R: ArrayLike, T: ArrayLike, q: ArrayLike | None = None) -> Array:
    """Return how far legs are tilted from the axes of their cones.

    Parameters
    ----------
    instance
        The platform.
    R, T
        Poses, shapes (..., 3, 3) and (..., 3).
    q
        The numbers of the drives there, shape (..., m): cones turn with the arms of cranks. All
        points are where they are stated if None.

    Returns
    -------
    Array
        Angles in the unit of the instance in the order of `joint_cones`, shape (..., cones). The
        direction of a leg leads from the joint of the cone to its other end; NaN at length zero.
    """
    R, T = np.asarray(R, float), np.asarray(T, float)
    arrangement = Arrangement.of(instance)
    drives = None
    if q is None:
        r = arrangement.placed(R, T).r
    else:
        from gspcli.geometry.machine import Machine

        drives = Machine.of(instance)
        r = drives.ends(R, T, q)[2]
    cones = joint_cones(instance)
    found = np.empty((*T.shape[:-1], len(cones)))
    for k, joint in enumerate(cones):
        leg, axis = r[..., joint.constraint, :], joint.cone.unit
        if drives is not None and q is not None:
            axis = drives.turned(joint.constraint, joint.body, axis, q)
        axis = np.broadcast_to(axis, leg.shape)
        direction, axis = (leg, axis) if joint.body == "base" else (-leg, apply(R, axis))
        across = np.linalg.norm(np.cross(axis, direction), axis=-1)
        along = np.einsum("...i,...i->...", axis, direction)
        length = np.hypot(across, along)
        found[..., k] = np.where(length > 0, np.arctan2(across, along), np.nan)
    return found / arrangement.in_radians


def out_of_range(instance: Instance, values: Array) -> NDArray[np.bool_]:
    """Return which values are outside the ranges of their constraints, shape (..., 6).

    By more than the rounding of doubles; a constraint without a range has none outside. Distances
    to planes are signed, and compared on the side that the constraint asks for; if that is both,
    their moduli are.

    Parameters
    ----------
    instance
        The platform with its ranges.
    values
        In the units of the instance, shape (..., 6).
    """
    outside = np.zeros(values.shape, bool)
    for k, constraint in enumerate(instance.constraints):
        if constraint.limits is not None:
            value = _on_its_side(constraint, values[..., k])
            low, high = (limit.value for limit in constraint.limits)
            room = ROUNDING * max(abs(low), abs(high))
            if low == high and constraint.kind.has_sides:
                # A distance to a plane is a difference of coordinates: it has their rounding error.
                room = ROUNDING * max(abs(low), Arrangement.of(instance).length)
            outside[..., k] = (value < low - room) | (value > high + room)
    return outside


def _on_its_side(constraint: Constraint, value: Array) -> Array:
    """Return a value to compare with its range: signed distances on the side that is asked for."""
    if not constraint.kind.has_sides or constraint.side is Side.POSITIVE:
        return value
    return np.abs(value) if constraint.side is Side.BOTH else -value


def range_shares(instance: Instance, values: Array) -> Array:
    """Return the position of each value in its range as a share, shape (..., 6).

    The share is 0 in the middle of a range, 1 at its ends and above 1 where `out_of_range` is true.
    It is 1 at the only value of a range of one value, and NaN without a range.
    """
    shares = np.full(values.shape, np.nan)
    outside = out_of_range(instance, values)
    for k, constraint in enumerate(instance.constraints):
        if constraint.limits is not None:
            low, high = (limit.value for limit in constraint.limits)
            value = _on_its_side(constraint, values[..., k])
            off, half = np.abs(value - (low + high) / 2), (high - low) / 2
            share = off / half if half > 0 else np.where(outside[..., k], np.inf, 1.0)
            shares[..., k] = _agreeing(share, outside[..., k])
    return shares


def out_of_motor_range(drives: Machine, q: Array) -> NDArray[np.bool_]:
    """Return which numbers of cranks and slides are outside their ranges, shape (..., m).

    By more than the rounding of doubles. A number that is NaN, out of reach, is outside; those of
    driven values are not, since `out_of_range` compares them.
    """
    room = ROUNDING * np.maximum(np.abs(drives.low), np.abs(drives.high))
    room = np.where(np.isfinite(room), room, 0.0)
    inside = (q >= drives.low - room) & (q <= drives.high + room)
    return ~inside & drives.moved


def motor_shares(drives: Machine, q: Array) -> Array:
    """Return the position of each crank and slide in its range as a share, shape (..., m).

    As `range_shares`; infinite where the drive does not reach, NaN without a range and for values.
    """
    half = (drives.high - drives.low) / 2
    with np.errstate(all="ignore"):
        off = np.abs(q - (drives.low + drives.high) / 2)
        shares = np.where(half > 0, off / half, np.where(off > 0, np.inf, 1.0))
    shares = _agreeing(shares, out_of_motor_range(drives, q))
    shares = np.where(np.isfinite(half) & drives.moved, shares, np.nan)
    return np.where(np.isnan(q) & drives.moved, np.inf, shares)


def cone_shares(
    instance: Instance, R: ArrayLike, T: ArrayLike, q: ArrayLike | None = None
) -> Array:
    """Return tilts of legs by the half angles of their cones, shape (..., cones); 0 at length zero.

    The share is above 1 where `out_of_cone` is true; arguments as for `tilts`.
    """
    angles = np.array([joint.cone.half_angle.value for joint in joint_cones(instance)])
    shares = np.nan_to_num(tilts(instance, R, T, q) / angles, nan=0.0)
    return _agreeing(shares, out_of_cone(instance, R, T, q))


def _agreeing(shares: Array, outside: NDArray[np.bool_]) -> Array:
    """Return shares that are above 1 exactly where a limit is violated, despite rounding."""
    above: Array = np.where(outside, np.maximum(shares, _ABOVE_ONE), np.minimum(shares, 1.0))
    return above


def out_of_cone(
    instance: Instance, R: ArrayLike, T: ArrayLike, q: ArrayLike | None = None
) -> NDArray[np.bool_]:
    """Return which cones are violated at poses, shape (..., cones), in the order of `joint_cones`.

    A violation exceeds the rounding of doubles. A leg of length zero has no direction and violates
    none. Arguments as for `tilts`.
    """
    angles = np.array([joint.cone.half_angle.value for joint in joint_cones(instance)])
    room = ROUNDING / instance.units.angle.in_radians
    outside: NDArray[np.bool_] = tilts(instance, R, T, q) > angles + room
    return outside


def left_limits(
    instance: Instance, values: Array, R: Array, T: Array
) -> list[tuple[LeftLimit, ...]]:
    """Return the limits that each of n poses violates, ranges first, with drives as stated.

    Parameters
    ----------
    instance
        The platform with its limits.
    values
        What the constraints measure at the poses, shape (n, 6), distances to planes signed.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    """
    limits = [LeftLimit("range", k, None) for k in range(len(instance.constraints))]
    limits += [LeftLimit("cone", joint.constraint, joint.body) for joint in joint_cones(instance)]
    parts = [out_of_range(instance, values), out_of_cone(instance, R, T)]
    if instance.home is not None and is_driven(instance):
        from gspcli.geometry.machine import Machine

        drives = Machine.of(instance)
        bodies: Sequence[Literal["platform", "base"]] = ("base", "platform")
        limits += [
            LeftLimit("working mode", k, bodies[on])
            for k, on in enumerate(drives.on_platform.astype(int))
        ]
        parts.append(drives.in_other_working_modes(R, T))
    left = np.concatenate(parts, axis=1)
    return [tuple(limits[k] for k in np.flatnonzero(row)) for row in left]


def machine_keeps(machine: Machine, R: Array, T: Array) -> NDArray[np.bool_]:
    """Return whether a machine reaches poses within its ranges and cones, shape (n,)."""
    instance, q = machine.instance, machine.inverse(R, T)
    left = (
        out_of_motor_range(machine, q),
        out_of_range(instance, machine.values(R, T)),
        out_of_cone(instance, R, T, q),
    )
    reached = ~np.isnan(q).any(axis=-1)
    return np.asarray(reached & ~np.concatenate(left, axis=-1).any(axis=-1))


def within_limits(
    instance: Instance, values: Array, R: ArrayLike, T: ArrayLike
) -> NDArray[np.bool_]:
    """Return whether all ranges and cones are kept at poses, shape (...).

    Parameters
    ----------
    instance
        The platform with its limits.
    values
        What the constraints measure at the poses, shape (..., 6), distances to planes signed.
    R, T
        The poses, shapes (..., 3, 3) and (..., 3).
    """
    left = np.concatenate((out_of_range(instance, values), out_of_cone(instance, R, T)), axis=-1)
    return np.asarray(~left.any(axis=-1))
