"""The cranks and slides of an instance as balls of doubles, for proofs about boxes of poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import flint
import numpy as np
from flint import arb
from numpy.typing import NDArray

from gspcli.certification.numbers.balls import ball, dot, norm, rotated
from gspcli.certification.numbers.limit_balls import PRECISION, as_pair, exact_rotation
from gspcli.geometry.drive_numbers import Driven, driven_points
from gspcli.geometry.instance import AngleUnit, Constraint, Instance
from gspcli.geometry.primitives import Crank

Array = NDArray[np.float64]
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
    knees: Array
    """The sign of its gain, 1 or -1, shape (m,)."""
    vectors: Array
    """Middle, across, beside, axis, and the point at both ends of the range, (m, 6, 3, 2)."""
    numbers: Array
    """Both ends of the range, in lengths and radians, and the square of the rod, (m, 3, 2)."""


def drive_balls(
    instance: Instance,
    quaternion: Sequence[float],
    pivot: Sequence[float],
    knees: Sequence[float],
) -> DriveBalls | None:
    """Return the motors of an instance, or None if no point is moved by one.

    Parameters
    ----------
    instance
        The platform.
    quaternion, pivot
        As for `gspcli.certification.numbers.limit_balls.limit_balls`.
    knees
        The signs of the gains of the constraints, six.
    """
    driven = [(k, one) for k, row in enumerate(instance.constraints) for one in driven_points(row)]
    if not driven:
        return None
    with flint.ctx.workprec(PRECISION):
        R = exact_rotation([arb(part) for part in quaternion])
        centre = [arb(part) for part in pivot]
        degree = arb.pi() / 180 if instance.units.angle is AngleUnit.DEGREE else arb(1)
        numbers = [_numbers(one, instance.constraints[k], degree) for k, one in driven]
        vectors = [
            _vectors(one, R, centre, ends) for (_, one), ends in zip(driven, numbers, strict=True)
        ]
        pairs = [
            [_pair_or_infinity(number, sign) for number, sign in zip(row, (-1, 1, 1), strict=True)]
            for row in numbers
        ]
        parts = [[[as_pair(part) for part in vector] for vector in row] for row in vectors]
    return DriveBalls(
        np.array([k for k, _ in driven], np.int32),
        np.array([[one.drive.sort == "slide", one.body == "platform"] for _, one in driven]),
        np.array([float(knees[k]) for k, _ in driven]),
        np.array(parts),
        np.array(pairs),
    )


def _numbers(one: Driven, row: Constraint, degree: arb) -> tuple[arb | None, arb | None, arb]:
    """Return the ends of the range, None without one, and the square of the length of the rod."""
    square = ball(row.value) * ball(row.value)
    if one.drive.limits is None:
        return None, None, square
    unit = degree if isinstance(one.drive, Crank) else arb(1)
    low, high = (ball(number) * unit for number in one.drive.limits)
    return low, high, square


def _vectors(
    one: Driven, R: list[_Vector], pivot: _Vector, ends: Sequence[arb | None]
) -> list[_Vector]:
    """Return the vectors of `DriveBalls` of one motor."""
    point = [ball(number) for number in one.point.position]
    nothing = [arb(0)] * 3
    if isinstance(one.drive, Crank):
        axis = _unit([ball(number) for number in one.drive.axis])
        centre = [ball(number) for number in one.drive.centre]
        arm = [a - b for a, b in zip(point, centre, strict=True)]
        height = dot(axis, arm)
        middle = [a + height * b for a, b in zip(centre, axis, strict=True)]
        across = [a - b for a, b in zip(point, middle, strict=True)]
        beside = _cross(axis, across)
    else:
        axis = _unit([ball(number) for number in one.drive.direction])
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


def _cross(a: _Vector, b: _Vector) -> _Vector:
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def _unit(vector: _Vector) -> _Vector:
    size = norm(vector)
    return [part / size for part in vector]


def _pair_or_infinity(number: arb | None, sign: int) -> tuple[float, float]:
    return (sign * np.inf, 0.0) if number is None else as_pair(number)
