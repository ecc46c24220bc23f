"""Equations of an instance whose values and drives move: Taylor polynomials with bounds.

Between two rows every number of a trajectory is a linear function of s, from 0 to 1: values,
angles of cranks and places of slides. The coefficients of the quadrics
are then analytic functions of s. On a part of the way, with tau from -1/2 to 1/2, each is a
polynomial in tau plus a remainder. Lagrange's form bounds the remainder: it is the next coefficient
of the power series, computed with a ball for s that contains the whole part.
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
from gspcli.certification.equations import study
from gspcli.certification.equations.local_frames import length_scale
from gspcli.certification.numbers.balls import ball, cross, dot, norm
from gspcli.certification.numbers.rounding import OUTWARD, TINY
from gspcli.geometry.coordinates import Body, Coordinate
from gspcli.geometry.instance import AngleUnit, Constraint, Instance
from gspcli.geometry.primitives import Crank, Line, Plane, Point, Slide
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Degree of the polynomials.
DEGREE = 6
_PRECISION = 128
#: A ball, or a power series with balls for coefficients.
Element = Any


@dataclass(frozen=True, eq=False)
class MovingQuadrics:
    """The equations on a part of the way between two rows.

    They are ``A = 0``, ``N A = B^2`` and ``A^2 = c (N^2 - B^2)``. In the first two forms A contains
    the term -c N, unlike in `parametric_quadrics`, and c is zero.

    Attributes
    ----------
    quadrics
        Hessian matrices of A and B: coefficients of powers of tau, shape (6, 2, d, 8, 8).
    errors
        Bounds of the spectral norms of the remainders, shape (6, 2).
    factors
        c as a polynomial, shape (6, d).
    factor_errors
        Bounds of the remainders of c, shape (6,).
    end
        The quadrics, shape (6, 2, 8, 8), and c, shape (6,), at tau = 1/2, with all terms.
    """

    quadrics: Array
    errors: Array
    factors: Array
    factor_errors: Array
    end: tuple[Array, Array]

    def restricted(self, begin: float, end: float, degree: int) -> MovingQuadrics:
        """Return the equations on a shorter part, with polynomials of lower degree.

        Parameters
        ----------
        begin, end
            The part, between -1/2 and 1/2.
        degree
            The degree; higher terms count as error.
        """
        count = self.quadrics.shape[2]
        powers = _shift((begin + end) / 2, end - begin, count)
        quadrics = np.einsum("jd,kqdxy->kqjxy", powers, self.quadrics)
        factors = self.factors @ powers.T
        halves = 0.5 ** np.arange(count)
        sizes = np.sqrt((quadrics**2).sum(axis=(3, 4)))
        # Rounding: sums of at most seven terms, each with a few products.
        most = (np.abs(powers).T * np.sqrt((self.quadrics**2).sum(axis=(3, 4)))[..., None]).sum(
            axis=(2, 3)
        )
        rest = sizes[..., degree + 1 :] @ halves[degree + 1 :]
        factor_rest = np.abs(factors[:, degree + 1 :]) @ halves[degree + 1 :]
        factor_most = (np.abs(powers).T * np.abs(self.factors)[..., None]).sum(axis=(1, 2))
        at_end = np.einsum("kqdxy,d->kqxy", quadrics, halves), factors @ halves
        return MovingQuadrics(
            quadrics[:, :, : degree + 1],
            (self.errors + rest + 2.0**-48 * most) * OUTWARD,
            factors[:, : degree + 1],
            (self.factor_errors + factor_rest + 2.0**-48 * factor_most) * OUTWARD,
            at_end,
        )


def _shift(middle: float, width: float, count: int) -> Array:
    """Return the matrix that turns coefficients in tau into those in (tau - middle) / width."""
    matrix = np.zeros((count, count))
    for d in range(count):
        term = 1.0
        for j in range(d, -1, -1):
            # term = binomial(d, j) middle^(d - j)
            matrix[j, d] = term * width**j
            term *= middle * j / (d - j + 1)
    return matrix


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
        position: list[Element] = [ball(number) for number in geometry.position]
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
        given = [ball(number) for number in geometry.vector]
        return position, [entry / norm(given) for entry in given]

    def _with_arm(
        self, body: Body, name: str, point: Any, axis: list[Element], moving: dict[Any, Element]
    ) -> list[Element]:
        """Return a vector of a joint after its arm has turned; unchanged unless a crank moves."""
        if not isinstance(point, Point) or point.crank is None:
            return axis
        owner = point.partner or name
        for one, angle in moving.items():
            if (one.body, one.primitive, one.vector) == (body, owner, "crank"):
                centre = [ball(x) for x in point.crank.centre]
                ends = [c + x for c, x in zip(centre, axis, strict=True)]
                turned = _turned(ends, point.crank, angle * self._unit)
                return [x - c for x, c in zip(turned, centre, strict=True)]
        return axis

    def on_part(self, rows: tuple[Array, Array], begin: float, end: float) -> MovingQuadrics:
        """Return the equations on a part of the way between two rows.

        Parameters
        ----------
        rows
            As for `equations`.
        begin, end
            From 0 to 1.
        """
        with flint.ctx.workprec(_PRECISION):
            width = arb(end) - arb(begin)
            middle = (arb(begin) + arb(end)) / 2
            polynomials = self.equations(rows, middle, width, DEGREE)
            whole = middle + arb(0, 0.5) * width
            remainders = self.equations(rows, whole, width, DEGREE + 1)
            return self._collected(polynomials, remainders)

    def _collected(self, polynomials: list[Any], remainders: list[Any]) -> MovingQuadrics:
        count = len(polynomials)
        nearest = np.zeros((count, 2, study.COUNT, DEGREE + 1))
        errors = np.zeros((count, 2, study.COUNT))
        factors, factor_errors = np.zeros((count, DEGREE + 1)), np.zeros(count)
        pairs = zip(polynomials, remainders, strict=True)
        for i, ((equation, c), (spread, spread_c)) in enumerate(pairs):
            forms, spreads = [dict(form) for form in equation[3]], [dict(f) for f in spread[3]]
            if equation[0] is Shape.LINES:
                factors[i], factor_errors[i] = _rounded(c, spread_c)
            else:
                forms[0][study.NORM] = forms[0].get(study.NORM, arb(0)) - c
                spreads[0][study.NORM] = spreads[0].get(study.NORM, arb(0)) - spread_c
            for j, (form, other) in enumerate(zip(forms, spreads, strict=True)):
                for k, coefficient in form.items():
                    nearest[i, j, k], errors[i, j, k] = _rounded(coefficient, other[k])
        terms = study.form_hessians().reshape(study.COUNT, -1)
        sizes = np.sqrt((terms**2).sum(axis=1))
        quadrics = np.moveaxis(nearest, 3, 2) @ terms
        moduli = np.sqrt(
            ((np.abs(np.moveaxis(nearest, 3, 2)) @ np.abs(terms)) ** 2).sum(axis=3)
        ).sum(axis=2)
        quadrics = quadrics.reshape(count, 2, DEGREE + 1, 8, 8)
        halves = 0.5 ** np.arange(DEGREE + 1)
        return MovingQuadrics(
            quadrics,
            (errors @ sizes + 2.0**-50 * moduli) * OUTWARD,
            factors,
            factor_errors * OUTWARD,
            (np.einsum("kqdxy,d->kqxy", quadrics, halves), factors @ halves),
        )


def _rounded(series: Element, spread: Element) -> tuple[Array, float]:
    """Return coefficients of a series in doubles, and a bound of the remainder."""
    nearest = np.zeros(DEGREE + 1)
    if not isinstance(series, arb_series):
        nearest[0] = value = float(series)
        return nearest, float((series - value).abs_upper()) * OUTWARD + TINY
    error = 0.0
    for d in range(DEGREE + 1):
        coefficient = series[d]
        nearest[d] = value = float(coefficient)
        error += 0.5**d * (float((coefficient - value).abs_upper()) * OUTWARD + TINY)
    if isinstance(spread, arb_series):
        error += 0.5 ** (DEGREE + 1) * float(spread[DEGREE + 1].abs_upper()) * OUTWARD
    return nearest, error


def _turned(point: list[Element], crank: Crank, angle: Element) -> list[Element]:
    """Return a point turned by a crank."""
    centre, axis = [ball(x) for x in crank.centre], [ball(x) for x in crank.axis]
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
    direction = [ball(x) for x in slide.direction]
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
