"""The curve of solutions (z, t) while values move along lines, its arcs and its folds, proved.

With z a Study point and t the time, the curve is given by eight equations:

    F(z, t) = 0,  p.z = 1.

With u a direction, a fold is a zero of the seventeen equations

    F(z, t) = 0,  p.z = 1,  F'(z, t) u = 0,  p.u = 0,  c.u = 1.

An arc has a centre, a direction v and a gauge g. For each s with ``|s| <= reach`` the equations

    F(z, t) = 0,  p.z = 1,  g.((z, t) - centre) = s,

(nine in number) are proved to have exactly one solution in a box about ``centre + s v``, by
Krawczyk's test for all s together. The matrix M of their derivatives is proved to be regular in the
box. So all solutions in the box are one smooth curve. The width of the box in each unknown is
chosen by the test. M is a polynomial in s, which is multiplied by the inverse before it is bounded:
near other singular poses M changes much along the curve, and the product changes little.

Arcs that overlap in a solution belong to the same curve. So a curve can be followed also where t
hardly changes along it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import flint
import numpy as np
from flint import arb, arb_mat, arb_series
from numpy.typing import NDArray

from gspcli.certification.branches.parametric_quadrics import Shape
from gspcli.certification.branches.taylor import Element, MovingSystem, coefficient
from gspcli.certification.numbers.balls import float_above, float_ends, floats_above
from gspcli.geometry import study
from gspcli.geometry.enclosures import above, roundings
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


#: Of ball arithmetic, in bits.
PRECISION = 160
#: z and t.
_UNKNOWNS = 9
#: The gauge of a fixed time.
_NOW = [*[arb(0)] * (_UNKNOWNS - 1), arb(1)]
#: The most widenings of a box.
_WIDENINGS = 8
#: A box that is to contain another one, or a point as accurate as its numbers, has this width; any
#: box has at least the second.
NARROW = 2.0**-80
_LEAST = NARROW / 1024
#: Newton's method: the most steps, and the size of the last one.
STEPS, CONVERGED = 12, 2.0**-70
#: Iterations of the power method for the weights.
_ITERATIONS = 12
#: The most arcs of a curve, the shortest one, and the part of an arc that is used.
_MOST, SHORTEST, _USED = 120, 2.0**-60, 0.9375


class Arc:
    """The solutions near a point of the curve, for ``|s| <= reach`` along a direction.

    Parameters
    ----------
    equations
        Of the curve.
    centre
        A point near a solution: nine exact numbers, like `direction` and `gauge`.
    direction, gauge
        v and g.
    """

    def __init__(
        self,
        equations: CurveSystem,
        centre: Sequence[arb],
        direction: Sequence[arb],
        gauge: Sequence[arb],
    ) -> None:
        self.equations = equations
        self.centre, self.direction, self.gauge = list(centre), list(direction), list(gauge)
        (values, rows), (_, bent) = equations.along(centre, direction, 1)
        self.inverse = arb_mat([*rows.tolist(), self.gauge]).mid().inv().mid()
        #: Coefficients of the powers of s of the equations at ``centre + s v``, times Y.
        self.residuals = [
            self._solved(values, arb(0)),
            self._solved(self._times(rows), self._slack),
            self._solved(self._times(bent), arb(0)) * (arb(1) / 2),
        ]

    @property
    def _slack(self) -> arb:
        """The difference of g.v from one."""
        return _dot(self.gauge, self.direction) - 1

    def _times(self, rows: arb_mat) -> list[arb]:
        """Return derivatives along v."""
        return (rows * arb_mat(_UNKNOWNS, 1, self.direction)).entries()

    def _solved(self, first: Sequence[arb], last: arb) -> arb_mat:
        """Return Y, the inverse at the centre, times nine numbers."""
        return self.inverse * arb_mat(_UNKNOWNS, 1, [*first, last])

    def holds(self, reach: arb, wanted: Sequence[arb]) -> bool:
        """Whether the curve is proved in a box.

        Parameters
        ----------
        reach
            The largest ``|s|``; exact.
        wanted
            The least width of the box.
        """
        self.reach = reach
        self.powers = [arb(1), arb(0, reach), arb(reach**2 / 2, reach**2 / 2)]
        known = _sum(a * b for a, b in zip(self.residuals, self.powers, strict=True))
        widths = [
            a * 1.0625 + b.abs_upper() * 1.5 + _LEAST
            for a, b in zip(wanted, known.entries(), strict=True)
        ]
        for _ in range(_WIDENINGS):
            self.widths = widths
            self._enclose()
            if not self.norm < 1:
                return False
            last = self._solved(self._times(self.matrices[2]), arb(0))
            moved = known + last * (arb(0, reach**3) / 3)
            needed = [
                shift.abs_upper() + _dot([a.abs_upper() for a in row], widths)
                for shift, row in zip(moved.entries(), self.defect.tolist(), strict=True)
            ]
            if all(a < b for a, b in zip(needed, widths, strict=True)):
                return True
            widths = [_larger(2 * a, b).mid() for a, b in zip(needed, widths, strict=True)]
        return False

    def _enclose(self) -> None:
        """Enclose M in the box: the coefficients of powers of s, and ``Y M - 1``."""
        near = [c + arb(0, w) for c, w in zip(self.centre, self.widths, strict=True)]
        s = self.powers[1]
        self.box = [a + s * v for a, v in zip(near, self.direction, strict=True)]
        self.matrices = [rows for _, rows in self.equations.along(near, self.direction, 1)]
        self.matrices.append(self.equations.along(self.box, self.direction, 2)[2][1])
        nothing = [arb(0)] * _UNKNOWNS
        product = _sum(
            self.inverse * arb_mat([*rows.tolist(), last]) * power
            for rows, power, last in zip(
                self.matrices, self.powers, (self.gauge, nothing, nothing), strict=True
            )
        )
        self.defect = product - 1
        self.norm, self.sizes = _contraction(self.defect)

    def contains(self, x: Sequence[arb]) -> bool:
        """Whether all points of a ball are in the box, so that its solutions are on the curve."""
        s, apart = self.place(x)
        near = all(a.abs_upper() < w for a, w in zip(apart, self.widths, strict=True))
        return near and bool(s.abs_upper() < self.reach)

    def place(self, x: Sequence[arb]) -> tuple[arb, list[arb]]:
        """Return s of a point, and its difference from ``centre + s v``."""
        offset = [a - b for a, b in zip(x, self.centre, strict=True)]
        s = _dot(self.gauge, offset)
        return s, [a - s * v for a, v in zip(offset, self.direction, strict=True)]

    def tangents(self) -> list[arb]:
        """Return balls for the tangents (z', t') of the curve, derivatives by s."""
        slacks = (self._slack, arb(0), arb(0))
        moved = _sum(
            self._solved(self._times(rows), slack) * power
            for rows, power, slack in zip(self.matrices, self.powers, slacks, strict=True)
        )
        return [v - d for v, d in zip(self.direction, self._solution(moved), strict=True)]

    def bends(self) -> int:
        """Return the sign of the second derivative of t along the curve, 0 if not decided.

        With x' the tangent and M' the derivative of M along it, ``M x'' + M' x' = 0``.
        """
        tangents = self.tangents()
        _, (_, change) = self.equations.along(self.box, tangents, 1)
        moved = self._solved((change * arb_mat(_UNKNOWNS, 1, tangents)).entries(), arb(0))
        second = -self._solution(moved)[-1]
        return 1 if second > 0 else -1 if second < 0 else 0

    def _solution(self, moved: arb_mat) -> list[arb]:
        """Return balls for all x with Y M x in balls, M anywhere in the box."""
        off = arb_mat(_UNKNOWNS, 1, [arb(0, width) for width in self._apart(moved)])
        return (moved - self.defect * off).entries()

    def _apart(self, moved: arb_mat) -> list[float]:
        """Bound the components of all x with Y M x in balls."""
        largest = (floats_above(moved.entries()) / self.sizes).max()
        widths: list[float] = above(largest / (1 - self.norm) * self.sizes).tolist()
        return widths

    def on_curve(self, part: float) -> list[arb] | None:
        """Return nine balls for the solution at about a part of the reach, or None."""
        s = part * self.reach
        guess = [c + s * v for c, v in zip(self.centre, self.direction, strict=True)]
        x = corrected(self.equations, guess, self.gauge)
        if x is None or not self.contains(x):
            return None
        ((values, _),) = self.equations.along(x, self.direction, 0)
        widths = self._apart(self._solved(values, arb(0)))
        return [arb(a, width) for a, width in zip(x, widths, strict=True)]


def corrected(
    equations: CurveSystem, guess: Sequence[arb], gauge: Sequence[arb]
) -> list[arb] | None:
    """Return a point very near the curve with the same g.x, by Newton's method, or None."""
    x = [value.mid() for value in guess]
    for _ in range(STEPS):
        ((values, rows),) = equations.along(x, gauge, 0)
        step = _step(rows, gauge, [*values, arb(0)])
        if step is None or not max(map(float_above, step)) < 1:
            return None
        x = [(a - b).mid() for a, b in zip(x, step, strict=True)]
        if max(map(float_above, step)) < CONVERGED:
            return x
    return None


def tangent(equations: CurveSystem, x: Sequence[arb], gauge: Sequence[arb]) -> list[arb] | None:
    """Return an approximate tangent of the curve at x, of length one and with g.v > 0."""
    ((_, rows),) = equations.along(x, gauge, 0)
    v = _step(rows, gauge, [*[arb(0)] * (_UNKNOWNS - 1), arb(1)])
    if v is None:
        return None
    length = _dot(v, v).sqrt()
    return [(a / length).mid() for a in v]


def at_time(equations: CurveSystem, guess: Sequence[arb]) -> list[arb] | None:
    """Return nine balls with exactly one solution, at the time of a guess; None without proof.

    The time is exact.
    """
    x = corrected(equations, guess, _NOW)
    v = None if x is None else tangent(equations, x, _NOW)
    if x is None or v is None:
        return None
    arc = Arc(equations, x, v, _NOW)
    if not arc.holds(arb(_LEAST), [arb(0)] * _UNKNOWNS):
        return None
    return [*(a + arb(0, w) for a, w in zip(x[:-1], arc.widths, strict=False)), x[-1]]


def near_point(
    equations: CurveSystem, point: Array, part: float, radius: float
) -> tuple[list[arb], bool]:
    """Return nine balls that contain a pose, and whether they have exactly one solution.

    Parameters
    ----------
    equations
        Of the curve.
    point
        A Study point, shape (8,).
    part
        The time.
    radius
        Within this distance from the point, of norm one, there is exactly one pose: the one in
        question. Zero if only its place is known: it is the pose that Newton's method finds.
    """
    y = [arb(value) for value in point.tolist()]
    scale = _dot(equations.patch, y)
    # From one patch to another distances grow at most fourfold.
    guess = [*(a / scale for a in y), arb(part)]
    exact = at_time(equations, guess)
    if exact and all((a - b).abs_upper() < radius / 16 for a, b in zip(exact, guess, strict=True)):
        return exact, True
    guess[:8] = [a + arb(0, 4 * radius) for a in guess[:8]]
    x = corrected(equations, guess, _NOW)
    v = None if x is None else tangent(equations, x, _NOW)
    if x is not None and v is not None:
        arc = Arc(equations, x, v, _NOW)
        wanted = [a.abs_upper() + NARROW for a in arc.place(guess)[1]]
        # The only solution in a box with the pose is the pose, also in a narrower box.
        if arc.holds(arb(_LEAST), wanted) and arc.contains(guess):
            exact = at_time(equations, x)
            if exact is not None and arc.contains(exact):
                return exact, True
    return guess, False


def towards(equations: CurveSystem, pose: Sequence[arb], latest: arb) -> Iterator[list[arb]]:
    """Yield points of the curve after a pose; t is proved to increase from the pose to each.

    Parameters
    ----------
    equations
        Of the curve.
    pose
        Nine balls with exactly one solution; the last one, the time, is exact.
    latest
        The iteration ends when t is greater.

    Yields
    ------
    list
        Nine balls that contain a point of the curve.
    """
    for _, end in _arcs(equations, pose, latest):
        yield end


def continued(
    equations: CurveSystem, pose: Sequence[arb], goal: float
) -> tuple[list[arb], int] | None:
    """Follow the curve from a pose while t increases, to a time or until arcs become too short.

    Returns
    -------
    tuple
        Nine balls with exactly one solution, the last one of the curve at an exact time, and the
        number of arcs; None if there is no such point after the pose.
    """
    last = None
    for count, (arc, end) in enumerate(_arcs(equations, pose, arb(goal)), 1):
        time = goal if end[-1] > goal else min(goal, float_ends(end[-1])[0])
        found = at_time(equations, [*end[:-1], arb(time)])
        if found is not None and arc.contains(found) and found[-1] > pose[-1]:
            last = found, count
    return last


def follow_closely(
    system: MovingSystem, rows: tuple[Array, Array], point: Array, part: float, radius: float
) -> tuple[Array, float, float, int] | None:
    """Follow a mode in arcs, as far as possible towards the next row.

    Parameters
    ----------
    system, rows
        As for `CurveSystem`.
    point, part
        A Study point of norm one, shape (8,), and the part of the step between the rows.
    radius
        A bound of its distance from the pose.

    Returns
    -------
    tuple
        The same three later on the curve, and the number of arcs; None if no arc is proved.
    """
    if not radius < 1:
        return None
    with flint.ctx.workprec(PRECISION):
        equations = CurveSystem(system, rows, point)
        pose, exact = near_point(equations, point, part, radius)
        found = continued(equations, pose, 1.0) if exact else None
        if found is None:
            return None
        x, count = found
        z = np.array([float(a) for a in x[:8]])
        size = float(np.linalg.norm(z))
        apart = sum(float_above((a - b).abs_upper()) for a, b in zip(x, z.tolist(), strict=False))
        return z / size, float(x[8]), above(apart / size + roundings(1, 1.0)), count


def _arcs(
    equations: CurveSystem, pose: Sequence[arb], latest: arb
) -> Iterator[tuple[Arc, list[arb]]]:
    """Yield arcs of the curve after a pose, and a point near the end of each; see `towards`."""
    known, length = list(pose), arb(1) / 16
    v = tangent(equations, [value.mid() for value in pose], _NOW)
    x = None if v is None else corrected(equations, pose, v)
    for _ in range(_MOST):
        if x is None or v is None or not known[-1] < latest:
            return
        arc = Arc(equations, x, v, v)
        wanted = [a.abs_upper() for a in arc.place(known)[1]]
        end, longer = None, arb(5) / 4
        while end is None:
            if arc.holds(length, wanted):
                if not arc.contains(known):
                    return
                if arc.tangents()[-1] > 0:
                    end = arc.on_curve(_USED)
            if end is None:
                length, longer = length / 2, arb(1)
            if length < SHORTEST:
                return
        yield arc, end
        known, x, length = end, [value.mid() for value in end], length * longer
        v = tangent(equations, x, v)


def _step(rows: arb_mat, gauge: Sequence[arb], right: list[arb]) -> list[arb] | None:
    matrix = arb_mat([*rows.tolist(), list(gauge)])
    try:
        found: list[arb] = matrix.mid().solve(arb_mat(_UNKNOWNS, 1, right).mid()).entries()
    except ZeroDivisionError:
        return None
    return found


def _sum(matrices: Iterator[arb_mat]) -> arb_mat:
    first = next(matrices)
    return sum(matrices, first)


def _dot(a: Sequence[arb], b: Sequence[arb]) -> arb:
    return sum((x * y for x, y in zip(a, b, strict=True)), arb(0))


def _larger(a: arb, b: arb) -> arb:
    return a if a > b else b


def _contraction(matrix: arb_mat) -> tuple[float, Array]:
    """Return a bound of a norm of a matrix: the maximum norm with weights.

    The bound holds for any weights; those of Perron's vector of the moduli are the best.
    """
    moduli = floats_above(matrix.entries()).reshape(_UNKNOWNS, _UNKNOWNS)
    weights = np.ones(_UNKNOWNS)
    with np.errstate(all="ignore"):
        for _ in range(_ITERATIONS):
            weights = moduli @ weights + 1e-3 * weights
            weights /= weights.max()
        return above(float((moduli @ weights / weights).max())), weights


# Proof of a fold: two branches of solutions meet while the values move, and both end.
#
# A fold is a zero of the seventeen equations (G. Moore and A. Spence, SIAM J. Numer. Anal. 17,
# 1980), and a simple zero of these is a quadratic turning point: t has an extremum along the curve
# of solutions, which passes through it in the direction u. Krawczyk's test in balls proves exactly
# one zero in a box.
#
# The proof that a mode reaches the fold uses the curve (`Fold.sides`). An arc through the fold is
# proved in a larger box, together with a constant sign of the second derivative of t. So t has no
# other extremum on the arc: it increases up to the fold or decreases after it. The pose is in this
# box, or the curve is followed from the pose in further arcs, on which t increases, up to it.


@dataclass(frozen=True, eq=False)
class Fold:
    """A proved fold."""

    #: Floats; the part of the step before the fold lies between them.
    low: float
    high: float
    #: The Study point there, and the direction u of the two branches, shape (8,); rounded.
    point: Array
    direction: Array
    #: The sign of the second derivative of t along the branches: -1 if both end at the fold, 1 if
    #: both begin there.
    bends: int
    #: The equations, and their zero within `NARROW`.
    equations: FoldSystem
    zero: tuple[arb, ...]

    def sides(self, points: Array, part: float, radius: float) -> list[int]:
        """Prove that poses are on the curve through the fold, with no other fold between.

        Parameters
        ----------
        points
            Study points, shape (n, 8).
        part
            The part of the step before the poses.
        radius
            Within this distance from each point, of norm one, there is exactly one pose: the one in
            question.

        Returns
        -------
        list
            For each pose -1 or 1 for its branch, if it is proved that the mode of the pose reaches
            the fold without a singularity before; else 0.
        """
        with flint.ctx.workprec(PRECISION):
            return [_side(self, point, part, radius) for point in points]


def prove_fold(
    system: MovingSystem, rows: tuple[Array, Array], part: float, point: Array, direction: Array
) -> Fold | None:
    """Prove a fold near a point of a branch; None if there is no proof.

    Parameters
    ----------
    system
        What moves.
    rows
        The values, and the coordinates that move, at both ends of a step between rows, in the units
        of the instance; they are taken as exact.
    part
        The approximate place between them, from 0 to 1.
    point, direction
        A Study point near the fold, in units of `length_scale`, and the approximate direction of
        the branch there, shape (8,).
    """
    with flint.ctx.workprec(PRECISION):
        equations = FoldSystem(system, rows, point)
        x = [*map(arb, point.tolist()), *map(arb, direction.tolist()), arb(part)]
        scale = sum((a * b for a, b in zip(equations.patch, x[:8], strict=True)), arb(0))
        x[:8] = [(value / scale).mid() for value in x[:8]]
        equations.gauge = unit(direction)
        x[8:16] = list(equations.gauge)
        for _ in range(STEPS):
            values, jacobian = equations.at(x)
            try:
                step = jacobian.mid().solve(arb_mat(UNKNOWNS, 1, values).mid()).entries()
            except ZeroDivisionError:
                return None
            x = [(a - b).mid() for a, b in zip(x, step, strict=True)]
            size = max(float_above(s) for s in step)
            if not size < 10:
                return None
            if size < CONVERGED:
                return _krawczyk(equations, x)
    return None


def _krawczyk(system: FoldSystem, x: list[arb]) -> Fold | None:
    values, jacobian = system.at(x)
    try:
        inverse = jacobian.mid().inv().mid()
    except ZeroDivisionError:
        return None
    step = (inverse * arb_mat(UNKNOWNS, 1, values)).entries()
    radius = arb(NARROW)
    box = [arb(value, radius) for value in x]
    _, spread = system.at(box)
    defect = inverse * spread - 1
    for row, delta in zip(defect.tolist(), step, strict=True):
        moved = sum((entry.abs_upper() for entry in row), arb(0)) * radius + delta.abs_upper()
        if not moved < radius:
            return None
    low, high = float_ends(box[16])
    bends = system.bends(box)
    if bends == 0:
        return None
    middle = np.array([float(value) for value in x])
    return Fold(low, high, middle[:8], middle[8:16], bends, system, tuple(box))


def _side(fold: Fold, point: Array, part: float, radius: float) -> int:
    """Return the branch of a fold with a pose, or 0; see `Fold.sides`."""
    equations = fold.equations
    y = [arb(value) for value in point.tolist()]
    if not (radius < 1 and _dot(equations.patch, y).abs_lower() > 0.5):
        return 0
    pose, _ = near_point(equations, point, part, radius)
    turn = _Turn(fold, pose)
    side = turn.side(pose)
    if side == 0 and turn.proved_nearer():
        found = (turn.side(place) for place in towards(equations, pose, arb(fold.high)))
        side = next(filter(None, found), 0)
    return side


class _Turn:
    """A part of the curve through a fold, with no other fold on it.

    Parameters
    ----------
    fold
        The fold at its centre.
    pose
        Nine balls that it should reach, if this can be proved.
    """

    def __init__(self, fold: Fold, pose: list[arb]) -> None:
        zero, nothing = [value.mid() for value in fold.zero], arb(0)
        direction, gauge = [*zero[8:16], nothing], [*fold.equations.gauge, nothing]
        self.arc = Arc(fold.equations, [*zero[:8], zero[16]], direction, gauge)
        self.fold = [*fold.zero[:8], fold.zero[16]]
        s, apart = self.arc.place(pose)
        self.reach = (s.abs_upper() * 1.0625).mid()
        self.proved = self._proved([a.abs_upper() for a in apart])

    def _proved(self, wanted: list[arb]) -> bool:
        """Whether a box contains the fold on a curve along which t has no other extremum.

        The box is at least as wide as the ball of the fold: where a coordinate does not change
        along the curve, Krawczyk's test alone leaves a box that is narrower than this ball. Each
        width for which the test holds is a proof.
        """
        arc = self.arc
        ball = [a.abs_upper() for a in arc.place(self.fold)[1]]
        wide = [a if a > b else b for a, b in zip(wanted, ball, strict=True)]
        return arc.holds(self.reach, wide) and arc.contains(self.fold) and arc.bends() != 0

    def proved_nearer(self) -> bool:
        """Whether an arc is proved, a shorter one if necessary."""
        while not self.proved and self.reach > SHORTEST:
            self.reach = self.reach / 8
            self.proved = self._proved([arb(0)] * 9)
        return self.proved

    def side(self, place: list[arb]) -> int:
        """Return the side of the fold on which all solutions in balls are on the curve, or 0."""
        if not self.proved or not self.arc.contains(place):
            return 0
        s = self.arc.place(place)[0] - self.arc.place(self.fold)[0]
        return 1 if s > 0 else -1 if s < 0 else 0
