"""Equations of an instance whose values and drives move, as power series.

Between two rows every number of a trajectory is a linear function of s, from 0 to 1: values,
angles of cranks and places of slides. The coefficients of the quadrics
are then analytic functions of s.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import flint
import numpy as np
from flint import arb, arb_series
from numpy.typing import NDArray

from gspcli.certification.branches.parametric_quadrics import (
    Equation,
    Shape,
    ValueFunction,
    moving_equation,
)
from gspcli.certification.equations.local_frames import length_scale
from gspcli.certification.numbers.balls import cross, dot, norm
from gspcli.geometry import study
from gspcli.geometry.coordinates import Body, Coordinate
from gspcli.geometry.instance import AngleUnit, Array, Constraint, Instance
from gspcli.geometry.primitives import Crank, Line, Plane, Point, Slide

_PRECISION = 128
#: A ball, or a power series with balls for coefficients.
Element = Any


class MovingSystem:
    """An instance whose values and drives move linearly between rows.

    Parameters
    ----------
    instance
        The units and all numbers that do not move.
    chosen
        The drives that move.
    """

    def __init__(self, instance: Instance, chosen: Sequence[Coordinate]) -> None:
        self.instance = instance
        self.chosen = tuple(chosen)
        self.scale = length_scale(instance)
        values = [constraint.value.value for constraint in instance.constraints]
        row = np.concatenate((values, np.zeros(len(self.chosen))))
        still = self.equations((row, row), arb(0), arb(0), 0)
        #: The shapes of the equations, shape (6,).
        self.shapes = np.array([equation[0] for equation, _ in still], np.int32)

    def equations(
        self, rows: tuple[Array, Array], at: arb, width: arb, order: int
    ) -> list[tuple[Equation, Element]]:
        """Return each equation, as `moving_equation`, and its c, as power series.

        Parameters
        ----------
        rows
            Six values and the coordinates at s = 0 and s = 1, in the units of the instance; taken
            as exact.
        at, width
            The variable of the series is (s - at) / width.
        order
            The order of the series.
        """
        with _capped(order + 1):
            first, last = ([arb(x) for x in row.tolist()] for row in rows)
            series = [
                arb_series([a + at * (b - a), width * (b - a)], prec=order + 1) if a != b else a
                for a, b in zip(first, last, strict=True)
            ]
            return self._all(series[:6], dict(zip(self.chosen, series[6:], strict=True)))

    def _all(
        self, values: Sequence[Element], moving: dict[Coordinate, Element]
    ) -> list[tuple[Equation, Element]]:
        rows = zip(self.instance.constraints, values, strict=True)
        return [self._equation(row, value, moving) for row, value in rows]

    def _equation(
        self, row: Constraint, value: Element, moving: dict[Coordinate, Element]
    ) -> tuple[Equation, Element]:
        a, u = self._placed("platform", row.platform_name, row.platform, moving)
        b, v = self._placed("base", row.base_name, row.base, moving)
        equation = moving_equation(row.kind, a, b, u, v, is_zero=row.value.fraction == 0)
        _, law, sign, _ = equation
        if law in (ValueFunction.SQUARE, ValueFunction.LINEAR):
            length = value / arb(self.scale)
            return equation, length * length if law is ValueFunction.SQUARE else length
        angle = value * self._unit
        return equation, (angle.cos() if law is ValueFunction.COSINE else angle.sin()) * arb(sign)

    @property
    def _unit(self) -> arb:
        degrees = self.instance.units.angle is AngleUnit.DEGREE
        return arb.pi() / 180 if degrees else arb(1)

    def _placed(
        self, body: Body, name: str, geometry: Point | Line | Plane, moving: dict[Any, Element]
    ) -> tuple[list[Element], list[Element]]:
        """Return a point of a primitive in units of the scale, and its unit direction."""
        position: list[Element] = [number.ball() for number in geometry.position]
        if isinstance(geometry, Point):
            owner = geometry.partner or name
            for one, number in moving.items():
                if (one.body, one.primitive) == (body, owner) and geometry.crank is not None:
                    position = _turned(position, geometry.crank, number * self._unit)
                elif (one.body, one.primitive) == (body, owner) and geometry.slide is not None:
                    position = _shifted(position, geometry.slide, number)
        position = [entry / arb(self.scale) for entry in position]
        if isinstance(geometry, Point):
            return position, []
        given = [number.ball() for number in geometry.vector]
        return position, [entry / norm(given) for entry in given]

    def at(self, rows: tuple[Array, Array], part: float) -> tuple[Array, Array]:
        """Return the equations at a part of the way between two rows, rounded to doubles.

        Returns
        -------
        tuple
            Hessian matrices of A and B, (1, 6, 2, 8, 8), and c, (1, 6). A contains the term -c N,
            and c is zero then, but for ``A^2 = c (N^2 - B^2)``.
        """
        numbers = np.zeros((len(self.shapes), 2, study.COUNT))
        factors = np.zeros((1, len(self.shapes)))
        with flint.ctx.workprec(_PRECISION):
            found = self.equations(rows, arb(part), arb(0), 0)
            for i, ((shape, _, _, forms), c) in enumerate(found):
                for j, form in enumerate(forms):
                    for k, number in form.items():
                        numbers[i, j, k] = float(coefficient(number, 0))
                if shape is Shape.LINES:
                    factors[0, i] = float(coefficient(c, 0))
                else:
                    numbers[i, 0, study.NORM] -= float(coefficient(c, 0))
        return np.einsum("kqf,fij->kqij", numbers, study.form_hessians())[None], factors


def equations_at(
    shapes: NDArray[np.int32], quadrics: Array, factors: Array, points: Any
) -> tuple[Any, Any]:
    """Return the Study condition and the six equations, (n, 7), and derivatives, (n, 7, 8).

    Parameters
    ----------
    shapes
        Of the equations, shape (6,).
    quadrics
        Hessian matrices of A and B, shape (n, 6, 2, 8, 8).
    factors
        c, shape (n, 6).
    points
        Study points, real or complex, shape (n, 8).
    """
    gradients = np.einsum("nkqxy,ny->nkqx", quadrics, points)
    (a, b) = np.moveaxis(np.einsum("nkqx,nx->nkq", gradients, points) / 2, 2, 0)
    ga, gb = gradients[:, :, 0], gradients[:, :, 1]
    e = np.concatenate((points[:, :4], np.zeros_like(points[:, :4])), axis=1)
    n, gn = np.sum(e * e, axis=1)[:, None], 2 * e[:, None]
    values = np.select(
        [shapes == Shape.PLAIN, shapes == Shape.PRODUCT],
        [a, n * a - b**2],
        a**2 - factors * (n**2 - b**2),
    )
    a, b, n, c = a[..., None], b[..., None], n[..., None], factors[..., None]
    form = shapes[:, None]
    rows = np.select(
        [form == Shape.PLAIN, form == Shape.PRODUCT],
        [ga, n * ga + a * gn - 2 * b * gb],
        2 * a * ga - 2 * c * (n * gn - b * gb),
    )
    study = np.roll(points, 4, axis=1)
    condition = np.sum(points[:, :4] * points[:, 4:], axis=1)
    return (
        np.concatenate((condition[:, None], values), axis=1),
        np.concatenate((study[:, None], rows), axis=1),
    )


def coefficient(x: Element, power: int) -> arb:
    """Return a coefficient of a power series, or of a number."""
    if isinstance(x, arb_series):
        return x[power]
    return x if power == 0 else arb(0)


def _turned(point: list[Element], crank: Crank, angle: Element) -> list[Element]:
    """Return a point turned by a crank."""
    centre, axis = [x.ball() for x in crank.centre], [x.ball() for x in crank.axis]
    size = norm(axis)
    axis = [x / size for x in axis]
    arm = [x - c for x, c in zip(point, centre, strict=True)]
    height = dot(axis, arm)
    along = [height * x for x in axis]
    across = cross(axis, arm)
    cosine, sine = angle.cos(), angle.sin()
    return [
        centre[k] + along[k] + (arm[k] - along[k]) * cosine + across[k] * sine for k in range(3)
    ]


def _shifted(point: list[Element], slide: Slide, length: Element) -> list[Element]:
    """Return a point moved along a rail."""
    direction = [x.ball() for x in slide.direction]
    size = norm(direction)
    return [x + length * (u / size) for x, u in zip(point, direction, strict=True)]


@contextmanager
def _capped(count: int) -> Iterator[None]:
    """Truncate power series after a number of coefficients."""
    before = flint.ctx.cap
    flint.ctx.cap = count
    try:
        yield
    finally:
        flint.ctx.cap = before
