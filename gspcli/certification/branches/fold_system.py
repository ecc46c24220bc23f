"""The equations of moving poses along lines, and the equations of folds, in ball arithmetic.

With z a Study point and t the time, the curve of solutions is given by eight equations:

    F(z, t) = 0,  p.z = 1.

With u a direction, a fold is a zero of the seventeen equations

    F(z, t) = 0,  p.z = 1,  F'(z, t) u = 0,  p.u = 0,  c.u = 1.

The proofs are in `folds` and `arcs`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import arb, arb_mat, arb_series
from numpy.typing import NDArray

from gspcli.certification.branches.parametric_quadrics import Shape
from gspcli.certification.branches.taylor import Element, MovingSystem, coefficient
from gspcli.geometry import study
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: z, u and t.
UNKNOWNS = 17
#: A coefficient of a Taylor polynomial: the eight values, and their derivatives by z and t, (8, 9).
Coefficient = tuple[list[arb], arb_mat]


def unit(direction: Array) -> list[arb]:
    """Return a direction of length one."""
    return [arb(value) for value in (direction / np.linalg.norm(direction)).tolist()]


class CurveSystem:
    """The eight equations with balls for coefficients.

    Parameters
    ----------
    system
        What moves.
    rows
        The values, and the coordinates that move, at t = 0 and t = 1.
    point
        The point whose direction is p.
    """

    def __init__(self, system: MovingSystem, rows: tuple[Array, Array], point: Array) -> None:
        self.system = system
        self.rows = rows
        self.terms = study.form_hessians().reshape(study.COUNT, -1).astype(int).tolist()
        self.patch = unit(point)
        self._norm = self._hessian({study.NORM: arb(1)})
        self._study = self._hessian({study.STUDY: arb(1)})
        #: The constant Hessian matrices, by equation and quadric.
        self._still: dict[tuple[int, int], arb_mat] = {}

    def _hessian(self, form: dict[int, arb]) -> arb_mat:
        entries = [arb(0)] * 64
        for index, number in form.items():
            for k, factor in enumerate(self.terms[index]):
                if factor:
                    entries[k] += factor * number
        return arb_mat(8, 8, entries)

    def _hessians(self, k: int, j: int, form: dict[int, Element], count: int) -> list[arb_mat]:
        """Return the coefficients of powers of t of a Hessian matrix: one if it is constant."""
        if any(isinstance(x, arb_series) for x in form.values()):
            return [
                self._hessian({i: coefficient(x, power) for i, x in form.items()})
                for power in range(count)
            ]
        if (k, j) not in self._still:
            self._still[k, j] = self._hessian(form)
        return [self._still[k, j]]

    def along(self, x: Sequence[arb], v: Sequence[arb], order: int) -> list[Coefficient]:
        """Return the Taylor polynomial of the equations along a line.

        Parameters
        ----------
        x, v
            The line: (z, t) is ``x + s v``; nine balls each.
        order
            The order of the polynomial in s.

        Returns
        -------
        list
            The coefficients of the powers of s, each in a ball that contains it for all x and v.
            With a box for x the last coefficient is that of Lagrange's remainder.
        """
        line = _Line(x[:8], v[:8], v[8], order + 1)
        n = line.quadric([self._norm])
        found = [line.quadric([self._study])]
        moving = self.system.equations(self.rows, x[8], arb(1), order + 1)
        for k, ((shape, _, _, forms), c) in enumerate(moving):
            a, b = (
                line.quadric(self._hessians(k, j, forms[j], order + 2)) if j < len(forms) else None
                for j in (0, 1)
            )
            assert a is not None
            number = line.number([coefficient(c, power) for power in range(order + 2)])
            found.append(_equation(shape, n, a, b, number))
        patch = [_dot(self.patch, x[:8]) - 1, _dot(self.patch, v[:8])]
        nothing = [arb(0)] * 9
        result = []
        for power in range(order + 1):
            values = [one.value[0, power] for one in found]
            rows = [
                [*(one.gradient[i, power] for i in range(8)), one.by_time[0, power]]
                for one in found
            ]
            values.append(patch[power] if power < 2 else arb(0))
            rows.append(nothing if power else [*self.patch, arb(0)])
            result.append((values, arb_mat(rows)))
        return result


class FoldSystem(CurveSystem):
    """The seventeen equations; `gauge` is c."""

    gauge: Sequence[arb]

    def at(self, x: Sequence[arb]) -> tuple[list[arb], arb_mat]:
        """Return the values (17) and the Jacobian matrix (17, 17) at (z, u, t)."""
        (values, rows), (moved, bent) = self._in_direction(x)
        zeros = [arb(0)] * 8
        matrix = [[*row[:8], *zeros, row[8]] for row in rows.tolist()]
        pairs = zip(bent.tolist(), rows.tolist(), strict=True)
        matrix += [[*second[:8], *row[:8], second[8]] for second, row in pairs]
        matrix.append([*zeros, *self.gauge, arb(0)])
        return [*values, *moved, _dot(self.gauge, x[8:16]) - 1], arb_mat(matrix)

    def bends(self, x: Sequence[arb]) -> int:
        """Return the sign of the second derivative of t along the branches, 0 if not decided.

        With w the derivative of u along the curve, F' w + F''(u, u) + dF/dt t'' = 0 and p.w = 0: a
        linear system for w and t''.
        """
        (_, rows), (_, bent) = self._in_direction(x)
        right = (bent * arb_mat(9, 1, [*x[8:16], arb(0)])).entries()
        matrix = arb_mat([*rows.tolist(), [*self.gauge, arb(0)]])
        try:
            solved = matrix.solve(-arb_mat(9, 1, [*right, arb(0)]))
        except ZeroDivisionError:
            return 0
        second = solved.entries()[8]
        return 1 if second > 0 else -1 if second < 0 else 0

    def _in_direction(self, x: Sequence[arb]) -> list[Coefficient]:
        return self.along([*x[:8], x[16]], [*x[8:16], arb(0)], 1)


@dataclass(frozen=True)
class _Function:
    """Value (1, m), derivatives by z (8, m) and by t (1, m): coefficients of powers of s."""

    value: arb_mat
    gradient: arb_mat
    by_time: arb_mat


class _Line:
    """Polynomials in s along ``z = x + s v``, ``t = rate s``, with a number of coefficients."""

    def __init__(self, x: Sequence[arb], v: Sequence[arb], rate: arb, count: int) -> None:
        self.rate, self.count = rate, count
        self.x, self.v = arb_mat(1, 8, list(x)), arb_mat(1, 8, list(v))
        nothing = [arb(0)] * (count - 1)
        rows = [[a, b, *nothing][:count] for a, b in zip(x, v, strict=True)]
        self.points = arb_mat(rows)
        self.shift = toeplitz([arb(k == 1) for k in range(count)])

    def quadric(self, hessians: Sequence[arb_mat]) -> _Function:
        """Return a quadric; the coefficients of powers of t of its Hessian matrix are given."""
        still = len(hessians) == 1
        gradient = self._gradient(hessians)
        by_time = arb_mat(1, self.count)
        if not still:
            slopes = [k * one for k, one in enumerate(hessians)][1:]
            by_time = self._value(self._gradient(slopes))
        return _Function(self._value(gradient), gradient, by_time)

    def _gradient(self, hessians: Sequence[arb_mat]) -> arb_mat:
        moved, factor = self.points, arb(1)
        total = hessians[0] * moved
        for hessian in hessians[1 : self.count]:
            moved, factor = moved * self.shift, factor * self.rate
            total += (hessian * factor) * moved
        return total

    def _value(self, gradient: arb_mat) -> arb_mat:
        return (self.x * gradient + self.v * gradient * self.shift) / 2

    def number(self, powers: Sequence[arb]) -> tuple[arb_mat, arb_mat]:
        """Return a function of t and its derivative, (1, m) each; powers of t are given."""
        slopes = [k * one for k, one in enumerate(powers)][1:]
        value, slope = (
            [one * self.rate**k for k, one in enumerate(each[: self.count])]
            for each in (powers, slopes)
        )
        return arb_mat(1, self.count, value), arb_mat(1, self.count, slope)


def _equation(
    shape: Shape, n: _Function, a: _Function, b: _Function | None, c: tuple[arb_mat, arb_mat]
) -> _Function:
    """Return ``A - c N``, ``N (A - c N) - B^2`` or ``A^2 - c (N^2 - B^2)``."""
    number, slope = c
    factor, norm, first = (toeplitz(row.entries()) for row in (number, n.value, a.value))
    if b is None:
        return _Function(
            a.value - number * norm, a.gradient - n.gradient * factor, a.by_time - slope * norm
        )
    second = toeplitz(b.value.entries())
    if shape is Shape.LINES:
        gap = norm * norm - second * second
        return _Function(
            a.value * first - number * gap,
            2 * (a.gradient * first + (b.gradient * second - n.gradient * norm) * factor),
            2 * (a.by_time * first + b.by_time * second * factor) - slope * gap,
        )
    plain = first - factor * norm
    return _Function(
        n.value * plain - b.value * second,
        n.gradient * (plain - factor * norm) + a.gradient * norm - 2 * b.gradient * second,
        (a.by_time - slope * norm) * norm - 2 * b.by_time * second,
    )


def toeplitz(coefficients: Sequence[arb]) -> arb_mat:
    """Return the matrix that multiplies rows of coefficients by a polynomial."""
    count = len(coefficients)
    return arb_mat(
        [[coefficients[j - i] if j >= i else arb(0) for j in range(count)] for i in range(count)]
    )


def _dot(a: Sequence[arb], b: Sequence[arb]) -> arb:
    return sum((p * q for p, q in zip(a, b, strict=True)), arb(0))
