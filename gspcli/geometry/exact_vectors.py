"""Exact vectors and rotations: fractions as far as numbers are rational, else expressions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

from gspcli.geometry.home_pose import HomePose
from gspcli.geometry.instance import AngleUnit
from gspcli.geometry.numbers import Number, parse_number

Vector: TypeAlias = "Sequence[Number]"
Matrix: TypeAlias = "Sequence[Vector]"

_AXES = "xyz"
_ZERO, _ONE = Number.of(0), Number.of(1)


def rotation(home: HomePose, unit: AngleUnit) -> Matrix:
    """Return the rotation of a stated pose or frame, exactly; rows of three numbers."""
    if home.euler is None:
        return _of_quaternion(home.quaternion)
    name = (
        {"sin": "sind", "cos": "cosd"} if unit is AngleUnit.DEGREE else {"sin": "sin", "cos": "cos"}
    )
    R: Matrix = [[_ONE if i == j else _ZERO for j in range(3)] for i in range(3)]
    for letter in home.euler:
        axis = _AXES.index(letter.lower())
        angle = home.angles[axis]
        sine, cosine = (parse_number(f"{name[f]}({angle})") for f in ("sin", "cos"))
        j, k = (axis + 1) % 3, (axis + 2) % 3
        turn = [[_ZERO] * 3 for _ in range(3)]
        turn[axis][axis] = _ONE
        turn[j][j] = turn[k][k] = cosine
        turn[k][j], turn[j][k] = sine, folded("neg", sine)
        R = product(R, turn) if letter.isupper() else product(turn, R)
    return R


def _of_quaternion(quaternion: Sequence[Number]) -> Matrix:
    w, x, y, z = quaternion
    norm = dot(quaternion, quaternion)

    def entry(a: Number, b: Number, operation: str, c: Number, d: Number) -> Number:
        """Return 2 (a b +- c d) / norm."""
        pair = folded(operation, folded("*", a, b), folded("*", c, d))
        return folded("/", folded("*", Number.of(2), pair), norm)

    def diagonal(a: Number, b: Number) -> Number:
        return less(_ONE, entry(a, a, "+", b, b))

    return [
        [diagonal(y, z), entry(x, y, "-", w, z), entry(x, z, "+", w, y)],
        [entry(x, y, "+", w, z), diagonal(x, z), entry(y, z, "-", w, x)],
        [entry(x, z, "-", w, y), entry(y, z, "+", w, x), diagonal(x, y)],
    ]


def product(a: Matrix, b: Matrix) -> Matrix:
    """Return the product of two matrices."""
    return [[dot(row, column) for column in zip(*b, strict=True)] for row in a]


def turned(R: Matrix, a: Vector) -> Vector:
    """Return ``R a``."""
    return [dot(row, a) for row in R]


def dot(a: Vector, b: Vector) -> Number:
    """Return the scalar product."""
    total = _ZERO
    for x, y in zip(a, b, strict=True):
        total = plus(total, folded("*", x, y))
    return total


def plus(a: Number, b: Number) -> Number:
    """Return ``a + b``."""
    return folded("+", a, b)


def less(a: Number, b: Number) -> Number:
    """Return ``a - b``."""
    return folded("-", a, b)


def folded(operation: str, *arguments: Number) -> Number:
    """Return a number, as one fraction if it is rational."""
    fractions = [one.fraction for one in arguments]
    if operation in ("+", "-") and fractions[1] == 0:
        return arguments[0]
    if operation == "*" and Fraction(0) in fractions:
        return _ZERO
    number = Number(operation, arguments)
    exact = number.fraction
    return number if exact is None else Number("rational", (exact,))
