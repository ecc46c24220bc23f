"""The same platform in the frames in which its poses are expressed, with exact numbers.

An expressed pose of the platform is a pose of this one. What is proved of its boxes of poses is
proved of expressed poses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

from gspcli.catalogue.kinds import DPL, Kind, Law
from gspcli.errors import ArgumentError
from gspcli.geometry import study
from gspcli.geometry.frames import NO_HOME
from gspcli.geometry.instance import AngleUnit, HomePose, Instance, Shapes, Side
from gspcli.geometry.numbers import Number, Real, parse_number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point
from gspcli.geometry.primitives import Vector as Triple
from gspcli.records import dataclass

_ZERO, _ONE = Number.of(0), Number.of(1)
_AXES: Matrix = ((_ONE, _ZERO, _ZERO), (_ZERO, _ONE, _ZERO), (_ZERO, _ZERO, _ONE))


@dataclass(frozen=True)
class _Exact:
    """A frame in another: its axes as columns, and its origin."""

    axes: Matrix = _AXES
    origin: Vector = (_ZERO, _ZERO, _ZERO)

    @classmethod
    def of(cls, stated: HomePose | None, unit: AngleUnit) -> _Exact:
        return cls() if stated is None else cls(rotation(stated, unit), stated.position)

    def outside(self, point: Vector) -> Vector:
        """Return where a point of the frame is in the other one."""
        return [a + b for a, b in zip(turned(self.axes, point), self.origin, strict=True)]

    def direction(self, vector: Vector) -> Triple:
        """Return a vector of the other frame in this one."""
        x, y, z = turned(_transposed(self.axes), vector)
        return x, y, z

    def inside(self, point: Vector) -> Triple:
        """Return a point of the other frame in this one."""
        return self.direction([a - b for a, b in zip(point, self.origin, strict=True)])


def expressed_instance(
    instance: Instance, *, pivot: Sequence[Real] = (0, 0, 0), relative: bool = False
) -> Instance:
    """Return the platform whose poses are the expressed poses of an instance.

    The coordinates of the base are those in the frame of the base in which poses are expressed, and
    those of the platform likewise (`gspcli.geometry.frames.PoseFrame`). It states no home, frames
    or masses.

    Parameters
    ----------
    instance
        The platform, with its frames and home.
    pivot, relative
        As for `PoseFrame.of`.

    Raises
    ------
    ArgumentError
        If home is needed and not stated.
    """
    unit, stated = instance.units.angle, instance.frames
    tool = _Exact.of(None if stated is None else stated.tool, unit)
    work = _Exact.of(None if stated is None else stated.work, unit)
    body, base = _Exact(tool.axes, tool.outside([*map(Number.of, pivot)])), work
    if relative:
        if instance.home is None:
            raise ArgumentError(NO_HOME)
        home = _Exact.of(instance.home, unit)
        base = _Exact(work.axes, home.outside(body.origin))
        body = _Exact(product(_transposed(home.axes), work.axes), body.origin)
    return _in_frames(instance, {"platform": body, "base": base})


def _in_frames(instance: Instance, frames: dict[str, _Exact]) -> Instance:
    """Return a platform with the coordinates of its bodies in other frames."""
    seen: dict[tuple[str, Geometry], Geometry] = {}

    def there(where: str, geometry: Geometry) -> Geometry:
        if (where, geometry) not in seen:
            seen[where, geometry] = _primitive(geometry, frames[where])
        return seen[where, geometry]

    rows = tuple(
        replace(row, platform=there("platform", row.platform), base=there("base", row.base))
        for row in instance.constraints
    )
    further = tuple((where, name, there(where, one)) for where, name, one in instance.further)
    shapes = instance.shapes
    if shapes is not None:
        hulls = ("platform", "base")
        points = {key: tuple(map(frames[key].inside, getattr(shapes, key))) for key in hulls}
        shapes = Shapes(shapes.diameters, **points, near_joint=shapes.near_joint)
    return replace(
        instance,
        constraints=rows,
        further=further,
        home=None,
        frames=None,
        dynamics=None,
        shapes=shapes,
    )


def _primitive(geometry: Geometry, frame: _Exact) -> Geometry:
    place = frame.inside(geometry.position)
    match geometry:
        case Point(cone=cone, crank=crank, slide=slide):
            if cone is not None:
                cone = replace(cone, axis=frame.direction(cone.axis))
            if crank is not None:
                centre, axis = frame.inside(crank.centre), frame.direction(crank.axis)
                crank = replace(crank, centre=centre, axis=axis)
            if slide is not None:
                slide = replace(slide, direction=frame.direction(slide.direction))
            return replace(geometry, position=place, cone=cone, crank=crank, slide=slide)
        case Line():
            return Line(place, frame.direction(geometry.direction))
        case Plane():
            return Plane(place, frame.direction(geometry.normal))


def _transposed(a: Matrix) -> Matrix:
    return [*zip(*a, strict=True)]


Vector: TypeAlias = "Sequence[Number]"
Matrix: TypeAlias = "Sequence[Vector]"

_AXIS_NAMES = "xyz"


def rotation(home: HomePose, unit: AngleUnit) -> Matrix:
    """Return the rotation of a stated pose or frame, exactly; rows of three numbers."""
    if home.euler is None:
        size, rows, _ = study.motion([*home.quaternion, *[_ZERO] * 4])
        return [[entry / size for entry in row] for row in rows]
    name = (
        {"sin": "sind", "cos": "cosd"} if unit is AngleUnit.DEGREE else {"sin": "sin", "cos": "cos"}
    )
    R: Matrix = [[_ONE if i == j else _ZERO for j in range(3)] for i in range(3)]
    for letter in home.euler:
        axis = _AXIS_NAMES.index(letter.lower())
        angle = home.angles[axis]
        sine, cosine = (parse_number(f"{name[f]}({angle})") for f in ("sin", "cos"))
        j, k = (axis + 1) % 3, (axis + 2) % 3
        turn = [[_ZERO] * 3 for _ in range(3)]
        turn[axis][axis] = _ONE
        turn[j][j] = turn[k][k] = cosine
        turn[k][j], turn[j][k] = sine, -sine
        R = product(R, turn) if letter.isupper() else product(turn, R)
    return R


def product(a: Matrix, b: Matrix) -> Matrix:
    """Return the product of two matrices."""
    return [[dot(row, column) for column in zip(*b, strict=True)] for row in a]


def turned(R: Matrix, a: Vector) -> Vector:
    """Return ``R a``."""
    return [dot(row, a) for row in R]


def dot(a: Vector, b: Vector) -> Number:
    """Return the scalar product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), _ZERO)


#: A root is kept as an expression up to this length; what is longer is rounded.
_LONGEST = 100


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
    value = _written(_measured(kind, platform, base, home, unit))
    if side is Side.NEGATIVE or (side is Side.BOTH and kind.is_distance and value.value < 0):
        value = -value
    return value


def _measured(
    kind: Kind, platform: Geometry, base: Geometry, home: HomePose, unit: AngleUnit
) -> Number:
    """Return what a constraint measures; signed for planes and lines."""
    motion = study.forms_of_pose(rotation(home, unit), home.position)
    u, v = (() if isinstance(one, Point) else one.vector for one in (platform, base))
    forms = study.forms_of(kind, platform.position, base.position, u, v)
    first: Number
    further: list[Number]
    first, *further = (sum(x * motion[k] for k, x in form.items()) for form in forms)
    sizes = (dot(u, u) if u else _ONE) * (dot(v, v) if v else _ONE)
    if kind.law is Law.MOMENT:
        sine = sizes - further[0] * further[0]
        if sine.value:
            return first / _root(sine)
        return _measured(DPL, Point(platform.position), base, home, unit)
    if kind.law is Law.SQUARE:
        return _root(first - further[0] * further[0] / sizes if further else first)
    quotient = first / _root(sizes)
    if kind.is_distance:
        return quotient
    law = kind.law
    angle = Number("acos" if law.is_cosine else "asin", (quotient * law.sign,))
    return angle * 180 / Number("pi") if unit is AngleUnit.DEGREE else angle


def _written(value: Number) -> Number:
    """Return a number that is short enough for a file, see `home_value`."""
    inside = value.arguments[0] if value.operation == "sqrt" else value
    if inside.fraction is not None and len(str(value)) <= _LONGEST:
        return value
    return Number.of(value.value)


def _root(square: Number) -> Number:
    text = str(square)
    if square.fraction is not None and len(text) <= _LONGEST:
        # The root of a square is read as a fraction.
        return parse_number(f"sqrt({text})")
    return Number("sqrt", (square,))
