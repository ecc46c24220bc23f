"""The numbers of an instance as balls, at the working precision and in one unit of length."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from flint import acb, arb, ctx
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Kind, Law
from gspcli.certification.equations.local_frames import StudyFrames, length_scale
from gspcli.certification.numbers.balls import power_of_two, unit_vector
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.primitives import Line, Plane, Point
from gspcli.records import dataclass


@dataclass(frozen=True, eq=False)
class Statement:
    """A constraint with balls for its numbers."""

    #: Those of the constraint.
    kind: Kind
    side: Side
    #: A point of the platform and of the base primitive, in units of the scale.
    a: list[arb]
    b: list[arb]
    #: Direction or normal of the platform and of the base primitive, of length near one; empty for
    #: points.
    u: list[arb]
    v: list[arb]
    #: The distance in units of the scale, or the angle in radians.
    value: arb
    #: Whether the value is exactly zero.
    is_zero: bool
    #: The factor that turns `value` into the units of the instance.
    unit: arb

    @cached_property
    def cosine(self) -> arb:
        """``R u . v`` of an angle constraint, for unit vectors (paper, Section 4)."""
        return _cosine(self.kind.law, self.value)


def _cosine(law: Law, angle: arb) -> arb:
    return law.sign * (angle.cos() if law.is_cosine else angle.sin())


def cosine(constraint: Constraint, unit: AngleUnit) -> arb:
    """Return `Statement.cosine` of an angle constraint."""
    return _cosine(constraint.kind.law, constraint.value.ball() * _radians(unit))


def _radians(unit: AngleUnit) -> arb:
    return arb.pi() / 180 if unit is AngleUnit.DEGREE else arb(1)


def statements(instance: Instance) -> tuple[Statement, ...]:
    """Return the constraints of an instance in balls, lengths in units of `length_scale`."""
    return statements_in(instance, length_scale(instance))


def statements_in(instance: Instance, scale: float) -> tuple[Statement, ...]:
    """Return the constraints of an instance in balls, lengths in units of a power of two."""
    degree = _radians(instance.units.angle)
    return tuple(_statement(row, arb(scale), degree) for row in instance.constraints)


def _statement(constraint: Constraint, scale: arb, degree: arb) -> Statement:
    factor = 1 / scale if constraint.kind.is_distance else degree
    return Statement(
        constraint.kind,
        constraint.side,
        [number.ball() / scale for number in constraint.platform.position],
        [number.ball() / scale for number in constraint.base.position],
        _direction(constraint.platform),
        _direction(constraint.base),
        constraint.value.ball() * factor,
        constraint.value.fraction == 0,
        1 / factor,
    )


def _direction(geometry: Point | Line | Plane) -> list[arb]:
    if isinstance(geometry, Point):
        return []
    factor = power_of_two(max(abs(number.value) for number in geometry.vector))
    return [number.ball() / factor for number in geometry.vector]


#: Arrays of `flint.acb`.
Balls = NDArray[Any]

#: Bits of the numbers: 64 digits, and the digits that cancel.
_PRECISION = 320


class NormalizedNumbers(NamedTuple):
    """The numbers of the constraints, as in `geometry.arrangement.Arrangement`."""

    y: Balls
    """A point of each platform primitive, shape (6, 3)."""
    x: Balls
    """A point of each base primitive, shape (6, 3)."""
    u: Balls
    """The unit direction of each platform primitive, zero for points, shape (6, 3)."""
    v: Balls
    """The unit direction of each base primitive, zero for points, shape (6, 3)."""
    values: Balls
    """The distances without signs, and ``R u . v`` of the angles, shape (6,)."""


def many_digits() -> Any:
    """Return a context with the precision of calculations with these numbers."""
    return ctx.workprec(_PRECISION)


def normalized(instance: Instance, frames: StudyFrames) -> NormalizedNumbers:
    """Return the numbers of an instance in other frames.

    Parameters
    ----------
    instance
        The exact instance.
    frames
        The coordinates; their own numbers are exact.
    """
    unit = arb(length_scale(instance)) / arb(frames.length)
    platform, base = (
        [arb(c) / arb(frames.length) for c in origin] for origin in (frames.platform, frames.base)
    )
    given, nothing = statements(instance), [arb(0)] * 3
    return NormalizedNumbers(
        _array([[c * unit - o for c, o in zip(row.a, platform, strict=True)] for row in given]),
        _array([[c * unit - o for c, o in zip(row.b, base, strict=True)] for row in given]),
        _array([unit_vector(row.u) or nothing for row in given]),
        _array([unit_vector(row.v) or nothing for row in given]),
        _array([_value(row, unit) for row in given]),
    )


def _value(row: Statement, unit: arb) -> arb:
    if row.is_zero and row.kind.is_distance:
        return arb(0)
    return row.value * unit if row.kind.is_distance else row.cosine


def _array(numbers: Any) -> Balls:
    given = np.array(numbers, object)
    return np.array([acb(c.mid()) for c in given.flat], object).reshape(given.shape)
