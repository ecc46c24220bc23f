"""A platform at poses: its constraints, and so much of each line and plane as they need."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Kind, Primitive
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.primitives import Geometry, Point
from gspcli.pictures.hulls import convex_hull
from gspcli.pictures.scene import DrawnBody, DrawnPrimitive, Stroke, StrokeStyle
from gspcli.pictures.strokes import (
    Sizes,
    StrokeEnds,
    angle_strokes,
    connection,
    distance_strokes,
    perpendicular,
)

Array = NDArray[np.float64]

#: Marks as fractions of the size of the scene.
_SQUARE, _RAY, _ARC = 0.045, 0.36, 0.24
#: Half of the least part of a line, or of the side of a plane, that is drawn.
_HALF = 0.3
#: What is drawn of a primitive goes this much beyond the feet on it.
_MARGIN = 0.12
#: Feet farther than this from the others do not stretch what is drawn of a primitive.
_NEAR = 2.5
#: Where on its line an angle is drawn: this far from the middle to the end.
_OUTWARD = 0.55
#: Feet outside by less than this fraction of the drawn part are inside.
_INSIDE = 1e-6


def guides(element: DrawnPrimitive, feet: Array) -> Iterator[Stroke]:
    """Yield the way from what is drawn of a primitive to a foot on it at each pose.

    Parameters
    ----------
    element
        The primitive.
    feet
        One point of it at each pose, in the frame of its body, shape (n, 3). Where the foot is
        inside, both ends of the stroke are the foot; if it always is, there is no stroke.
    """
    if element.primitive is Primitive.POINT:
        return
    centre = element.centre
    if element.primitive is Primitive.LINE:
        halves = (element.outline[1] - element.outline[0])[None] / 2
    else:
        corners = element.outline
        halves = np.stack((corners[1] - corners[0], corners[3] - corners[0])) / 2
    squares = (halves * halves).sum(axis=1)
    along = (feet - centre) @ halves.T / squares
    inside = np.clip(along, -1, 1)
    if (np.abs(along - inside) <= _INSIDE).all():
        return
    nearest = np.where(np.abs(along - inside) <= _INSIDE, along, inside)
    yield Stroke(StrokeStyle.GUIDE, np.stack((centre + nearest @ halves, feet), axis=1))


class _Placed(NamedTuple):
    """A constraint at all poses of all series, in the frame of the base."""

    kind: Kind
    ends: StrokeEnds
    platform: str
    base: str


class Stage:
    """The constraints of an arrangement at poses, and what is drawn of their primitives.

    Parameters
    ----------
    arrangement
        The platform.
    names
        Of both primitives of each constraint.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3), real.
    size
        That of another stage, if marks are to be as large as there.

    Attributes
    ----------
    size
        The radius of all ends of constraints together, at the median of the poses.
    """

    def __init__(
        self,
        arrangement: Arrangement,
        names: Sequence[tuple[str, str]],
        R: Array,
        T: Array,
        size: float | None = None,
    ) -> None:
        self.R, self.T = R, T
        n = len(R)
        self.placed = []
        for i, kind in enumerate(arrangement.kinds):
            p = R @ arrangement.y[i] + T
            w = R @ arrangement.u[i]
            x = np.broadcast_to(arrangement.x[i], (n, 3))
            v = np.broadcast_to(arrangement.v[i], (n, 3))
            ends = connection(kind, p, w, x, v) if kind.is_distance else StrokeEnds(p, x, w, v)
            self.placed.append(_Placed(kind, ends, *names[i]))
        #: Six digits, so that pages do not depend on rounding errors of poses.
        self.size = float(f"{self._size(arrangement):.6g}") if size is None else size
        self.sizes = Sizes(_SQUARE * self.size, _RAY * self.size, _ARC * self.size)

    def _size(self, arrangement: Arrangement) -> float:
        """Return the radius of all ends of constraints together, at the median of the poses."""
        points = arrangement.x[None]
        if len(self.R):
            points = np.stack([end for each in self.placed for end in each.ends[:2]], axis=1)
        offsets = points - points.mean(axis=1, keepdims=True)
        radii = np.linalg.norm(offsets, axis=2).max(axis=1)
        return float(np.median(radii)) or arrangement.length

    def to_platform(self, points: Array) -> Array:
        """Return points (n, 3), one at each pose, in the frame of the platform."""
        return np.asarray(np.einsum("nji,nj->ni", self.R, points - self.T))

    def body(self, name: str, primitives: Sequence[Geometry]) -> DrawnBody:
        """Return a body with what is drawn of each of its primitives."""
        platform = name == "platform"
        elements: dict[str, DrawnPrimitive] = {}
        for primitive, placed in zip(primitives, self.placed, strict=True):
            label = placed.platform if platform else placed.base
            if label not in elements:
                feet = [
                    self._feet(other, platform)
                    for other in self.placed
                    if (other.platform if platform else other.base) == label
                    and other.kind.is_distance
                ]
                elements[label] = self._element(label, primitive, feet)
        # A plane needs no line to the body.
        joined = [e.centre for e in elements.values() if e.primitive is not Primitive.PLANE]
        return DrawnBody(
            name, tuple(elements.values()), convex_hull(np.array(joined).reshape(-1, 3))
        )

    def _feet(self, placed: _Placed, platform: bool) -> Array:
        """Return the ends of a distance on a body in the body's frame."""
        if platform:
            return self.to_platform(placed.ends.platform)
        return placed.ends.base

    def _element(self, name: str, primitive: Geometry, feet: list[Array]) -> DrawnPrimitive:
        anchor = primitive.point
        if isinstance(primitive, Point):
            return DrawnPrimitive(name, primitive.primitive, anchor[None], None)
        points = np.concatenate(feet) if feet and len(self.R) else anchor[None]
        middle = np.median(points, axis=0)
        points = points[np.linalg.norm(points - middle, axis=1) <= _NEAR * self.size]
        if not len(points):
            points = anchor[None]
        direction = primitive.unit
        if primitive.primitive is Primitive.LINE:
            axes = direction[None]
            corners = [[-1.0], [1.0]]
        else:
            first = perpendicular(direction)
            axes = np.stack((first, np.cross(direction, first)))
            corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        along = (points - anchor) @ axes.T
        low, high = along.min(axis=0), along.max(axis=0)
        half = np.maximum((high - low) / 2 + _MARGIN * self.size, _HALF * self.size)
        middle = anchor + (low + high) / 2 @ axes
        return DrawnPrimitive(
            name, primitive.primitive, middle + (np.array(corners) * half) @ axes, direction
        )

    def drawn(self, platform: DrawnBody, base: DrawnBody) -> tuple[list[tuple[Stroke, ...]], Array]:
        """Return the strokes of every constraint and where its number is written, (n, 6, 3)."""
        of_platform = {element.name: element for element in platform.elements}
        of_base = {element.name: element for element in base.elements}
        strokes, labels = [], []
        for placed in self.placed:
            on_platform, on_base = of_platform[placed.platform], of_base[placed.base]
            if placed.kind.is_distance:
                ends = placed.ends
                drawn = [*distance_strokes(placed.kind, ends, self.sizes)]
                drawn += guides(on_base, ends.base)
                feet = self.to_platform(ends.platform)
                for guide in guides(on_platform, feet):
                    moved = np.einsum("nij,nkj->nki", self.R, guide.points) + self.T[:, None]
                    drawn.append(Stroke(guide.style, moved))
                middle = (ends.platform + ends.base) / 2
            else:
                at = self._vertex(on_platform, on_base)
                ends = placed.ends._replace(platform=at, base=at)
                drawn = [*angle_strokes(placed.kind, ends, self.sizes)]
                arc = drawn[0].points
                middle = at + 1.25 * (arc[:, arc.shape[1] // 2] - at)
            strokes.append(tuple(drawn))
            labels.append(middle)
        return strokes, np.stack(labels, axis=1)

    def _vertex(self, on_platform: DrawnPrimitive, on_base: DrawnPrimitive) -> Array:
        """Return where an angle is drawn at each pose, shape (n, 3)."""
        n = len(self.R)
        if on_base.primitive is Primitive.LINE and on_platform.primitive is Primitive.PLANE:
            return np.asarray(self.R @ on_platform.centre + self.T)
        at = on_base.centre
        if on_base.primitive is Primitive.LINE:
            at = at + _OUTWARD * (on_base.outline[1] - at)
        return np.broadcast_to(at, (n, 3))
