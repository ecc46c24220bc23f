"""The constraints as equations in functions of a motion, in any exact arithmetic.

The functions are 1, R (by rows), T, U, rho and T x R, in the order of
`gspcli.geometry.study`, and the mutual moments of the line pairs behind them. An
equation is ``F + w1 G1^2 + w2 G2^2 + ... = 0`` with linear combinations F, G of them: PL and LP say
``|X x v|^2 = d^2 |v|^2`` and LL ``M^2 + d^2 C^2 = d^2 |u|^2 |v|^2`` (paper, Section 4).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace
from enum import IntFlag
from typing import Any

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind, Law
from gspcli.certification.counting.elements import Angle, FieldElement, element, in_radians, squared
from gspcli.certification.numbers.balls import cross, dot
from gspcli.geometry import study
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.primitives import Line, Plane, Point, Vector
from gspcli.records import dataclass


class Blocks(IntFlag):
    """Blocks of coordinates besides R, with the numbers of the kernel."""

    TRANSLATION = 1
    BODY = 2
    DISTANCE = 4


_T, _U, _RHO = Blocks.TRANSLATION, Blocks.BODY, Blocks.DISTANCE
#: The sets with the degree of their variety (data/varieties.json).
DEGREES: dict[Blocks, int] = {_T: 8, _U: 8, _T | _U: 20, _T | _U | _RHO: 40}
_LINEAR = {DPH: _T, DHP: _U, DPP: _T | _U | _RHO}
_NEEDED = {DPL: _T, DLP: _U}


def quadrics(blocks: Blocks, kinds: Sequence[Kind]) -> int:
    """Return the number of constraints that are quadrics in a set of coordinates."""
    return sum(
        kind.is_distance and (kind not in _LINEAR or _LINEAR[kind] not in blocks) for kind in kinds
    )


def choose(kinds: Sequence[Kind]) -> Blocks:
    """Return the set with the least product of its degree and those of the equations."""
    possible = [
        blocks
        for blocks in DEGREES
        if all(_NEEDED[kind] in blocks for kind in kinds if kind in _NEEDED)
    ]
    return min(possible, key=lambda blocks: DEGREES[blocks] << quadrics(blocks, kinds))


#: A linear combination: coefficients of the functions, by their position.
Function = study.Form
#: The number of functions without moments.
FUNCTIONS = study.COUNT - 1


@dataclass(frozen=True)
class MotionEquation:
    """``linear + sum of weight * square^2 = 0``."""

    #: The function that enters linearly.
    linear: Function
    #: Pairs of a weight and a function.
    squares: list[tuple[Any, Function]] = field(default_factory=list)


@dataclass(frozen=True)
class MotionEquations:
    """The equations of a platform."""

    #: The mutual moments of the DLL constraints: functions of position `FUNCTIONS` and following.
    moments: list[Function]
    #: One for each constraint.
    equations: list[MotionEquation]


def equations(constraints: Sequence[EvaluatedConstraint]) -> MotionEquations:
    """Return the equations of constraints."""
    moments: list[Function] = []
    result = []
    for row in constraints:
        if row.kind is DLL:
            position = FUNCTIONS + len(moments)
            moments.append(study.mutual_moment(row.a, row.b, row.u, row.v))
            result.append(_distance_of_lines(row, position))
        else:
            result.append(_equation(row))
    return MotionEquations(moments, result)


def with_moments(given: MotionEquations) -> MotionEquations:
    """Return equations followed by the definitions of the moments."""
    definitions = [
        MotionEquation({**moment, FUNCTIONS + k: -1}) for k, moment in enumerate(given.moments)
    ]
    return MotionEquations(given.moments, [*given.equations, *definitions])


def parallel_lines(
    row: EvaluatedConstraint, weights: Sequence[Any], *, in_base: bool
) -> tuple[MotionEquation, MotionEquation]:
    """Return functions that vanish if the lines of a DLL are parallel, or have its distance.

    Parameters
    ----------
    row
        The DLL.
    weights
        A random vector w: ``w . (R u x v)`` is zero where the lines are parallel.
    in_base
        Whether to measure the distance between parallel lines by T, else by U.
    """
    crossing = MotionEquation(study.rotation_form(cross(row.v, weights), row.u))
    return crossing, _distance_from_line(row, in_base=in_base)


def _equation(row: EvaluatedConstraint) -> MotionEquation:
    if row.kind in (DPL, DLP):
        return _distance_from_line(row, in_base=row.kind is DPL)
    (function,) = study.forms_of(row.kind, row.a, row.b, row.u, row.v)
    function[study.NORM] = function.get(study.NORM, 0) - row.value
    return MotionEquation(function)


def _distance_from_line(row: EvaluatedConstraint, *, in_base: bool) -> MotionEquation:
    """Return the equation of the distance of a point from the line of the base or the platform."""
    height, axis = (study.base_height, row.v) if in_base else (study.platform_height, row.u)
    squares = [(1, height(row.a, row.b, normal)) for normal in _normals(axis)]
    return MotionEquation({study.NORM: -row.value * dot(axis, axis)}, squares)


def _normals(axis: Sequence[Any]) -> list[list[Any]]:
    """Return three vectors n with ``|w x axis|^2`` the sum of the ``(w . n)^2``."""
    x, y, z = axis
    return [[0 * x, z, -y], [-z, 0 * x, x], [y, -x, 0 * x]]


def _distance_of_lines(row: EvaluatedConstraint, moment: int) -> MotionEquation:
    if row.is_zero:
        return MotionEquation({moment: 1})
    size = dot(row.u, row.u) * dot(row.v, row.v)
    return MotionEquation(
        {study.NORM: -row.value * size},
        [(1, {moment: 1}), (row.value, study.rotation_form(row.v, row.u))],
    )


# The numbers in the equations of an instance, exactly and modulo primes.


_ZERO, _ONE = FieldElement.of(0), FieldElement.of(1)
_SIGNS: dict[Side, tuple[int, ...]] = {
    Side.POSITIVE: (1,),
    Side.NEGATIVE: (-1,),
    Side.BOTH: (1, -1),
}


@dataclass(frozen=True)
class ExactConstraint:
    """A constraint with exact numbers."""

    #: The kind.
    kind: Kind
    #: A point of the platform and of the base primitive.
    a: tuple[FieldElement, ...]
    b: tuple[FieldElement, ...]
    #: Direction or normal of either, of any length; empty for points.
    u: tuple[FieldElement, ...]
    v: tuple[FieldElement, ...]
    #: The number in the equation: the square of the distance; for DPH and DHP the distance times
    #: the length of the normal; for angles the value of ``R u . v``.
    value: FieldElement
    #: The signs of the value: both 1 and -1 for a DPH or DHP of both sides.
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
