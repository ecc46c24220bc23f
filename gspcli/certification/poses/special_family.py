"""Poses far away because a body is nearly special, by continuation in what it lacks.

Directions of a body are nearly parallel, lines nearly the same, or points nearly on a line: of
points on a line the distances from another line are square roots of a polynomial of degree two in
the place on the line, so that three of them determine all others. If that holds up to eps, there
are poses eps^-2 lengths away, with N of size eps^4, near each other. Paths from a start in general
position do not reach them. Multiply the small differences by s: the Study points are then power
series in s. They are followed from differences of 1e-2 to s = 1, along polynomials through the last
points, with as many bits as N needs. On the way s is complex, so that no poses meet: each pose of
the beginning leads to another one. The ends are located and proved like the ends of all paths.

Newton's method converges to a relative error of about one in N, in f and in what of e cancels. So
the polynomials are those of e, of N T and of N / s^m, N being of size s^m, with one coordinate of e
equal to 1: e.e and f follow from them. Where points of the base are nearly on a line, or directions
of the platform nearly parallel, N U takes the place of N T, U = R^T T. Polynomials of e and f alone
have to be right to s^4, so to twice as many digits, which takes three times as many points.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import combinations
from math import exp, inf, isfinite, log, log2, pi, tanh
from typing import Any

import numpy as np
from flint import acb, acb_mat, arb, ctx

from gspcli.catalogue.kinds import DLP, DPL
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.local_frames import length_scale
from gspcli.certification.equations.statement import Statement, statements
from gspcli.certification.numbers.balls import Ball, dot, largest, norm
from gspcli.certification.poses.locator import AtInfinity, Complex, Located, Locator, dot4
from gspcli.geometry import study
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Point, Vector
from gspcli.geometry.tolerances import OFF_LINES, TURNED_APART_RADIANS
from gspcli.records import dataclass

#: Of three points on a line the distances from another line are independent.
_FEWEST = 4
#: Bits in which differences are computed.
DIFFERENCE_BITS = 2048
#: Bits of the equations for each bit of s eps (N is of size eps^4, and with three directions the
#: Jacobian matrix loses twice as many), and additional bits: of directions, and of points.
_OF_DIRECTIONS, _OF_POINTS = (12, 256), (8, 256)
#: The first step of log s; the least factor of the next step after success, and the first one as a
#: power of ten; the divisor after failure.
_FIRST, _LONGER, _FIRST_POWER, _SHORTER = 1e-6, 4.0, 2.5, 4.0
#: The most steps of a pose, and the number of points of a polynomial.
_STEPS, _POINTS = 150, 12
#: Newton's method near a simple solution: the largest ratio of two steps (of the first step to the
#: point), the part of the bits with which it has converged, and the most steps.
_SHRINKS, _ARRIVED, _NEWTON = 0.3, 0.2, 14
#: Bits to which an end is known when it is proved, about.
_END_BITS = 240
#: The equations of this many places are kept, those of the first paths: most paths have the same.
_KEPT = 256
#: Another coordinate of e becomes 1 if it is this many times as large as the one that is.
_LARGE = 4.0
#: No coordinate is smaller, but zero (`Number.of`).
_LEAST = 1e-59
Numbers = list[acb]


@dataclass(frozen=True)
class SpecialFamily:
    """A platform, the one with s = 1, among those with its small differences multiplied by s."""

    #: The platform.
    instance: Instance
    #: For each constraint the differences: by the name of a point or a direction of its `Statement`
    #: a vector in the same units.
    differences: tuple[Mapping[str, Sequence[arb]], ...]
    #: The largest of them, as an angle or as a part of the distance of two points.
    size: float
    #: Bits of equations for each bit of the differences, and additional ones.
    bits: tuple[int, int]

    @property
    def in_base(self) -> bool:
        """Whether N T stays small, not N U: of lines of the base, and of points on the platform."""
        names = set().union(*self.differences)
        return "v" in names or names == {"a"}

    def at(self, s: Ball) -> tuple[Statement, ...]:
        """Return the constraints with the differences multiplied by s."""
        rows = zip(statements(self.instance), self.differences, strict=True)
        return tuple(replace(row, **_changed(row, small, s)) for row, small in rows)

    def instance_at(self, s: arb) -> Instance:
        """Return the platform with the differences multiplied by s, to the working precision."""
        scale = length_scale(self.instance)
        rows = (
            _moved(row, given, small, scale)
            for row, given, small in zip(
                self.instance.constraints, self.at(s), self.differences, strict=True
            )
        )
        return Instance(tuple(rows), self.instance.units)


def _changed(row: Statement, differences: Mapping[str, Sequence[arb]], s: Ball) -> dict[str, Any]:
    """Return the points and directions of a constraint that differ, at s."""
    return {
        name: [x + (s - 1) * d for x, d in zip(getattr(row, name), small, strict=True)]
        for name, small in differences.items()
    }


def _moved(row: Constraint, given: Statement, names: Container[str], scale: float) -> Constraint:
    """Return a constraint with some numbers of a statement, by their names."""

    def part(geometry: Geometry, point: str, direction: str) -> Geometry:
        position, vector = geometry.position, getattr(geometry, "vector", ())
        if point in names:
            position = _vector([x * scale for x in getattr(given, point)])
        if direction in names:
            vector = _vector(getattr(given, direction))
        return Point(position) if isinstance(geometry, Point) else type(geometry)(position, vector)

    return Constraint(
        row.kind, part(row.platform, "a", "u"), part(row.base, "b", "v"), row.value, row.side
    )


def _vector(numbers: Sequence[arb]) -> Vector:
    x, y, z = map(_exact, numbers)
    return x, y, z


def _exact(x: arb) -> Number:
    """Return the middle of a ball; zero for what is too small for a coordinate."""
    if abs(x) < _LEAST:
        return Number.of(0)
    mantissa, exponent = x.mid().man_exp()
    return Number.of(int(mantissa) * Fraction(2) ** int(exponent))


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
        self._turn = 0.0 if apart > 0 else pi
        #: A place is log |s|; zero is s = 1, the platform itself.
        self._begin = log(abs(apart) / family.size)
        self._systems: dict[float, BallSystem] = {}
        self._weights: dict[tuple[float, ...], acb_mat] = {}

    @property
    def instance(self) -> Instance:
        """The platform at the beginning."""
        with ctx.workprec(self._bits(self._begin)):
            return self._family.instance_at(self._difference(self._begin).real)

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
            unit = acb(begin.scale) / acb(self._locator.scale)
            start = begin.in_frames(point, low)
            end = self._followed(start[:4] + [unit * x for x in start[4:]])
            if end is None:
                return None
            return self._locator.locate_exactly(end, self._sides, min(ctx.prec, _END_BITS))

    def _bits(self, x: float) -> int:
        """Return the bits for a place."""
        times, more = self._family.bits
        return int(more - times * log2(self._family.size * exp(x)))

    def _difference(self, x: float) -> acb:
        """Return s at a place, with as many bits as N needs there."""
        with ctx.workprec(self._bits(x)):
            # Real at both ends.
            turn = self._turn * x / self._begin + tanh(x) * tanh(self._begin - x)
            s = acb(x, turn).exp().mid() if 0 < x < self._begin else acb(arb(x).exp().mid())
            return -s if x == self._begin and self._turn else s

    def _system(self, x: float) -> BallSystem:
        """Return the equations at a place, with as many bits."""
        if (known := self._systems.get(x)) is not None:
            return known
        with ctx.workprec(self._bits(x)):
            found = BallSystem(
                self._family.instance, ctx.prec, self._family.at(self._difference(x))
            )
        if len(self._systems) < _KEPT:
            self._systems[x] = found
        return found

    def _solution(
        self, x: float, point: Numbers, patch: int, *, near: bool = True
    ) -> Numbers | None:
        """Return the limit of Newton's method if it converges as near a simple solution."""
        system, last = self._system(x), 1.0
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
        patch = _largest(start)
        point = self._solution(x, _divided(start, patch), patch, near=False)
        if point is None:
            return None
        unit = _largest(point[:4])
        in_base = self._family.in_base
        places, rows = [x], [_row(point, unit, in_base=in_base)]
        step, powers = _FIRST, (0, 0)
        for _ in range(_STEPS):
            step = min(step, x)
            row = self._extrapolated(places, rows, powers, x - step)
            point = _study_point(row[:4], row[4:7], row[7], in_base=in_base)
            patch = _largest(point)
            found = self._solution(x - step, _divided(point, patch), patch)
            if found is None:
                step /= _SHORTER
                continue
            x -= step
            if x == 0:
                return found
            row = _row(found, unit, in_base=in_base)
            of_moved, of_norm = (
                _power(row[k], rows[-1][k], self._ratio(x, places[-1]))
                for k in (4 + _largest(row[4:7]), 7)
            )
            # Other components of N T may vanish with other powers.
            powers = min(of_moved, 0), of_norm
            places, rows = [*places, x][-_POINTS:], [*rows, row][-_POINTS:]
            step *= max(_LONGER, 10 ** (_FIRST_POWER / (len(places) - 1)))
            if float(abs(row[_largest(row[:4])]).mid()) > _LARGE:
                # A coordinate that becomes large has a pole at s = 0.
                unit = _largest(row[:4])
                rows = [_in_unit(row, unit) for row in rows]
        return None

    def _ratio(self, x: float, other: float) -> acb:
        """Return the ratio of s at two places."""
        return self._difference(x) / self._difference(other)

    def _extrapolated(
        self, places: Sequence[float], rows: Sequence[Numbers], powers: tuple[int, int], x: float
    ) -> Numbers:
        """Return the row of the polynomials through rows at a place.

        The powers are those of s in N T and N.
        """
        key = (*places, x)
        if key not in self._weights:
            self._weights[key] = _weights([self._difference(y) for y in key])
        exponents = (0,) * 4 + powers[:1] * 3 + powers[1:]
        scaled = []
        for y, row in zip(places, rows, strict=True):
            ratio = self._ratio(x, y)
            scaled.append([(z * ratio**k).mid() for z, k in zip(row, exponents, strict=True)])
        return [z.mid() for z in (self._weights[key] * acb_mat(scaled)).entries()]


def _row(point: Numbers, unit: int, *, in_base: bool) -> Numbers:
    """Return e, half of N T, or of N U if not in the base, and N, for e_k = 1."""
    e, f = ([(x / point[unit]).mid() for x in part] for part in (point[:4], point[4:]))
    conjugate = [e[0], *(-x for x in e[1:])]
    moved = study.product(f, conjugate) if in_base else study.product(conjugate, f)
    return [x.mid() for x in (*e, *moved[1:], dot4(e, e))]


def _power(number: acb, before: acb, ratio: acb) -> int:
    """Return the power of s that a number grows with, from its value at another place."""
    slope = float(((number / before).log() / ratio.log()).real.mid())
    return round(slope) if isfinite(slope) else 0


def _in_unit(row: Numbers, unit: int) -> Numbers:
    """Return the row of another multiple of the Study point."""
    factor = 1 / row[unit]
    return [(x * factor ** (1 if i < 4 else 2)).mid() for i, x in enumerate(row)]


def _study_point(e: Numbers, moved: Numbers, norm: acb, *, in_base: bool) -> Numbers:
    """Return the Study point of a row after a small change of e that makes e.e the norm."""
    conjugate = [acb(x.real, -x.imag) for x in e]
    size = sum((x * y for x, y in zip(e, conjugate, strict=True)), acb(0))
    for _ in range(2):
        part = ((norm - dot4(e, e)) / (2 * size)).mid()
        e = [(x + part * y).mid() for x, y in zip(e, conjugate, strict=True)]
    norm = dot4(e, e)
    pair = ([acb(0), *moved], e) if in_base else (e, [acb(0), *moved])
    return [*e, *((x / norm).mid() for x in study.product(*pair))]


def _largest(point: Numbers) -> int:
    return max(range(len(point)), key=lambda k: float(abs(point[k]).mid()))


def _divided(point: Numbers, patch: int) -> Numbers:
    return [(number / point[patch]).mid() for number in point]


def _weights(places: Sequence[acb]) -> acb_mat:
    """Return the weights of all but the last place in a polynomial's value there (Lagrange)."""
    *given, s = places
    row = []
    for i, here in enumerate(given):
        weight = acb(1)
        for other in (*given[:i], *given[i + 1 :]):
            weight *= (s - other) / (here - other)
        row.append(weight.mid())
    return acb_mat(1, len(row), row)


def _part(step: Sequence[acb], point: Sequence[acb]) -> float:
    """Return the size of a step as a part of that of a point."""
    return float((largest(step) / largest(point)).mid())


def points_off_lines(instance: Instance) -> SpecialFamily | None:
    """Return a platform among those with its points moved off their line.

    The result is None if no points of a body are nearly on a line.
    """
    differences: list[dict[str, list[arb]]] = [{} for _ in instance.constraints]
    size = 0.0
    with ctx.workprec(DIFFERENCE_BITS):
        given = list(enumerate(statements(instance)))
        for kind, name in ((DPL, "a"), (DLP, "b")):
            points = {k: getattr(row, name) for k, row in given if row.kind is kind}
            for k, (off, far) in _off_line(points).items():
                differences[k][name] = off
                size = max(size, far)
    return SpecialFamily(instance, tuple(differences), size, _OF_POINTS) if size else None


def _off_line(points: Mapping[int, Sequence[arb]]) -> Mapping[int, tuple[list[arb], float]]:
    """Return points less their feet on the line of two points, and their sizes, by index.

    It is the line with the most others near it, of two points far from each other.
    """
    found: dict[int, tuple[list[arb], float]] = {}
    best = (_FEWEST - 1, inf)
    for a, b in combinations(points.values(), 2):
        along = [x - y for x, y in zip(b, a, strict=True)]
        if norm(along).contains(0):
            continue
        near = {k: off for k, point in points.items() if (off := _off(point, a, along))}
        number = (len(near), float(norm(along).mid()))
        if number > best:
            best, found = number, near
    least, _ = OFF_LINES
    return {k: (off, size) for k, (off, size) in found.items() if size > least}


def _off(
    point: Sequence[arb], a: Sequence[arb], along: Sequence[arb]
) -> tuple[list[arb], float] | None:
    """Return a point less its foot on the line through a along a vector, if it is near."""
    place = [x - y for x, y in zip(point, a, strict=True)]
    part = dot(place, along) / dot(along, along)
    off = [x - part * y for x, y in zip(place, along, strict=True)]
    size = float((norm(off) / norm(along)).mid())
    _, most = OFF_LINES
    return (off, size) if size < most else None


def turned_directions(instance: Instance) -> SpecialFamily | None:
    """Return a platform among those with its nearly parallel directions turned apart.

    The result is None if no directions of a body are nearly parallel.
    """
    differences: list[dict[str, list[arb]]] = [{} for _ in instance.constraints]
    size = 0.0
    with ctx.workprec(DIFFERENCE_BITS):
        given = statements(instance)
        for vector, point, body in (("u", "a", "platform"), ("v", "b", "base")):
            directions = [getattr(row, vector) for row in given]
            for k in range(len(given)):
                found = _turned(directions, k)
                if found is None:
                    continue
                other, differences[k][vector], angle = found
                size = max(size, angle)
                if all(_is_line(instance.constraints[i], body) for i in (other, k)):
                    offset, far = _offset(
                        getattr(given[k], point), getattr(given[other], point), directions[other]
                    )
                    if 0 < far < TURNED_APART_RADIANS[1]:
                        differences[k][point] = offset
                        size = max(size, far)
    return SpecialFamily(instance, tuple(differences), size, _OF_DIRECTIONS) if size else None


def _turned(directions: Sequence[Sequence[arb]], k: int) -> tuple[int, list[arb], float] | None:
    """Return the first direction that one is nearly parallel to, the difference and the angle."""
    for i, other in enumerate(directions[:k]):
        if other and directions[k] and (turn := _turn(other, directions[k])):
            return i, *turn
    return None


def _is_line(row: Constraint, body: str) -> bool:
    """Whether the place of a direction matters, across it."""
    return row.kind.is_distance and isinstance(getattr(row, body), Line)


def _offset(
    point: Sequence[arb], other: Sequence[arb], along: Sequence[arb]
) -> tuple[list[arb], float]:
    """Return a point less its foot on a line, and its distance in units of the scale."""
    place = [x - y for x, y in zip(point, other, strict=True)]
    part = dot(place, along) / dot(along, along)
    offset = [x - part * y for x, y in zip(place, along, strict=True)]
    if all(x.contains(0) for x in offset):
        return offset, 0.0
    return offset, float(norm(offset).mid())


def _turn(other: Sequence[arb], direction: Sequence[arb]) -> tuple[list[arb], float] | None:
    """Return the difference of two directions of the same length, and their angle."""
    length = norm(direction)
    factor = length / norm(other)
    if dot(other, direction) < 0:
        factor = -factor
    difference = [x - factor * y for x, y in zip(direction, other, strict=True)]
    if all(x.contains(0) for x in difference):
        return None
    angle = float((norm(difference) / length).mid())
    least, most = TURNED_APART_RADIANS
    return (difference, angle) if least < angle < most else None
