"""The numbers of ranges and cones as balls of doubles, for proofs about boxes of poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import flint
import numpy as np
from flint import arb
from numpy.typing import NDArray

from gspcli.catalogue.kinds import ANGLE_KINDS, DHP, DLL, DLP, DPH, DPL, DPP, Kind, Law
from gspcli.certification.numbers.balls import cross, dot, rotated, unit_vector
from gspcli.certification.numbers.rounding import TINY
from gspcli.geometry import study
from gspcli.geometry.enclosures import above
from gspcli.geometry.instance import AngleUnit, Array, Constraint, Instance, Side
from gspcli.geometry.machine import MovedPoint, driven_points, joint_cones
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, Geometry, Point

PRECISION = 160
#: The measured quantities, with the numbers of native/reach.hpp.
_MEASURES: dict[Kind, int] = {
    **dict(zip((DPP, DPL, DLP, DPH, DHP, DLL), range(6), strict=True)),
    **dict.fromkeys(ANGLE_KINDS, 6),
}


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
        R = _rotation(quaternion)
        centre = [arb(part) for part in pivot]
        degree = _radians(instance)
        rows, cones = instance.constraints, joint_cones(instance)
        vectors = [_vectors(row, R, centre) for row in rows]
        ranges = [_range(row, degree) for row in rows]
        axes, cosines = [], []
        for joint in cones:
            axis = _unit(joint.cone.axis)
            axes.append(_pairs(axis if joint.body == "base" else rotated(R, axis)))
            cosines.append(as_pair((joint.cone.half_angle.ball() * degree).cos()))
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


def _rotation(quaternion: Sequence[float]) -> list[list[arb]]:
    """Return the matrix of a quaternion of any length, scalar first, in balls."""
    size, rows, _ = study.motion([arb(part) for part in (*quaternion, 0, 0, 0, 0)])
    return [[entry / size for entry in row] for row in rows]


def _radians(instance: Instance) -> arb:
    return arb.pi() / 180 if instance.units.angle is AngleUnit.DEGREE else arb(1)


def _vectors(
    row: Constraint, R: list[list[arb]], pivot: list[arb]
) -> list[list[tuple[float, float]]]:
    point = [
        number.ball() - part for number, part in zip(row.platform.position, pivot, strict=True)
    ]
    return [
        _pairs(rotated(R, point)),
        _pairs(rotated(R, _direction(row.platform))),
        _pairs([number.ball() for number in row.base.position]),
        _pairs(_direction(row.base)),
    ]


def _direction(geometry: Geometry) -> list[arb]:
    return [arb(0)] * 3 if isinstance(geometry, Point) else _unit(geometry.vector)


def _unit(vector: Sequence[Number]) -> list[arb]:
    return unit_vector([number.ball() for number in vector])


def _range(row: Constraint, degree: arb) -> list[tuple[float, float]]:
    """Return the least and the largest measured number of the kernel."""
    if row.limits is None:
        return [(-np.inf, 0.0), (np.inf, 0.0)]
    low, high = row.limits
    kind = row.kind
    if not kind.is_distance:
        # An angle at an end of its range is no limit. Cosines fall, unless their sign is changed.
        law = kind.law
        least, most = (0, 180) if law.is_cosine else (-90, 90)
        first, last = (
            None
            if _is(number, end, degree)
            else law.sign * (angle.cos() if law.is_cosine else angle.sin())
            for number, end in ((low, least), (high, most))
            for angle in [number.ball() * degree]
        )
        if law is Law.COSINE:
            first, last = last, first
    elif kind.has_sides:
        first, last = low.ball(), high.ball()
        if row.side is Side.NEGATIVE:
            first, last = -last, -first
    else:
        first = None if low.value == 0 else low.ball() * low.ball()
        last = high.ball() * high.ball()
    return [
        (-np.inf, 0.0) if first is None else as_pair(first),
        (np.inf, 0.0) if last is None else as_pair(last),
    ]


def _is(number: Number, degrees: int, degree: arb) -> bool:
    """Return whether an angle is an end of its range, or cannot be distinguished from it."""
    return (number.ball() * degree - degrees * arb.pi() / 180).contains(0)


def _pairs(vector: Sequence[arb]) -> list[tuple[float, float]]:
    return [as_pair(part) for part in vector]


def as_pair(value: arb) -> tuple[float, float]:
    """Return a double and a radius that enclose a ball."""
    nearest = float(value)
    return nearest, above(float((value - nearest).abs_upper())) + TINY


_Vector = list[arb]


class DriveBalls(NamedTuple):
    """The m motors that move a point of a distance, for native/drives.cpp.

    A pair is a double and a radius. Vectors of the platform are turned as it is at home, its points
    relative to the pivot.
    """

    rows: NDArray[np.int32]
    """The constraint of each, shape (m,)."""
    sorts: NDArray[np.bool_]
    """Whether it is a slide, and whether it moves the platform's point, shape (m, 2)."""
    working_modes: Array
    """The sign of its gain, 1 or -1, shape (m,)."""
    vectors: Array
    """Middle, across, beside, axis, and the point at both ends of the range, (m, 6, 3, 2)."""
    numbers: Array
    """Both ends of the range, in lengths and radians, and the square of the rod, (m, 3, 2)."""


def drive_balls(
    instance: Instance,
    quaternion: Sequence[float],
    pivot: Sequence[float],
    working_modes: Sequence[float],
) -> DriveBalls | None:
    """Return the motors of an instance, or None if no point is moved by one.

    Parameters
    ----------
    instance
        The platform.
    quaternion, pivot
        As for `gspcli.certification.numbers.limit_balls.limit_balls`.
    working_modes
        The signs of the gains of the constraints, six.
    """
    driven = [(k, one) for k, row in enumerate(instance.constraints) for one in driven_points(row)]
    if not driven:
        return None
    with flint.ctx.workprec(PRECISION):
        R = _rotation(quaternion)
        centre = [arb(part) for part in pivot]
        degree = _radians(instance)
        numbers = [_drive_numbers(one, instance.constraints[k], degree) for k, one in driven]
        vectors = [
            _drive_vectors(one, R, centre, ends)
            for (_, one), ends in zip(driven, numbers, strict=True)
        ]
        pairs = [
            [_pair_or_infinity(number, sign) for number, sign in zip(row, (-1, 1, 1), strict=True)]
            for row in numbers
        ]
        parts = [[[as_pair(part) for part in vector] for vector in row] for row in vectors]
    return DriveBalls(
        np.array([k for k, _ in driven], np.int32),
        np.array([[one.drive.sort == "slide", one.body == "platform"] for _, one in driven]),
        np.array([float(working_modes[k]) for k, _ in driven]),
        np.array(parts),
        np.array(pairs),
    )


def _drive_numbers(
    one: MovedPoint, row: Constraint, degree: arb
) -> tuple[arb | None, arb | None, arb]:
    """Return the ends of the range, None without one, and the square of the length of the rod."""
    square = row.value.ball() * row.value.ball()
    if one.drive.limits is None:
        return None, None, square
    scale = degree if isinstance(one.drive, Crank) else arb(1)
    low, high = (number.ball() * scale for number in one.drive.limits)
    return low, high, square


def _drive_vectors(
    one: MovedPoint, R: list[_Vector], pivot: _Vector, ends: Sequence[arb | None]
) -> list[_Vector]:
    """Return the vectors of `DriveBalls` of one motor."""
    point = [number.ball() for number in one.point.position]
    nothing = [arb(0)] * 3
    if isinstance(one.drive, Crank):
        axis = _unit(one.drive.axis)
        centre = [number.ball() for number in one.drive.centre]
        arm = [a - b for a, b in zip(point, centre, strict=True)]
        height = dot(axis, arm)
        middle = [a + height * b for a, b in zip(centre, axis, strict=True)]
        across = [a - b for a, b in zip(point, middle, strict=True)]
        beside = cross(axis, across)
    else:
        axis = _unit(one.drive.direction)
        middle, across, beside = point, axis, nothing

    def place(q: arb | None) -> _Vector:
        if q is None:
            return nothing
        c, s = (q.cos(), q.sin()) if isinstance(one.drive, Crank) else (q, arb(0))
        return [m + a * c + b * s for m, a, b in zip(middle, across, beside, strict=True)]

    points = [middle, place(ends[0]), place(ends[1])]
    if one.body == "platform":
        points = [rotated(R, [a - b for a, b in zip(x, pivot, strict=True)]) for x in points]
        across, beside, axis = (rotated(R, x) for x in (across, beside, axis))
    return [points[0], across, beside, axis, points[1], points[2]]


def _pair_or_infinity(number: arb | None, sign: int) -> tuple[float, float]:
    return (sign * np.inf, 0.0) if number is None else as_pair(number)
