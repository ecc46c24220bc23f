"""The numbers in the equations of an instance, exactly and modulo primes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from gspcli.catalogue.kinds import Kind, Law
from gspcli.certification.counting.elements import Angle, FieldElement, element, in_radians, squared
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.primitives import Line, Plane, Point, Vector
from gspcli.records import dataclass

_ZERO, _ONE = FieldElement.of(0), FieldElement.of(1)
_SIGNS: dict[Side, tuple[int, ...]] = {
    Side.POSITIVE: (1,),
    Side.NEGATIVE: (-1,),
    Side.BOTH: (1, -1),
}


@dataclass(frozen=True)
class ExactConstraint:
    """A constraint with exact numbers.

    Attributes
    ----------
    kind
        The kind.
    a, b
        A point of the platform and of the base primitive.
    u, v
        Direction or normal of either, of any length; empty for points.
    value
        The number in the equation: the square of the distance; for DPH and DHP the distance times
        the length of the normal; for angles the value of ``R u . v``.
    sides
        The signs of the value: both 1 and -1 for a DPH or DHP of both sides.
    """

    kind: Kind
    a: tuple[FieldElement, ...]
    b: tuple[FieldElement, ...]
    u: tuple[FieldElement, ...]
    v: tuple[FieldElement, ...]
    value: FieldElement
    sides: tuple[int, ...]

    @property
    def numbers(self) -> Iterator[FieldElement]:
        """All numbers of the constraint."""
        yield from (*self.a, *self.b, *self.u, *self.v, self.value)


@dataclass(frozen=True)
class EvaluatedConstraint:
    """A constraint with numbers in some arithmetic, on one side.

    The attributes are those of `ExactConstraint`; `is_zero` is whether the exact value is zero.
    """

    kind: Kind
    a: Sequence[Any]
    b: Sequence[Any]
    u: Sequence[Any]
    v: Sequence[Any]
    value: Any
    is_zero: bool

    def on_side(self, sign: int) -> EvaluatedConstraint:
        """Return the constraint with its value times 1 or -1."""
        return self if sign == 1 else replace(self, value=-self.value)


def exact_constraints(
    instance: Instance, *, values_free: bool = False
) -> tuple[ExactConstraint, ...]:
    """Return the constraints of an instance with exact numbers.

    Parameters
    ----------
    instance
        The instance.
    values_free
        Whether its values are ignored: all become 1.

    Raises
    ------
    NoElementError
        If a number, a length or a cosine lies outside the ring of `exact_numbers`.
    """
    return tuple(_exact(row, instance.units.angle, values_free) for row in instance.constraints)


def evaluated(
    constraint: ExactConstraint, evaluate: Callable[[FieldElement], Any]
) -> EvaluatedConstraint:
    """Return a constraint in other arithmetic, such as residues modulo a prime."""

    def vector(numbers: tuple[FieldElement, ...]) -> list[Any]:
        return [evaluate(number) for number in numbers]

    return EvaluatedConstraint(
        constraint.kind,
        vector(constraint.a),
        vector(constraint.b),
        vector(constraint.u),
        vector(constraint.v),
        evaluate(constraint.value),
        constraint.value.is_zero,
    )


def _exact(constraint: Constraint, unit: AngleUnit, values_free: bool) -> ExactConstraint:
    kind = constraint.kind
    u, v = _direction(constraint.platform), _direction(constraint.base)
    is_zero = constraint.value.fraction == 0
    return ExactConstraint(
        kind,
        _elements(constraint.platform.position),
        _elements(constraint.base.position),
        u,
        v,
        _ONE if values_free else _value(constraint, unit, u, v),
        _SIGNS[constraint.side] if kind.has_sides and not is_zero else (1,),
    )


def _value(
    constraint: Constraint,
    unit: AngleUnit,
    u: tuple[FieldElement, ...],
    v: tuple[FieldElement, ...],
) -> FieldElement:
    kind = constraint.kind
    if not kind.is_distance:
        cosine = _cosine(kind.law, in_radians(constraint.value, unit))
        return cosine if cosine.is_zero else cosine * (_square(u) * _square(v)).sqrt()
    if not kind.has_sides:
        return squared(constraint.value)
    value = element(constraint.value)
    return value if value.is_zero else value * _square(v or u).sqrt()


def _elements(vector: Vector) -> tuple[FieldElement, ...]:
    return tuple(element(number) for number in vector)


def _direction(geometry: Point | Line | Plane) -> tuple[FieldElement, ...]:
    if isinstance(geometry, Point):
        return ()
    return _elements(geometry.vector)


def _square(vector: tuple[FieldElement, ...]) -> FieldElement:
    return sum((x * x for x in vector), _ZERO)


def _cosine(law: Law, angle: Angle) -> FieldElement:
    """Return the value of ``R u . v`` of unit vectors (paper, Section 4)."""
    value = angle.cos() if law.is_cosine else angle.sin()
    return value if law.sign > 0 else -value
