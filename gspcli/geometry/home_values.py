"""Values of constraints at the home pose, for files that state ``value: home``."""

from __future__ import annotations

from gspcli.catalogue.kinds import Kind, Law
from gspcli.geometry.exact_vectors import (
    Vector,
    dot,
    folded,
    less,
    plus,
    rotation,
    turned,
)
from gspcli.geometry.home_pose import HomePose
from gspcli.geometry.instance import AngleUnit, Side
from gspcli.geometry.intervals import FineIntervals
from gspcli.geometry.numbers import Number, parse_number
from gspcli.geometry.primitives import Geometry, Line, Plane

#: A root is kept as an expression up to this length; what is longer is rounded.
_LONGEST = 100
#: Bits with which a number is evaluated before it is rounded to a double.
_BITS = 320
_ZERO = Number.of(0)


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
    R = rotation(home, unit)
    u, v = (_direction(one) for one in (platform, base))
    u = u and turned(R, u)
    if kind.is_distance:
        place = turned(R, platform.position)
        r = [
            plus(a, less(t, x)) for a, t, x in zip(place, home.position, base.position, strict=True)
        ]
        value = _distance(kind, r, u, v)
    else:
        assert u is not None
        assert v is not None
        value = _angle(kind, u, v, unit)
    value = _written(value)
    if side is Side.NEGATIVE or (side is Side.BOTH and kind.is_distance and value.value < 0):
        value = folded("neg", value)
    return value


def _distance(kind: Kind, r: Vector, u: Vector | None, v: Vector | None) -> Number:
    """Return a distance; signed for planes and lines."""
    if kind.law is Law.MOMENT:
        assert u is not None
        assert v is not None
        normal = _cross(u, v)
        if any(x.value for x in normal):
            return folded("/", dot(r, normal), _root(dot(normal, normal)))
        u = None
    along = u or v
    if along is None:
        return _root(dot(r, r))
    if kind.has_sides:
        # The normal of the base points to the platform's point, that of the platform from it.
        product = dot(r, along) if u is None else folded("neg", dot(r, along))
        return folded("/", product, _root(dot(along, along)))
    across = _cross(r, along)
    return _root(folded("/", dot(across, across), dot(along, along)))


def _angle(kind: Kind, u: Vector, v: Vector, unit: AngleUnit) -> Number:
    law = kind.law
    cosine = folded("/", dot(u, v), _root(folded("*", dot(u, u), dot(v, v))))
    if law.sign < 0:
        cosine = folded("neg", cosine)
    angle = folded("acos" if law.is_cosine else "asin", cosine)
    if unit is AngleUnit.DEGREE:
        angle = folded("/", folded("*", angle, Number.of(180)), Number("pi"))
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


def _cross(a: Vector, b: Vector) -> Vector:
    return [
        less(folded("*", a[j], b[k]), folded("*", a[k], b[j])) for j, k in ((1, 2), (2, 0), (0, 1))
    ]


def _root(square: Number) -> Number:
    text = str(square)
    if square.fraction is not None and len(text) <= _LONGEST:
        # The root of a square is read as a fraction.
        return parse_number(f"sqrt({text})")
    return Number("sqrt", (square,))
