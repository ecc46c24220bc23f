"""The polynomial equations of an instance in Study coordinates, with balls as coefficients.

Each constraint is ``A = 0`` or ``N A - B^2 - C^2 = 0`` with quadratic forms A, B, C, equivalent to
the constraint as stated wherever ``N != 0``:

* angles, PP and PH or HP on one side: one quadric, linear in the forms of `study`;
* PL: ``|w|^2 |u|^2 - (w . u)^2 = d^2 |u|^2`` with w from a point of the line to the point and u
  along the line, and LP likewise; ``N |w|^2`` is the quadric of PP and ``N w . u`` one more;
* LL: ``d^2 (|u|^2 |v|^2 - (u . v)^2) = M^2`` with the mutual moment M. For d = 0 this is the
  square of ``M = 0``, which is taken instead.

No direction is normalised, so only square roots of lengths and cosines of angles (and whatever
the input itself contains) are irrational.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import acb, acb_mat, arb, arb_mat
from numpy.typing import NDArray

from gspcli.catalogue.kinds import ALL, ALH, AHL, DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.certification import study
from gspcli.certification.balls import (
    OUTWARD,
    ball,
    cross,
    direction_vector,
    dot,
    float_above,
    length_vector,
    norm,
)
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.primitives import Geometry, Line, Plane, Point

#: A quadratic form: coefficients of the forms of `study`, by their position.
Form = dict[int, arb]


@dataclass(frozen=True)
class Equation:
    """The equation ``A = 0`` (no squares) or ``N A = B^2 + ...``, by indices of quadrics."""

    main: int
    squares: tuple[int, ...] = ()


def direction(geometry: Geometry) -> list[arb]:
    """Return balls of a line's direction or a plane's normal, up to a positive factor."""
    if isinstance(geometry, Line):
        return direction_vector(geometry.direction)
    if isinstance(geometry, Plane):
        return direction_vector(geometry.normal)
    message = "a point has no direction"
    raise TypeError(message)


def angle_cosine(constraint: Constraint, unit: AngleUnit) -> arb:
    """Return ``R u1 . u2`` of an angle constraint, for unit vectors (paper, Section 4)."""
    angle = ball(constraint.value)
    if unit is AngleUnit.DEGREE:
        angle = angle * arb.pi() / 180
    if constraint.kind is ALL:
        return angle.cos()
    if constraint.kind in (ALH, AHL):
        return angle.sin()
    return -angle.cos()


def length_scale(instance: Instance) -> float:
    """Return a power of two near the largest length in an instance."""
    lengths = [abs(c.value.value) for c in instance.constraints if c.kind.is_distance]
    for constraint in instance.constraints:
        for geometry in (constraint.platform, constraint.base):
            lengths += [abs(number.value) for number in geometry.position]
    size = max(lengths)
    return 2.0 ** math.frexp(size)[1] if 0 < size < math.inf else 1.0


class System:
    """The equations of an instance at the working precision.

    Lengths are in units of `length_scale`, a power of two, so that all coordinates are
    of a similar size.

    Parameters
    ----------
    instance
        The exact instance.
    precision
        Bits; the caller works at this precision too (``flint.ctx``).
    """

    def __init__(self, instance: Instance, precision: int) -> None:
        self.instance = instance
        self.precision = precision
        self.scale = length_scale(instance)
        self._forms: list[Form] = [{study.NORM: arb(1)}, {study.STUDY: arb(1)}]
        #: For each constraint its equation, or those of its positive and its negative side.
        self.equations = tuple(self._equations(constraint) for constraint in instance.constraints)
        rows = [[form.get(k, arb(0)) for k in range(study.COUNT)] for form in self._forms]
        count = len(rows)
        hessians = arb_mat(rows) * arb_mat(study.hessians())
        self._hessians = acb_mat(arb_mat(8 * count, 8, hessians.entries()))
        self._moduli = np.array([float_above(entry) for entry in hessians.entries()])
        self._moduli.shape = (count, 8, 8)

    @property
    def is_finite(self) -> bool:
        """Whether every coefficient is a number (``acos(2)`` is none)."""
        return bool(np.isfinite(self._moduli).all())

    def _add(self, form: Form) -> int:
        self._forms.append(form)
        return len(self._forms) - 1

    def _equations(self, constraint: Constraint) -> tuple[Equation, ...]:
        if not constraint.kind.is_distance:
            u, v = direction(constraint.platform), direction(constraint.base)
            cosine = angle_cosine(constraint, self.instance.units.angle)
            form = _rotation_form(v, u)
            form[study.NORM] = -cosine * norm(u) * norm(v)
            return (Equation(self._add(form)),)
        scale = arb(self.scale)
        a = length_vector(constraint.platform.position, scale)
        b = length_vector(constraint.base.position, scale)
        d = ball(constraint.value) / scale
        if constraint.kind is DPP:
            return (Equation(self._add(_square_distance(a, b, d))),)
        if constraint.kind is DPL:
            along = direction(constraint.base)
            return (self._distance_to_line(a, b, d, along, _base_height(a, b, along)),)
        if constraint.kind is DLP:
            along = direction(constraint.platform)
            return (self._distance_to_line(a, b, d, along, _platform_height(a, b, along)),)
        if constraint.kind in (DPH, DHP):
            if constraint.kind is DPH:
                normal = direction(constraint.base)
                height = _base_height(a, b, normal)
            else:
                normal = direction(constraint.platform)
                height = _scaled(_platform_height(a, b, normal), arb(-1))
            return self._heights(height, d * norm(normal), constraint)
        return (self._distance_of_lines(a, b, d, constraint),)

    def _heights(self, height: Form, value: arb, constraint: Constraint) -> tuple[Equation, ...]:
        sides = {Side.POSITIVE: (1,), Side.NEGATIVE: (-1,), Side.BOTH: (1, -1)}[constraint.side]
        return tuple(
            Equation(self._add({**height, study.NORM: height[study.NORM] - sign * value}))
            for sign in sides
        )

    def _distance_to_line(
        self, a: list[arb], b: list[arb], d: arb, along: list[arb], height: Form
    ) -> Equation:
        square = _scaled(_square_distance(a, b, d), dot(along, along))
        return Equation(self._add(square), (self._add(height),))

    def _distance_of_lines(
        self, a: list[arb], b: list[arb], d: arb, constraint: Constraint
    ) -> Equation:
        u, v = direction(constraint.platform), direction(constraint.base)
        # (R a + T - b) . (R u x v) = v . R (a x u) + v . (T x R u) - R u . (v x b)
        moment = _rotation_form(v, cross(a, u))
        for index, coefficient in _rotation_form(cross(v, b), u).items():
            moment[index] -= coefficient
        for i in range(3):
            for j in range(3):
                moment[study.MOMENT[i][j]] = v[i] * u[j]
        if constraint.value.fraction == 0:
            return Equation(self._add(moment))
        main: Form = {study.NORM: d * d * dot(u, u) * dot(v, v)}
        cosine = _scaled(_rotation_form(v, u), d)
        return Equation(self._add(main), (self._add(moment), self._add(cosine)))

    def sides_at(self, point: Sequence[acb]) -> tuple[int, ...]:
        """Return for each constraint the index of the side whose equation is nearer to zero."""
        column = acb_mat(8, 1, list(point))
        values = self._values(column, self._gradients(column))
        return tuple(
            min(range(len(sides)), key=lambda k: float(values[sides[k].main].abs_upper()))
            for sides in self.equations
        )

    def _gradients(self, column: acb_mat) -> acb_mat:
        return acb_mat(len(self._forms), 8, (self._hessians * column).entries())

    def _values(self, column: acb_mat, gradients: acb_mat) -> list[acb]:
        return [value / 2 for value in (gradients * column).entries()]

    def at(self, point: Sequence[acb], sides: Sequence[int]) -> tuple[acb_mat, acb_mat]:
        """Return the seven equations, six constraints and ``e . f``, and their Jacobian.

        Parameters
        ----------
        point
            A Study point, 8 coordinates.
        sides
            For each constraint the index of its equation.

        Returns
        -------
        values, jacobian
            Shapes (7, 1) and (7, 8).
        """
        column = acb_mat(8, 1, list(point))
        gradients = self._gradients(column)
        quadrics = self._values(column, gradients)
        # The chain rule: derivatives of the equations by the values of the quadrics.
        outer = [[acb(0)] * len(quadrics) for _ in range(7)]
        values = [quadrics[1]]
        outer[0][1] = acb(1)
        for row, (equations, side) in enumerate(zip(self.equations, sides, strict=True), 1):
            equation = equations[side]
            value, derivative = quadrics[equation.main], acb(1)
            if equation.squares:
                outer[row][study.NORM] += value
                value, derivative = value * quadrics[0], quadrics[0]
            outer[row][equation.main] += derivative
            for index in equation.squares:
                outer[row][index] -= 2 * quadrics[index]
                value -= quadrics[index] * quadrics[index]
            values.append(value)
        return acb_mat(7, 1, values), acb_mat(outer) * gradients

    def curvatures(self, moduli: NDArray[np.float64], sides: Sequence[int]) -> NDArray[np.float64]:
        """Bound the sum of the moduli of all second derivatives of each equation.

        Parameters
        ----------
        moduli
            Upper bounds of the moduli of the coordinates in the region, shape (8,).
        sides
            For each constraint the index of its equation.

        Returns
        -------
        NDArray[np.float64]
            Upper bounds, shape (7,), rounded outward.
        """
        second = self._moduli.sum(axis=(1, 2))
        first = self._moduli.sum(axis=1) @ moduli
        value = (self._moduli @ moduli) @ moduli / 2
        bounds = [second[1]]
        for equations, side in zip(self.equations, sides, strict=True):
            a = equations[side].main
            if not equations[side].squares:
                bounds.append(second[a])
                continue
            bound = second[0] * value[a] + 2 * first[0] * first[a] + value[0] * second[a]
            for b in equations[side].squares:
                bound += 2 * (first[b] ** 2 + value[b] * second[b])
            bounds.append(bound)
        return np.array(bounds) * OUTWARD


def _scaled(form: Form, factor: arb) -> Form:
    return {index: coefficient * factor for index, coefficient in form.items()}


def _rotation_form(left: Sequence[arb], right: Sequence[arb]) -> Form:
    """Return N ``left . R right``."""
    return {study.ROTATION[i][j]: left[i] * right[j] for i in range(3) for j in range(3)}


def _square_distance(a: list[arb], b: list[arb], d: arb) -> Form:
    """Return N times ``|R a + T - b|^2 - d^2``, the paper's equation (6)."""
    form = _scaled(_rotation_form(b, a), arb(-2))
    form[study.NORM] = dot(a, a) + dot(b, b) - d * d
    form[study.RHO] = arb(1)
    for k in range(3):
        form[study.BODY[k]] = 2 * a[k]
        form[study.TRANSLATION[k]] = -2 * b[k]
    return form


def _base_height(a: list[arb], b: list[arb], u: list[arb]) -> Form:
    """Return N times ``u . (R a + T - b)`` with u fixed in the base."""
    form = _rotation_form(u, a)
    form[study.NORM] = -dot(u, b)
    for k in range(3):
        form[study.TRANSLATION[k]] = u[k]
    return form


def _platform_height(a: list[arb], b: list[arb], u: list[arb]) -> Form:
    """Return N times ``R u . (R a + T - b)`` with u fixed in the platform."""
    form = _scaled(_rotation_form(b, u), arb(-1))
    form[study.NORM] = dot(u, a)
    for k in range(3):
        form[study.BODY[k]] = u[k]
    return form
