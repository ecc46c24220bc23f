"""Instances as exact polynomials in the Study parameters.

Written from the definitions of the constraints, not from the package's quadrics: that both have
the same solutions is part of what a run checks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import isqrt
from typing import Any

from sympy import QQ
from sympy.polys.rings import PolyElement, ring

from gspcli.catalogue.kinds import AHH, DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.instance import Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point

Vector = Sequence[Any]
#: An equation as a sum of products of two polynomials, which is zero.
Equation = tuple[tuple[PolyElement, PolyElement], ...]
_SIGNS = {Side.POSITIVE: 1, Side.NEGATIVE: -1}


@dataclass(frozen=True)
class Motion:
    """A rigid motion ``x -> R x + T`` in some coordinates, everything times N.

    With U = R^T T and rho = T.T; `W` returns ``N (T x R w)`` for a vector w.
    """

    names: tuple[str, ...]
    N: Any
    R: tuple[Vector, ...]
    T: Vector
    U: Vector
    rho: Any
    W: Callable[[Vector], Vector]
    relations: tuple[PolyElement, ...]

    @cached_property
    def columns(self) -> tuple[Vector, ...]:
        """The columns of N R."""
        return tuple(zip(*self.R, strict=True))

    def turned(self, w: Vector) -> Vector:
        """Return ``N R w``."""
        return [dot(row, w) for row in self.R]

    def turned_back(self, w: Vector) -> Vector:
        """Return ``N R^T w``."""
        return [dot(column, w) for column in self.columns]


def study() -> Motion:
    """Return motions in the Study parameters e and f; with ``e.f = 0``."""
    names = tuple(f"{letter}{i}" for letter in "ef" for i in range(4))
    _, *z = ring(names, QQ)
    e, f = z[:4], z[4:]
    conjugate = [e[0], *(-x for x in e[1:])]
    dual = [f[0], *(-x for x in f[1:])]

    def sandwich(w: Vector, left: Vector, right: Vector) -> Vector:
        return _product(_product(left, [0, *w]), right)[1:]

    def moment(w: Vector) -> Vector:
        pairs = zip(sandwich(w, e, dual), sandwich(w, f, conjugate), strict=True)
        return [a + b for a, b in pairs]

    axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    columns = [sandwich(axis, e, conjugate) for axis in axes]
    return Motion(
        names=names,
        N=dot(e, e),
        R=tuple(zip(*columns, strict=True)),
        T=[2 * x for x in _product(f, conjugate)[1:]],
        U=[2 * x for x in _product(conjugate, f)[1:]],
        rho=4 * dot(f, f),
        W=moment,
        relations=(dot(e, f),),
    )


def equations(instance: Instance, motion: Motion) -> list[Equation]:
    """Return one equation for each constraint.

    Raises
    ------
    ValueError
        If a direction has an irrational length, an angle an irrational cosine, or the side of
        a plane is left open.
    """
    return [_equation(row, motion) for row in instance.constraints]


def _equation(row: Constraint, motion: Motion) -> Equation:
    y, u = _exact(row.platform)
    x, v = _exact(row.base)
    N, one = motion.N, motion.N.ring.one
    if not row.kind.is_distance:
        aim = _cosine(row.kind, row.value) * _length(u) * _length(v)
        return ((dot(motion.turned(u), v) - aim * N, one),)
    d = _rational(row.value)
    turned_y, turned_x = motion.turned(y), motion.turned_back(x)
    # r = R y + T - x, and the same seen from the platform: s = R^T x - U - y.
    r = [a + b - N * c for a, b, c in zip(turned_y, motion.T, x, strict=True)]
    s = [a - b - N * c for a, b, c in zip(turned_x, motion.U, y, strict=True)]
    sphere = (
        N * (dot(x, x) + dot(y, y) - d**2) + motion.rho
        + 2 * (dot(y, motion.U) - dot(x, motion.T) - dot(x, turned_y))
    )  # fmt: skip
    if row.kind is DPP:
        return ((sphere, one),)
    if row.kind in (DPH, DHP):
        normal, distance = (v, dot(v, r)) if row.kind is DPH else (u, dot(u, s))
        return ((distance - _sign(row) * d * _length(normal) * N, one),)
    if row.kind in (DPL, DLP):
        line, along = (v, dot(v, r)) if row.kind is DPL else (u, dot(u, s))
        return ((dot(line, line) * N, sphere), (along, -along))
    assert row.kind is DLL, row.kind
    turned = motion.turned(u)
    moment = (
        dot(v, motion.turned(cross(y, u))) + dot(v, motion.W(u)) - dot(turned, cross(v, x))
    )  # fmt: skip
    size, cosine = _length(u) * _length(v), dot(turned, v)
    # M^2 = d^2 (1 - C^2)
    return (moment, moment), (d * cosine, d * cosine), (d * size * N, -d * size * N)


def expanded(equation: Equation) -> PolyElement:
    """Return the polynomial of an equation."""
    return sum((p * q for p, q in equation), start=equation[0][0].ring.zero)


def affine(polynomial: PolyElement) -> PolyElement:
    """Return the polynomial for a first unknown of one, in the others."""
    space, *_ = ring(polynomial.ring.symbols[1:], QQ)
    result = space.zero
    for powers, coefficient in polynomial.terms():
        result += space({powers[1:]: coefficient})
    return result


def dot(a: Vector, b: Vector) -> Any:
    """Return the scalar product."""
    return sum((p * q for p, q in zip(a, b, strict=True)), start=0 * a[0])


def cross(a: Vector, b: Vector) -> list[Any]:
    """Return the vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _product(a: Vector, b: Vector) -> list[Any]:
    """Return the product of two quaternions."""
    outer = cross(a[1:], b[1:])
    scalar = a[0] * b[0] - dot(a[1:], b[1:])
    return [scalar, *(a[0] * q + p * b[0] + c for p, q, c in zip(a[1:], b[1:], outer, strict=True))]


def _exact(geometry: Any) -> tuple[list[Any], list[Any]]:
    """Return a point and, except for points, the direction or normal of a primitive."""
    position = [_rational(number) for number in geometry.position]
    if isinstance(geometry, Point):
        return position, []
    direction = geometry.direction if hasattr(geometry, "direction") else geometry.normal
    return position, [_rational(number) for number in direction]


def _rational(number: Number) -> Any:
    if number.fraction is None:
        message = f"{number} is not rational"
        raise ValueError(message)
    return QQ(number.fraction.numerator, number.fraction.denominator)


def _length(w: Vector) -> Any:
    square = Fraction(str(dot(w, w)))
    root = Fraction(isqrt(square.numerator), isqrt(square.denominator))
    if root**2 != square:
        message = f"a direction has the irrational length sqrt({square})"
        raise ValueError(message)
    return QQ(root.numerator, root.denominator)


def _cosine(kind: Kind, angle: Number) -> Any:
    """Return the value of ``R u . v`` for unit vectors, by the paper's signs (Section 4)."""
    wanted = "acos" if kind.platform is kind.base else "asin"
    if angle.operation != wanted:
        message = f"the angle {angle} of an {kind} is not stated as {wanted}(...)"
        raise ValueError(message)
    return (-1 if kind is AHH else 1) * _rational(angle.arguments[0])


def _sign(row: Constraint) -> int:
    if row.side is Side.BOTH:
        message = "the side of a plane is left open"
        raise ValueError(message)
    return _SIGNS[row.side]
