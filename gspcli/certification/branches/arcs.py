"""Arcs of the curve of solutions (z, t) while values move, each proved in a box about its tangent.

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
from flint import arb, arb_mat
from numpy.typing import NDArray

from gspcli.certification.branches.fold_system import CurveSystem
from gspcli.certification.branches.taylor import MovingSystem
from gspcli.certification.numbers.balls import float_above, float_ends, floats_above
from gspcli.geometry.enclosures import above, roundings

Array = NDArray[np.float64]

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
