"""The numbers of ranges and cones as balls of doubles, for proofs about boxes of poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import flint
import numpy as np
from flint import arb
from numpy.typing import NDArray

from gspcli.catalogue.kinds import AHH, AHL, ALH, ALL, DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.certification.numbers.balls import ball, norm, rotated
from gspcli.certification.numbers.rounding import OUTWARD, TINY
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.limits import joint_cones
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Point

Array = NDArray[np.float64]

PRECISION = 160
#: The measured quantities, with the numbers of native/reach.hpp.
_MEASURES: dict[Kind, int] = {
    DPP: 0, DPL: 1, DLP: 2, DPH: 3, DHP: 4, DLL: 5, ALL: 6, ALH: 6, AHL: 6, AHH: 6,
}  # fmt: skip


class LimitBalls(NamedTuple):
    """The numbers of an instance for native/reach.cpp; a pair is a double and a radius."""

    measures: NDArray[np.int32]
    """What each constraint measures, shape (6,)."""
    moduli: NDArray[np.bool_]
    """Whether the modulus of that is compared, shape (6,)."""
    vectors: Array
    """Point and unit direction of the platform, of the base, shape (6, 4, 3, 2)."""
    ranges: Array
    """Least and largest of what is measured, infinite where all is allowed, shape (6, 2, 2)."""
    legs: NDArray[np.int32]
    """The constraint of each cone, shape (c,)."""
    of_base: NDArray[np.bool_]
    """Whether its joint is on the base, shape (c,)."""
    axes: Array
    """Its unit axis, shape (c, 3, 2)."""
    cosines: Array
    """The cosine of its half angle, shape (c, 2)."""


def limit_balls(
    instance: Instance, quaternion: Sequence[float], pivot: Sequence[float]
) -> LimitBalls:
    """Return the limits of an instance with a turned platform, its points relative to a pivot.

    Parameters
    ----------
    instance
        The platform.
    quaternion
        The rotation, scalar first, of any length; its doubles are taken as exact.
    pivot
        A point of the platform, exact doubles, in length units.
    """
    with flint.ctx.workprec(PRECISION):
        R = exact_rotation([arb(part) for part in quaternion])
        centre = [arb(part) for part in pivot]
        degree = arb.pi() / 180 if instance.units.angle is AngleUnit.DEGREE else arb(1)
        rows, cones = instance.constraints, joint_cones(instance)
        vectors = [_vectors(row, R, centre) for row in rows]
        ranges = [_range(row, degree) for row in rows]
        axes, cosines = [], []
        for joint in cones:
            axis = _unit([ball(number) for number in joint.cone.axis])
            axes.append(_pairs(axis if joint.body == "base" else rotated(R, axis)))
            cosines.append(as_pair((ball(joint.cone.half_angle) * degree).cos()))
    return LimitBalls(
        np.array([_MEASURES[row.kind] for row in rows], np.int32),
        np.array([row.kind.has_sides and row.side is Side.BOTH for row in rows]),
        np.array(vectors),
        np.array(ranges),
        np.array([joint.constraint for joint in cones], np.int32),
        np.array([joint.body == "base" for joint in cones], bool),
        np.array(axes).reshape(-1, 3, 2),
        np.array(cosines).reshape(-1, 2),
    )


def exact_rotation(q: Sequence[arb]) -> list[list[arb]]:
    """Return the matrix of a quaternion of any length, scalar first."""
    w, x, y, z = q
    size = w * w + x * x + y * y + z * z
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return [[entry / size for entry in row] for row in rows]


def _vectors(
    row: Constraint, R: list[list[arb]], pivot: list[arb]
) -> list[list[tuple[float, float]]]:
    point = [ball(number) - part for number, part in zip(row.platform.position, pivot, strict=True)]
    return [
        _pairs(rotated(R, point)),
        _pairs(rotated(R, _direction(row.platform))),
        _pairs([ball(number) for number in row.base.position]),
        _pairs(_direction(row.base)),
    ]


def _direction(geometry: Geometry) -> list[arb]:
    if isinstance(geometry, Point):
        return [arb(0)] * 3
    exact = geometry.normal if hasattr(geometry, "normal") else geometry.direction
    return _unit([ball(number) for number in exact])


def _unit(vector: list[arb]) -> list[arb]:
    size = norm(vector)
    return [part / size for part in vector]


def _range(row: Constraint, degree: arb) -> list[tuple[float, float]]:
    """Return the least and the largest measured number of the kernel."""
    if row.limits is None:
        return [(-np.inf, 0.0), (np.inf, 0.0)]
    low, high = row.limits
    kind = row.kind
    if not kind.is_distance:
        # An angle at an end of its range is no limit.
        ends = (0, 180) if kind in (ALL, AHH) else (-90, 90)
        first, last = (
            None if _is(number, end, degree) else ball(number) * degree
            for number, end in zip(row.limits, ends, strict=True)
        )
        if kind is ALL:
            first, last = (None if a is None else a.cos() for a in (last, first))
        elif kind is AHH:
            first, last = (None if a is None else -a.cos() for a in (first, last))
        else:
            first, last = (None if a is None else a.sin() for a in (first, last))
    elif kind.has_sides:
        first, last = ball(low), ball(high)
        if row.side is Side.NEGATIVE:
            first, last = -last, -first
    else:
        first = None if low.value == 0 else ball(low) * ball(low)
        last = ball(high) * ball(high)
    return [
        (-np.inf, 0.0) if first is None else as_pair(first),
        (np.inf, 0.0) if last is None else as_pair(last),
    ]


def _is(number: Number, degrees: int, degree: arb) -> bool:
    """Return whether an angle is an end of its range, or cannot be distinguished from it."""
    return (ball(number) * degree - degrees * arb.pi() / 180).contains(0)


def _pairs(vector: Sequence[arb]) -> list[tuple[float, float]]:
    return [as_pair(part) for part in vector]


def as_pair(value: arb) -> tuple[float, float]:
    """Return a double and a radius that enclose a ball."""
    nearest = float(value)
    return nearest, float((value - nearest).abs_upper()) * OUTWARD + TINY
