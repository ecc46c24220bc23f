"""Where the joints of a chain are in space, for drawing it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.realization import JointAxis, JointKind, PlacedJoint, Realization
from gspcli.geometry.tolerances import PARALLEL_SINE
from gspcli.pictures.strokes import perpendicular
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Distances between joints on one axis, and of a driver beyond the base, in sizes of a joint.
_APART, _BEYOND = 2.6, 3.4
#: Shorter legs than this are drawn longer, in sizes of a joint.
_SHORTEST = 5.0
#: Joints of a short leg are drawn smaller, but not below this part of the size.
_SMALLEST = 0.4


@dataclass(frozen=True, eq=False)
class ChainEnds:
    """What a chain connects, at one pose.

    Attributes
    ----------
    platform, base
        A point of each primitive, shape (3,).
    w, v
        Unit direction or normal of each primitive, shape (3,); zero for a point.
    """

    platform: Array
    base: Array
    w: Array
    v: Array


@dataclass(frozen=True, eq=False)
class MountedJoint:
    """A joint in space: where it is, and the unit direction of its axis, shapes (3,)."""

    placed: PlacedJoint
    at: Array
    axis: Array


def mounted(realization: Realization, ends: ChainEnds, joint: float) -> tuple[MountedJoint, ...]:
    """Return the joints of a chain in space, from the platform to the base.

    Joints on the leg share the way between the ends; those on a line or in a plane lie side by
    side there; drivers at the base are beyond its primitive. The directions of the axes are
    true, and so are the places of joints at the ends.

    Parameters
    ----------
    realization
        The chain.
    ends
        What it connects.
    joint
        The size of a joint, in length units.
    """
    joints = realization.chain.joints
    way = ends.base - ends.platform
    length = float(np.linalg.norm(way))
    down = way / length if length > PARALLEL_SINE else np.array([0.0, 0.0, -1.0])
    leg = down if realization.kinds[0].is_distance else _hinge(ends, down)
    across = perpendicular(leg)
    directions = {
        JointAxis.PLATFORM: ends.w,
        JointAxis.BASE: ends.v,
        JointAxis.LEG: leg,
        JointAxis.ACROSS: across,
        JointAxis.ACROSS_TOO: np.cross(leg, across),
    }
    places = _places(joints, ends, down, joint)
    if not realization.kinds[0].is_distance and JointAxis.ACROSS in {p.axis for p in joints}:
        # Three hinges and three slides have no place of their own.
        steps = np.linspace(0, 1, len(joints))
        places = [ends.platform + t * way for t in steps]
    return tuple(
        MountedJoint(placed, at, directions[placed.axis])
        for placed, at in zip(joints, places, strict=True)
    )


def fitting(ends: ChainEnds, joint: float) -> float:
    """Return the size of joints that find room between the ends, at most `joint`."""
    length = float(np.linalg.norm(ends.platform - ends.base))
    return joint * min(1.0, max(length / (_SHORTEST * joint), _SMALLEST))


def stretched(ends: ChainEnds, joint: float) -> ChainEnds:
    """Return the ends apart enough to draw joints between them.

    The ends of angles may be anywhere on their lines and planes; where those meet, the ends
    are moved along them.
    """
    if np.linalg.norm(ends.platform - ends.base) >= _SHORTEST * joint:
        return ends
    step = _SHORTEST * joint
    return ChainEnds(ends.platform + step * ends.w, ends.base + step * ends.v, ends.w, ends.v)


def _hinge(ends: ChainEnds, down: Array) -> Array:
    """Return the axis about which an angle turns: perpendicular to both directions."""
    axis = np.cross(ends.w, ends.v)
    norm = float(np.linalg.norm(axis))
    return axis / norm if norm > PARALLEL_SINE else perpendicular(down)


def _places(
    joints: tuple[PlacedJoint, ...], ends: ChainEnds, down: Array, joint: float
) -> list[Array]:
    """Return the places of the joints of a chain, in order."""
    last = len(joints)
    while last and joints[last - 1].driven and joints[last - 1].axis is JointAxis.LEG:
        last -= 1
    inside = joints[:last]
    on_leg = [k for k, placed in enumerate(inside) if placed.axis is JointAxis.LEG]
    at_platform = [k for k, placed in enumerate(inside) if placed.axis is JointAxis.PLATFORM]
    at_base = [k for k, placed in enumerate(inside) if placed.axis is JointAxis.BASE]
    across = [k for k, p in enumerate(inside) if p.axis in (JointAxis.ACROSS, JointAxis.ACROSS_TOO)]
    places: dict[int, Array] = {}
    for rank, k in enumerate(on_leg):
        t = (rank + 1) / (len(on_leg) + 1)
        places[k] = (1 - t) * ends.platform + t * ends.base
    for where, direction, which in (
        (ends.platform, ends.w, at_platform),
        (ends.base, ends.v, at_base),
    ):
        for rank, k in enumerate(which):
            offset = (rank - (len(which) - 1) / 2) * _APART * joint
            places[k] = where + offset * direction
    # In a mirrored chain they are at the platform.
    at_top = bool(across) and bool(on_leg) and across[0] < on_leg[0]
    for rank, k in enumerate(across):
        # Crossing hinges are one universal joint; slides lie one on the other.
        apart = 0.0 if joints[k].joint is JointKind.REVOLUTE else 0.55 * _APART * joint
        if at_top:
            places[k] = ends.platform + rank * apart * down
        else:
            places[k] = ends.base - (len(across) - 1 - rank) * apart * down
    for rank, k in enumerate(range(last, len(joints))):
        places[k] = ends.base + (rank + 1) * _BEYOND * joint * down
    return [places[k] for k in range(len(joints))]
