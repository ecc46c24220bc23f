"""Values of constraints at the home pose, for files that state ``value: home``."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

from gspcli.catalogue.kinds import Kind, Law
from gspcli.geometry.home_pose import HomePose
from gspcli.geometry.instance import AngleUnit, Side
from gspcli.geometry.intervals import FineIntervals
from gspcli.geometry.numbers import Number, parse_number
from gspcli.geometry.primitives import Geometry, Line, Plane

Vector: TypeAlias = "Sequence[Number]"
Matrix: TypeAlias = "Sequence[Vector]"

#: A root is kept as an expression up to this length; what is longer is rounded.
_LONGEST = 100
#: Bits with which a number is evaluated before it is rounded to a double.
_BITS = 320
_AXES = "xyz"
_ZERO, _ONE = Number.of(0), Number.of(1)


def home_value(
    kind: Kind, side: Side, platform: Geometry, base: Geometry, home: HomePose, unit: AngleUnit
) -> Number:
    """Return what a constraint measures at the home pose, as a file states values.

    Parameters
    ----------
    kind, side, platform, base
        The constraint.
    home
        The home pose.
    unit
        The unit of angles.

    Returns
    -------
    Number
        A fraction or the root of a fraction, exactly, if it can be written in `_LONGEST`
        characters; otherwise the nearest double. Distances to planes are positive on the side of
        the constraint, and moduli if that is both.
    """
    R = _rotation(home, unit)
    u, v = (_direction(one) for one in (platform, base))
    u = u and _turned(R, u)
    if kind.is_distance:
        place = _turned(R, platform.position)
        r = [
            _plus(a, _less(t, x))
            for a, t, x in zip(place, home.position, base.position, strict=True)
        ]
        value = _distance(kind, r, u, v)
    else:
        assert u is not None
        assert v is not None
        value = _angle(kind, u, v, unit)
    value = _written(value)
    if side is Side.NEGATIVE or (side is Side.BOTH and kind.is_distance and value.value < 0):
        value = _folded("neg", value)
    return value


def _distance(kind: Kind, r: Vector, u: Vector | None, v: Vector | None) -> Number:
    """Return a distance; signed for planes and lines."""
    if kind.law is Law.MOMENT:
        assert u is not None
        assert v is not None
        normal = _cross(u, v)
        if any(x.value for x in normal):
            return _folded("/", _dot(r, normal), _root(_dot(normal, normal)))
        u = None
    along = u or v
    if along is None:
        return _root(_dot(r, r))
    if kind.has_sides:
        # The normal of the base points to the platform's point, that of the platform from it.
        product = _dot(r, along) if u is None else _folded("neg", _dot(r, along))
        return _folded("/", product, _root(_dot(along, along)))
    across = _cross(r, along)
    return _root(_folded("/", _dot(across, across), _dot(along, along)))


def _angle(kind: Kind, u: Vector, v: Vector, unit: AngleUnit) -> Number:
    law = kind.law
    cosine = _folded("/", _dot(u, v), _root(_folded("*", _dot(u, u), _dot(v, v))))
    if law.sign < 0:
        cosine = _folded("neg", cosine)
    angle = _folded("acos" if law.is_cosine else "asin", cosine)
    if unit is AngleUnit.DEGREE:
        angle = _folded("/", _folded("*", angle, Number.of(180)), Number("pi"))
    return angle


def _written(value: Number) -> Number:
    """Return a number that is short enough for a file, see `home_value`."""
    inside = value.arguments[0] if value.operation == "sqrt" else value
    if inside.fraction is not None and len(str(value)) <= _LONGEST:
        return value
    if not value.value:
        return _ZERO
    field = FineIntervals(_BITS)
    low, high = field.ends(value.evaluate(field))
    return Number.of(float((low + high) / 2))


def _direction(geometry: Geometry) -> Vector | None:
    return geometry.vector if isinstance(geometry, Line | Plane) else None


def _rotation(home: HomePose, unit: AngleUnit) -> Matrix:
    """Return the rotation of the home pose, exactly."""
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
        turn[k][j], turn[j][k] = sine, _folded("neg", sine)
        R = _product(R, turn) if letter.isupper() else _product(turn, R)
    return R


def _of_quaternion(quaternion: Sequence[Number]) -> Matrix:
    w, x, y, z = quaternion
    norm = _dot(quaternion, quaternion)

    def entry(a: Number, b: Number, operation: str, c: Number, d: Number) -> Number:
        """Return 2 (a b +- c d) / norm."""
        pair = _folded(operation, _folded("*", a, b), _folded("*", c, d))
        return _folded("/", _folded("*", Number.of(2), pair), norm)

    def diagonal(a: Number, b: Number) -> Number:
        return _less(_ONE, entry(a, a, "+", b, b))

    return [
        [diagonal(y, z), entry(x, y, "-", w, z), entry(x, z, "+", w, y)],
        [entry(x, y, "+", w, z), diagonal(x, z), entry(y, z, "-", w, x)],
        [entry(x, z, "-", w, y), entry(y, z, "+", w, x), diagonal(x, y)],
    ]


def _product(a: Matrix, b: Matrix) -> Matrix:
    return [[_dot(row, column) for column in zip(*b, strict=True)] for row in a]


def _turned(R: Matrix, a: Vector) -> Vector:
    return [_dot(row, a) for row in R]


def _dot(a: Vector, b: Vector) -> Number:
    total = _ZERO
    for x, y in zip(a, b, strict=True):
        total = _plus(total, _folded("*", x, y))
    return total


def _cross(a: Vector, b: Vector) -> Vector:
    return [
        _less(_folded("*", a[j], b[k]), _folded("*", a[k], b[j]))
        for j, k in ((1, 2), (2, 0), (0, 1))
    ]


def _plus(a: Number, b: Number) -> Number:
    return _folded("+", a, b)


def _less(a: Number, b: Number) -> Number:
    return _folded("-", a, b)


def _root(square: Number) -> Number:
    text = str(square)
    if square.fraction is not None and len(text) <= _LONGEST:
        # The root of a square is read as a fraction.
        return parse_number(f"sqrt({text})")
    return Number("sqrt", (square,))


def _folded(operation: str, *arguments: Number) -> Number:
    """Return a number, as one fraction if it is rational."""
    fractions = [one.fraction for one in arguments]
    if operation in ("+", "-") and fractions[1] == 0:
        return arguments[0]
    if operation == "*" and Fraction(0) in fractions:
        return _ZERO
    number = Number(operation, arguments)
    exact = number.fraction
    return number if exact is None else Number("rational", (exact,))
