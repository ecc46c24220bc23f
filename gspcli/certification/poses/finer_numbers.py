"""The numbers of a platform with 64 digits, for poses that 32 digits do not round.

Some poses are proved with 32 digits, but the errors are too large for correct rounding: the
equations are nearly dependent there, as they are a hundred lengths away. The kernel then evaluates
the same equations with numbers that are sums of four doubles (native/finer_points.cpp). They are
computed in balls. With them, rows of batches with such poses take a tenth of the time that each
row alone takes (`tools.verify.realistic`, couplings).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np
from flint import arb, arb_mat, ctx
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Kind, Law
from gspcli.certification.equations import study
from gspcli.certification.equations.ball_system import monomials, places
from gspcli.certification.equations.quadratic_forms import Form, forms_of, scaled
from gspcli.certification.equations.statement import Statement, statements_in
from gspcli.certification.numbers.balls import dot, norm
from gspcli.certification.numbers.rounding import OUTWARD
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry

Array = NDArray[np.float64]

#: Doubles of a sum, and the bits of the balls that are written as such sums.
_PARTS, _BITS = 4, 320
#: Numbers that are not zero may not be smaller: their last parts would underflow.
_LEAST = 2.0**-600
_UNITS = Units("unit", AngleUnit.RADIAN)
#: Relative errors of sums of four doubles; the kernel allows for more.
_ERROR = 2.0**-180


class FinerNumbers:
    """A geometry with its values left open.

    Parameters
    ----------
    instance, scale
        The platform, and the unit of length of its equations (`ValueProofs`).
    meeting
        Which constraints are lines at distance zero.
    moduli
        Sums of the moduli of the terms of each coefficient, shape (quadrics, 27); of these the
        coefficients err by a part.

    Attributes
    ----------
    equations
        The coefficients of the quadrics without their values, in the order of the kernel, and the
        weights of the values, shapes (4, quadrics, 27) and (4, 6). None if a number cannot be
        written as a sum of four doubles.
    """

    def __init__(
        self, instance: Instance, scale: float, meeting: Sequence[bool], moduli: Array
    ) -> None:
        self.equations: tuple[Array, Array] | None = None
        self._instance, self._scale = instance, scale
        joined = tuple((row.kind, row.platform, row.base) for row in instance.constraints)
        coefficients, errors, weights = _equations(joined, scale, tuple(meeting))
        if weights is not None and (errors <= _ERROR * moduli).all():
            self.equations = coefficients, weights

    @cached_property
    def _statements(self) -> tuple[Statement, ...]:
        return statements_in(self._instance, self._scale)

    def values(self, choice: Array, row: Array | None) -> Array | None:
        """Return the values of the equations for the kernel (native/ends.hpp), shape (9, 6).

        Parameters
        ----------
        choice
            The sign of each constraint, shape (6,).
        row
            Values, doubles that are meant exactly, shape (6,); None for those of the instance.
        """
        found = np.zeros((2 * _PARTS + 1, len(choice)))
        with ctx.workprec(_BITS):
            given = self._statements
            if row is not None:
                given = tuple(
                    replace(x, value=arb(value) / x.unit)
                    for x, value in zip(given, row.tolist(), strict=True)
                )
            balls = [_value(x, sign) for x, sign in zip(given, choice.tolist(), strict=True)]
            distances = [abs(x.value) if x.kind.is_distance else arb(0) for x in given]
            values, lengths = _known_sums(balls), _known_sums(distances)
            if values is None or lengths is None:
                return None
            gaps = [
                float((ball - sum(map(arb, parts))).abs_upper()) * OUTWARD
                for ball, parts in zip(balls, values.T.tolist(), strict=True)
            ]
        found[:_PARTS], found[_PARTS], found[_PARTS + 1 :] = values, gaps, lengths
        return found


#: Of this many geometries the equations are kept: they take as long as all else of a solution.
@lru_cache(maxsize=64)
def _equations(
    joined: tuple[tuple[Kind, Geometry, Geometry], ...], scale: float, meeting: tuple[bool, ...]
) -> tuple[Array, Array, Array | None]:
    """Return the equations of a geometry, which most of its platforms share.

    They are the coefficients (4, quadrics, 27) and how much these err (quadrics, 27), and the
    weights of the values.
    """
    rows = tuple(Constraint(*each, Number.of(1)) for each in joined)
    with ctx.workprec(_BITS):
        statements = statements_in(Instance(rows, _UNITS), scale)
        mains = [
            _equation(given, meeting=each) for given, each in zip(statements, meeting, strict=True)
        ]
        forms: list[Form] = [{study.NORM: arb(1)}, {study.STUDY: arb(1)}]
        for main, _, squares in mains:
            forms += [main, *squares]
        matrix = arb_mat([[form.get(k, arb(0)) for k in range(study.COUNT)] for form in forms])
        coefficients, errors = _sums((matrix * arb_mat(monomials())).entries())
        weights = _known_sums([weight for _, weight, _ in mains])
    coefficients.setflags(write=False)
    if weights is not None:
        weights.setflags(write=False)
    shape = len(forms), -1
    return coefficients.reshape(_PARTS, *shape), errors.reshape(shape), weights


def coefficients_of(hessians: Array) -> Array:
    """Return the coefficients of quadrics, (n, 27), by their Hessian matrices, (n, 8, 8)."""
    rows, columns = np.array(places()).T
    return hessians[:, rows, columns] / np.where(rows == columns, 2, 1)


def _equation(given: Statement, *, meeting: bool) -> tuple[Form, arb, tuple[Form, ...]]:
    """Return the main quadric, the weight of the value in it, and the quadrics that are squared.

    They are those of native/open_equations.cpp.
    """
    law, u, v = given.kind.law, given.u, given.v
    form, *others = forms_of(given.kind, given.a, given.b, u, v, arb(0))
    if not given.kind.is_distance:
        return form, -norm(u) * norm(v), ()
    if law is Law.MOMENT:
        if meeting:
            return form, arb(0), ()
        return {}, dot(u, u) * dot(v, v), (form, *others)
    axis = u or v
    if law is Law.SQUARE:
        size = dot(axis, axis) if axis else arb(1)
        return scaled(form, size), -size, tuple(others)
    return form, -norm(axis), ()


def _value(given: Statement, sign: float) -> arb:
    """Return what the equation is linear in: a square, a height or a cosine."""
    if not given.kind.is_distance:
        return given.cosine
    if given.kind.has_sides:
        return given.value * int(sign)
    return given.value * given.value


def _sums(balls: Sequence[arb]) -> tuple[Array, Array]:
    """Return balls as sums of four doubles, (4, n), and by how much these err, (n,).

    A ball that contains zero becomes zero. What is zero in exact numbers is such a ball if its
    terms are no doubles.
    """
    found, errors = np.zeros((_PARTS, len(balls))), np.zeros(len(balls))
    for k, ball in enumerate(balls):
        if ball.contains(0):
            errors[k] = float(ball.abs_upper()) * OUTWARD
            continue
        rest = ball.mid()
        for part in range(_PARTS):
            high = float(rest)
            found[part, k] = high
            # Exact: it has fewer bits.
            rest -= high
        errors[k] = (float(ball.rad()) + abs(float(rest))) * OUTWARD
        if abs(found[0, k]) < _LEAST:
            errors[k] = np.inf
    return found, errors


def _known_sums(balls: Sequence[arb]) -> Array | None:
    """Return balls as sums of four doubles, (4, n); None if one errs by more than a part."""
    found, errors = _sums(balls)
    return found if (errors <= _ERROR * np.abs(found[0])).all() else None
