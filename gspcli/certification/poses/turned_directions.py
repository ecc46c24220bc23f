"""Poses far away because directions of a body are nearly parallel: from where these differ more.

Lines or planes of one body that are parallel up to eps leave poses eps^-2 lengths away with N at
eps^4 and the two solutions of a line's square side by side, where paths with 64 digits from a start
in general position do not lead. But with the differences of the directions multiplied by s the
Study points are power series in s, for s < 0, too. From directions that differ by 3e-3 they are
followed to s = 1 along polynomials through the last of them, with as many bits as N needs. Real
poses that meet on the way are lost: from s < 0 others do. What is reached is located and proved as
the ends of all paths are.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property
from math import exp, log, log2
from typing import NamedTuple

import numpy as np
from flint import acb, acb_mat, arb, ctx

from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.statement import statements
from gspcli.certification.numbers.balls import dot, largest, norm
from gspcli.certification.poses.locator import AtInfinity, Complex, Located, Locator
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane, Point, Vector
from gspcli.records import dataclass

#: Directions that differ by less than the second are nearly parallel: of others, paths with 64
#: digits find the poses in less time. With less than the first, bounds are no floats.
_LEAST, _PARALLEL = 1e-62, 1e-13
#: Bits in which differences are known, and those of equations: as many for each bit of s eps, and
#: some more.
_BITS, _TIMES, _MORE = 2048, 8, 256
#: The first step of log s, and by what the next one is longer after success, or shorter.
_FIRST, _LONGER, _SHORTER = 1e-6, 4.0, 4.0
#: Steps of a pose, and through how many points a polynomial goes.
_STEPS, _POINTS = 100, 16
#: Newton's method shrinks its steps by this factor at least near a simple solution, the first one
#: as a part of the point; it has arrived with this part of the bits; steps.
_SHRINKS, _ARRIVED, _NEWTON = 0.3, 0.5, 14
Numbers = list[acb]


class _Turn(NamedTuple):
    """A direction of a row and its difference from one that is nearly parallel, both long alike."""

    near: list[arb]
    difference: list[arb]
    angle: float


@dataclass(frozen=True)
class TurnedDirections:
    """A platform some of whose directions are nearly parallel, as one of a family.

    Attributes
    ----------
    instance
        The platform itself, at s = 1.
    turns
        For each constraint what is turned in the platform and in the base.
    """

    instance: Instance
    turns: tuple[tuple[_Turn | None, _Turn | None], ...]

    @classmethod
    def of(cls, instance: Instance) -> TurnedDirections | None:
        """Return the family of a platform; None if no directions of it are nearly parallel."""
        with ctx.workprec(_BITS):
            given = statements(instance)
            sides = (_turns([row.u for row in given]), _turns([row.v for row in given]))
        if not any(turn for turns in sides for turn in turns):
            return None
        return cls(instance, tuple(zip(*sides, strict=True)))

    @cached_property
    def angle(self) -> float:
        """By how much nearly parallel directions differ, at most."""
        return max(turn.angle for pair in self.turns for turn in pair if turn)

    def at(self, s: arb) -> Instance:
        """Return the platform with the differences multiplied by s, to the working precision."""
        rows = (
            _turned(row, *(turn and _vector(turn, s) for turn in pair))
            for row, pair in zip(self.instance.constraints, self.turns, strict=True)
        )
        return Instance(tuple(rows), self.instance.units)


class TurnedEquations:
    """The equations of a platform with turned directions.

    Parameters
    ----------
    turned
        The platform.
    locator, sides
        Its own equations, and the index of that of each constraint.
    apart
        By how much its directions differ at the beginning, negative for s < 0.
    """

    def __init__(
        self, turned: TurnedDirections, locator: Locator, sides: tuple[int, ...], apart: float
    ) -> None:
        self._turned, self._locator, self._sides = turned, locator, sides
        self._sign = 1 if apart > 0 else -1
        #: Places are log |s|, and zero is s = 1, the platform itself.
        self._begin = log(abs(apart) / turned.angle)
        self._systems: dict[float, tuple[arb, BallSystem]] = {}

    @property
    def instance(self) -> Instance:
        """The platform at the beginning."""
        with ctx.workprec(self._bits(self._begin)):
            return self._turned.at(self._system(self._begin)[0])

    def locate(self, begin: Locator, point: Complex, low: Complex) -> Located | AtInfinity | None:
        """Return the pose where one of the beginning goes; None if it is lost.

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
        return int(_MORE - _TIMES * log2(self._turned.angle * exp(x)))

    def _system(self, x: float) -> tuple[arb, BallSystem]:
        """Return s and the equations at a place, with as many bits as N needs there."""
        if x not in self._systems:
            with ctx.workprec(self._bits(x)):
                s = (arb(x).exp() * (self._sign if x else 1)).mid()
                self._systems[x] = s, BallSystem(self._turned.at(s), ctx.prec)
        return self._systems[x]

    def _solution(
        self, x: float, point: Numbers, patch: int, *, near: bool = True
    ) -> Numbers | None:
        """Return what Newton's method leads to, as fast as near a simple solution, or at all."""
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
                # Far away e is small beside f.
                size = max(_part(step[:4], point[:4]), _part(step[4:], point[4:]))
                if not (size < _SHRINKS * last if near else size < np.inf):
                    return None
                point, last = [(a - b).mid() for a, b in zip(point, step, strict=True)], size
                if size <= 2.0 ** (-ctx.prec * _ARRIVED):
                    return point
        return None

    def _followed(self, start: Numbers) -> Numbers | None:
        """Return where a Study point, exact numbers of any norm, goes from the beginning."""
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


def _turns(directions: Sequence[Sequence[arb]]) -> list[_Turn | None]:
    """Return for each direction its turn from the first that it is nearly parallel to."""
    found: list[_Turn | None] = []
    for k, direction in enumerate(directions):
        turns = (_turn(other, direction) for other in directions[:k] if other and direction)
        found.append(next((turn for turn in turns if turn), None))
    return found


def _turn(other: Sequence[arb], direction: Sequence[arb]) -> _Turn | None:
    length = norm(direction)
    factor = length / norm(other)
    if dot(other, direction) < 0:
        factor = -factor
    near = [factor * x for x in other]
    difference = [x - y for x, y in zip(direction, near, strict=True)]
    if all(x.contains(0) for x in difference):
        return None
    angle = float((norm(difference) / length).mid())
    return _Turn(near, difference, angle) if _LEAST < angle < _PARALLEL else None


def _vector(turn: _Turn, s: arb) -> Vector:
    x, y, z = (_exact(a + s * b) for a, b in zip(turn.near, turn.difference, strict=True))
    return x, y, z


def _exact(x: arb) -> Number:
    mantissa, exponent = x.mid().man_exp()
    return Number.of(int(mantissa) * Fraction(2) ** int(exponent))


def _turned(row: Constraint, u: Vector | None, v: Vector | None) -> Constraint:
    """Return a constraint with other directions in the platform and in the base, or the same."""
    platform = row.platform if u is None else _along(row.platform, u)
    base = row.base if v is None else _along(row.base, v)
    return Constraint(row.kind, platform, base, row.value, row.side)


def _along(geometry: Point | Line | Plane, vector: Vector) -> Line | Plane:
    assert not isinstance(geometry, Point)
    return type(geometry)(geometry.position, vector)


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
