"""Poses far away because a body is nearly special, by continuation in what it lacks.

If lines or planes of one body are parallel up to eps, or points on a line, there are poses eps^-2
lengths away, with N of size eps^4, near each other. Paths with 64 digits from a start in general
position do not reach them. Multiply the small differences by s: the Study points are then power
series in s, also for s < 0. They are followed from differences of 3e-3 to s = 1, along polynomials
through the last points, with as many bits as N needs. Real poses that meet on the way are lost;
from s < 0 other poses meet. The ends are located and proved like the ends of all paths.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import exp, log, log2
from typing import Protocol

import numpy as np
from flint import acb, acb_mat, arb, ctx

from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.numbers.balls import largest
from gspcli.certification.poses.locator import AtInfinity, Complex, Located, Locator
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number

#: Bits in which differences are computed; bits of the equations for each bit of s eps; additional
#: bits.
DIFFERENCE_BITS, _TIMES, _MORE = 2048, 8, 256
#: The first step of log s; the factors of the next step after success and after failure.
_FIRST, _LONGER, _SHORTER = 1e-6, 4.0, 4.0
#: The most steps of a pose, and the number of points of a polynomial.
_STEPS, _POINTS = 100, 16
#: Newton's method near a simple solution: the largest ratio of two steps (of the first step to the
#: point), the part of the bits with which it has converged, and the most steps.
_SHRINKS, _ARRIVED, _NEWTON = 0.3, 0.5, 14
#: No coordinate is smaller, but zero (`Number.of`).
_LEAST = 1e-59
Numbers = list[acb]


class SpecialFamily(Protocol):
    """A platform, the one with s = 1, among those with its small differences multiplied by s."""

    @property
    def instance(self) -> Instance:
        """The platform."""

    @property
    def size(self) -> float:
        """The largest of the differences."""

    def at(self, s: arb) -> Instance:
        """Return the platform with the differences multiplied by s, to the working precision."""


class FamilyPaths:
    """Paths to the poses of a platform from one with larger differences.

    Parameters
    ----------
    family
        The platform among its family.
    locator, sides
        The equations of the platform, and the index of the equation of each constraint.
    apart
        The differences at the beginning, negative for s < 0.
    """

    def __init__(
        self, family: SpecialFamily, locator: Locator, sides: tuple[int, ...], apart: float
    ) -> None:
        self._family, self._locator, self._sides = family, locator, sides
        self._sign = 1 if apart > 0 else -1
        #: A place is log |s|; zero is s = 1, the platform itself.
        self._begin = log(abs(apart) / family.size)
        self._systems: dict[float, tuple[arb, BallSystem]] = {}

    @property
    def instance(self) -> Instance:
        """The platform at the beginning."""
        with ctx.workprec(self._bits(self._begin)):
            return self._family.at(self._system(self._begin)[0])

    def locate(self, begin: Locator, point: Complex, low: Complex) -> Located | AtInfinity | None:
        """Return the pose at the end of the path from a point of the beginning; None if lost.

        Parameters
        ----------
        begin
            The equations of `instance`.
        point, low
            An approximation of the Study point, as for `Locator.in_frames`.
        """
        with ctx.workprec(self._bits(0)):
            end = self._followed(begin.in_frames(point, low))
            if end is None:
                return None
            return self._locator.locate_exactly(end, self._sides, ctx.prec)

    def _bits(self, x: float) -> int:
        """Return the bits for a place."""
        return int(_MORE - _TIMES * log2(self._family.size * exp(x)))

    def _system(self, x: float) -> tuple[arb, BallSystem]:
        """Return s and the equations at a place, with as many bits as N needs there."""
        if x not in self._systems:
            with ctx.workprec(self._bits(x)):
                s = (arb(x).exp() * (self._sign if x else 1)).mid()
                self._systems[x] = s, BallSystem(self._family.at(s), ctx.prec)
        return self._systems[x]

    def _solution(
        self, x: float, point: Numbers, patch: int, *, near: bool = True
    ) -> Numbers | None:
        """Return the limit of Newton's method if it converges as near a simple solution."""
        system, last = self._system(x)[1], 1.0
        with ctx.workprec(system.precision):
            for _ in range(_NEWTON):
                values, jacobian = system.at(point, self._sides)
                entries = jacobian.entries()
                del entries[patch::8]
                try:
                    solved = acb_mat(7, 7, entries).solve(values, algorithm="approx")
                except ZeroDivisionError:
                    return None
                step = solved.mid().entries()
                step.insert(patch, acb(0))
                # Far away e is small compared with f.
                size = max(_part(step[:4], point[:4]), _part(step[4:], point[4:]))
                if not (size < _SHRINKS * last if near else size < np.inf):
                    return None
                point, last = [(a - b).mid() for a, b in zip(point, step, strict=True)], size
                if size <= 2.0 ** (-ctx.prec * _ARRIVED):
                    return point
        return None

    def _followed(self, start: Numbers) -> Numbers | None:
        """Return the end of the path from a Study point, exact numbers of any norm."""
        x = self._begin
        patch = max(range(8), key=lambda k: float(abs(start[k]).mid()))
        first = [(number / start[patch]).mid() for number in start]
        point = self._solution(x, first, patch, near=False)
        if point is None:
            return None
        points, places, step = [point], [self._system(x)[0]], _FIRST
        for _ in range(_STEPS):
            after = max(x - step, 0.0)
            s = self._system(after)[0]
            ahead = _extrapolated(places[-_POINTS:], points[-_POINTS:], s)
            found = self._solution(after, ahead, patch)
            if found is None:
                step /= _SHORTER
                continue
            if after == 0:
                return found
            points.append(found)
            places.append(s)
            x, step = after, step * _LONGER
        return None


def exact(x: arb) -> Number:
    """Return the middle of a ball; zero for what is too small for a coordinate."""
    if abs(x) < _LEAST:
        return Number.of(0)
    mantissa, exponent = x.mid().man_exp()
    return Number.of(int(mantissa) * Fraction(2) ** int(exponent))


def _extrapolated(places: Sequence[arb], points: Sequence[Numbers], s: arb) -> Numbers:
    """Return the value at s of the polynomial through points (Lagrange)."""
    weights = []
    for i, here in enumerate(places):
        weight = arb(1)
        for k, other in enumerate(places):
            if k != i:
                weight *= (s - other) / (here - other)
        weights.append(acb(weight))
    row = acb_mat(1, len(weights), weights) * acb_mat(points)
    return [x.mid() for x in row.entries()]


def _part(step: Sequence[acb], point: Sequence[acb]) -> float:
    """Return the size of a step as a part of that of a point."""
    return float((largest(step) / largest(point)).mid())
