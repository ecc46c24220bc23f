"""Exact parts of platforms: rational motions and directions, and what constraints measure there."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import isqrt
from random import Random
from typing import Any

from gspcli.catalogue.kinds import AHH, ALL, DHP, DLL, DLP, DPH, DPP, Kind
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point, vector

Vector = tuple[Fraction, Fraction, Fraction]
Rational = int | float | str | Fraction

#: Directions of integer length: their angles and one-sided planes are rational.
PYTHAGOREAN = (
    (1, 2, 2),
    (2, 3, 6),
    (1, 4, 8),
    (4, 4, 7),
    (2, 6, 9),
    (6, 6, 7),
    (3, 4, 12),
    (2, 5, 14),
    (2, 10, 11),
    (8, 9, 12),
)


def exact(*components: Rational) -> Vector:
    """Return a vector; a float stands for the decimals that it is printed with."""
    x, y, z = (Fraction(str(c)) if isinstance(c, float) else Fraction(c) for c in components)
    return x, y, z


ZERO = exact(0, 0, 0)


def rational(number: Number) -> Fraction:
    """Return a rational number as a fraction."""
    assert number.fraction is not None, number
    return number.fraction


def dot(a: Vector, b: Vector) -> Fraction:
    """Return a scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return a vector product."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def plus(a: Vector, b: Vector, factor: Rational = 1) -> Vector:
    """Return a + factor b."""
    scale = Fraction(factor)
    return a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]


def tenth(power: int) -> Fraction:
    """Return ten to the power of minus some number."""
    return Fraction(1, 10**power)


@dataclass(frozen=True)
class Motion:
    """A rational pose: ``x = R y + T``."""

    R: tuple[Vector, Vector, Vector]
    T: Vector

    def turned(self, u: Vector) -> Vector:
        """Return R u."""
        return dot(self.R[0], u), dot(self.R[1], u), dot(self.R[2], u)

    def placed(self, y: Vector) -> Vector:
        """Return R y + T."""
        return plus(self.turned(y), self.T)

    def unplaced(self, x: Vector) -> Vector:
        """Return R^T (x - T)."""
        return Motion(_transposed(self.R), exact(0, 0, 0)).turned(plus(x, self.T, -1))

    def unturned(self, v: Vector) -> Vector:
        """Return R^T v."""
        return Motion(_transposed(self.R), exact(0, 0, 0)).turned(v)


def _transposed(R: Sequence[Vector]) -> tuple[Vector, Vector, Vector]:
    first, second, third = zip(*R, strict=True)
    return first, second, third


def motion(quaternion: Sequence[Rational], T: Vector) -> Motion:
    """Return the pose of a rational quaternion of any length."""
    a, b, c, d = (Fraction(x) for x in quaternion)
    n = a * a + b * b + c * c + d * d
    R = (
        (a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
        (2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
        (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d),
    )
    first, second, third = ((x / n, y / n, z / n) for x, y, z in R)
    return Motion((first, second, third), T)


HOME = motion((1, 0, 0, 0), exact(0, 0, 0))


class Draws(Random):
    """Random exact parts, always the same for the same name."""

    def decimal(self, size: Rational = 1, places: int = 3) -> Fraction:
        """Return a decimal between minus and plus a size."""
        return Fraction(size) * Fraction(self.randrange(-(10**places), 10**places + 1), 10**places)

    def point(self, size: Rational = 1, places: int = 3) -> Vector:
        """Return a point."""
        return self.decimal(size, places), self.decimal(size, places), self.decimal(size, places)

    def points(self, count: int = 6, size: Rational = 1, *, planar: bool = False) -> list[Vector]:
        """Return points, in the plane z = 0 or not."""
        drawn = [self.point(size) for _ in range(count)]
        return [(x, y, Fraction(0)) for x, y, _ in drawn] if planar else drawn

    def direction(self) -> Vector:
        """Return a direction of integer length."""
        components = [c * self.choice((-1, 1)) for c in self.choice(PYTHAGOREAN)]
        self.shuffle(components)
        return exact(*components)

    def motion(self, size: Rational = 1, *, near: Vector | None = None) -> Motion:
        """Return a pose at some distance, or near one with small turns."""
        if near is None:
            turn = (self.randint(1, 4), *(self.randint(-4, 4) for _ in range(3)))
            return motion(turn, self.point(size))
        turn = (20, *(self.randint(-3, 3) for _ in range(3)))
        return motion(turn, plus(near, self.point(size)))

    def shaken(self, a: Vector, by: Rational) -> Vector:
        """Return a vector changed a little."""
        return plus(a, self.point(), by)


def geometry(letter: str, position: Vector, direction: Vector | None = None) -> Geometry:
    """Return the primitive of a letter: P, L or H."""
    if letter == "P":
        return Point(vector(*position))
    if direction is None:
        message = f"{letter} has a direction"
        raise ValueError(message)
    if letter == "L":
        return Line(vector(*position), vector(*direction))
    return Plane(vector(*position), vector(*direction))


@dataclass(frozen=True)
class Leg:
    """A constraint without its value: primitives by points and directions."""

    kind: Kind
    y: Vector
    x: Vector
    u: Vector = ZERO
    v: Vector = ZERO

    def with_vectors(self, vectors: Mapping[str, Vector]) -> Leg:
        """Return the constraint with some of its points and directions changed, by their names."""
        changes: dict[str, Any] = dict(vectors)
        return replace(self, **changes)

    def side(self, at: Motion) -> Side:
        """Return the side of the plane of a DPH or DHP."""
        return Side.POSITIVE if self._height(at) >= 0 else Side.NEGATIVE

    def _height(self, at: Motion) -> Fraction:
        if self.kind is DPH:
            return dot(self.v, plus(at.placed(self.y), self.x, -1))
        return dot(self.u, plus(at.unplaced(self.x), self.y, -1))

    def square(self, at: Motion) -> Fraction:
        """Return the square of the distance."""
        offset = plus(at.placed(self.y), self.x, -1)
        if self.kind is DPP:
            return dot(offset, offset)
        if self.kind in (DPH, DHP):
            normal = self.v if self.kind is DPH else self.u
            return self._height(at) ** 2 / dot(normal, normal)
        turned = at.turned(self.u)
        if self.kind is DLL:
            across = cross(turned, self.v)
            if any(across):
                return dot(offset, across) ** 2 / dot(across, across)
        along = turned if self.kind is DLP else self.v
        moment = cross(offset, along)
        return dot(moment, moment) / dot(along, along)

    def value(self, at: Motion, places: int | None) -> Number:
        """Return what is measured: exactly (angles in radians), or rounded (angles in degrees).

        Exact angles need directions of rational length.
        """
        if self.kind.is_distance:
            squared = self.square(at)
            return sqrt(squared) if places is None else decimals(math.sqrt(squared), places)
        product = dot(at.turned(self.u), self.v)
        if self.kind is AHH:
            product = -product
        square = dot(self.u, self.u) * dot(self.v, self.v)
        inverse = "acos" if self.kind in (ALL, AHH) else "asin"
        if places is None:
            if not is_square(square):
                message = f"{self.u} and {self.v} are not of rational length"
                raise ValueError(message)
            return Number(inverse, (Number.of(product / root(square)),))
        angle = getattr(math, inverse)(float(product) / math.sqrt(square))
        return decimals(math.degrees(angle), places)

    def constraint(self, value: Number, side: Side = Side.BOTH) -> Constraint:
        """Return the constraint with a value."""
        platform = geometry(self.kind.platform.value, self.y, self.u)
        base = geometry(self.kind.base.value, self.x, self.v)
        return Constraint(self.kind, platform, base, value, side)


def assembled(
    legs: Sequence[Leg],
    at: Motion,
    *,
    places: int | None = None,
    one_sided: Collection[int] = (),
    values: Mapping[int, Number] | None = None,
    degrees: bool = False,
    length: str = "unit",
) -> Instance:
    """Return a platform with a pose.

    Parameters
    ----------
    legs
        Six.
    at
        The pose.
    places
        To how many decimals values are rounded; None for exact ones.
    one_sided
        Indices of the planes of which only the side at the pose counts.
    values
        Other values than those at the pose, by index.
    degrees
        Whether exact values of angles are given by `values`, in degrees.
    length
        The name of the length unit.
    """
    given = dict(values or {})
    constraints = []
    for index, leg in enumerate(legs):
        value = given[index] if index in given else leg.value(at, places)
        side = leg.side(at) if index in one_sided else Side.BOTH
        constraints.append(leg.constraint(value, side))
    in_degrees = places is not None or degrees or all(leg.kind.is_distance for leg in legs)
    unit = AngleUnit.DEGREE if in_degrees else AngleUnit.RADIAN
    return Instance(tuple(constraints), Units(length, unit))


def is_square(value: Fraction) -> bool:
    """Return whether a fraction has a rational square root."""
    return root(value) ** 2 == value


def root(value: Fraction) -> Fraction:
    """Return the square root of a fraction that has a rational one."""
    return Fraction(isqrt(value.numerator), isqrt(value.denominator))


def sqrt(value: Fraction) -> Number:
    """Return an exact square root."""
    return Number.of(root(value)) if is_square(value) else Number("sqrt", (Number.of(value),))


def decimals(value: float, places: int) -> Number:
    """Return a number rounded to some decimals."""
    return Number.of(Fraction(round(value * 10**places), 10**places))
