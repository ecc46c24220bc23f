"""The same platform in the frames in which its poses are expressed, with exact numbers.

An expressed pose of the platform is a pose of this one. What is proved of its boxes of poses is
proved of expressed poses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gspcli.errors import ArgumentError
from gspcli.geometry.exact_vectors import Matrix, Vector, less, plus, product, rotation, turned
from gspcli.geometry.frames import NO_HOME
from gspcli.geometry.home_pose import HomePose
from gspcli.geometry.instance import AngleUnit, Instance
from gspcli.geometry.numbers import Number, Real
from gspcli.geometry.primitives import Geometry, Line, Plane, Point
from gspcli.geometry.primitives import Vector as Triple
from gspcli.geometry.shapes import Shapes
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
        return [plus(*pair) for pair in zip(turned(self.axes, point), self.origin, strict=True)]

    def direction(self, vector: Vector) -> Triple:
        """Return a vector of the other frame in this one."""
        x, y, z = turned(_transposed(self.axes), vector)
        return x, y, z

    def inside(self, point: Vector) -> Triple:
        """Return a point of the other frame in this one."""
        return self.direction([less(*pair) for pair in zip(point, self.origin, strict=True)])


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
