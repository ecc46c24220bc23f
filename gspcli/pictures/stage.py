"""A platform at poses: its constraints, and so much of each line and plane as they need."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind, Primitive
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import BODIES, choose, moved
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.machine import Machine, arms_of
from gspcli.geometry.measurement import condition_numbers, measured, printed_residual, sides_of
from gspcli.geometry.primitives import Geometry, Point
from gspcli.geometry.quaternions import cross, dot, quaternion_from_rotation
from gspcli.geometry.tolerances import PARALLEL_SINE
from gspcli.pictures.scene import (
    DrawnBody,
    DrawnConstraint,
    DrawnPrimitive,
    Scene,
    SceneSeries,
    Stroke,
    StrokeStyle,
)
from gspcli.records import dataclass
from gspcli.solver.result import SolveResult
from gspcli.ties import definite_sign

Array = NDArray[np.float64]


# The strokes of each kind of constraint, at many poses at a time.
#
# A distance is drawn as its shortest connection, with marks of its right angles. An angle is drawn
# as an arc between the two directions, both moved to a point of the base's primitive; for AHL to
# the platform's plane, in which the angle lies. The conventions are those of the paper's Section 4:
# an AHH angle lies between one normal and the opposite of the other, an angle of a line and a plane
# is measured from the line's projection.

_ARC_POINTS = 13


class Sizes(NamedTuple):
    """How large marks are drawn, in length units."""

    square: float
    ray: float
    arc: float


class ConstraintEnds(NamedTuple):
    """Where a constraint meets its primitives at n poses (or at one), in the frame of the base."""

    #: The end of the shortest connection at each body, or the point at which an angle is drawn
    #: (both times), shape (n, 3).
    platform: Array
    base: Array
    #: Unit direction or normal of the primitive of the platform and of the base, (n, 3); zero for
    #: points.
    w: Array
    v: Array


def connection(kind: Kind, p: Array, w: Array, x: Array, v: Array) -> ConstraintEnds:
    """Return the ends of the shortest connection of a distance.

    Points of the primitives of platform and base are p and x, their unit directions w and v, of
    shape (n, 3).
    """
    r = p - x
    if kind is DPL:
        return ConstraintEnds(p, x + _along(r, v), w, v)
    if kind is DLP:
        return ConstraintEnds(p - _along(r, w), x, w, v)
    if kind is DPH:
        return ConstraintEnds(p, p - _along(r, v), w, v)
    if kind is DHP:
        return ConstraintEnds(x + _along(r, w), x, w, v)
    if kind is DLL:
        normal = cross(w, v)
        square = dot(normal, normal)[:, None]
        parallel = square < PARALLEL_SINE**2
        safe = np.where(parallel, 1.0, square)
        s = dot(cross(v, r), normal)[:, None] / safe
        t = dot(cross(w, r), normal)[:, None] / safe
        at_platform = np.where(parallel, p, p + s * w)
        at_base = np.where(parallel, x + _along(r, v), x + t * v)
        return ConstraintEnds(at_platform, at_base, w, v)
    if kind is not DPP:
        raise ValueError(kind)
    return ConstraintEnds(p, x, w, v)


def distance_strokes(kind: Kind, ends: ConstraintEnds, sizes: Sizes) -> Iterator[Stroke]:
    """Yield what is drawn for a distance."""
    style = StrokeStyle.LEG if kind is DPP else StrokeStyle.PERPENDICULAR
    yield Stroke(style, np.stack((ends.platform, ends.base), axis=1))
    leg = ends.platform - ends.base
    length = np.linalg.norm(leg, axis=1, keepdims=True)
    # A mark no larger than a third of the leg, so that short legs stay visible.
    size = np.minimum(sizes.square, length / 3)
    if kind in (DPL, DPH, DLL):
        aside = ends.v if kind is not DPH else perpendicular(ends.v)
        yield _square(ends.base, leg, aside, size)
    if kind in (DLP, DHP, DLL):
        aside = ends.w if kind is not DHP else perpendicular(ends.w)
        yield _square(ends.platform, -leg, aside, size)


def angle_strokes(kind: Kind, ends: ConstraintEnds, sizes: Sizes) -> Iterator[Stroke]:
    """Yield what is drawn for an angle at ``ends.base``: the arc first."""
    at = ends.base
    first, second = arms(kind, ends)
    across = second - dot(first, second)[:, None] * first
    norm = np.linalg.norm(across, axis=1, keepdims=True)
    across = np.where(
        norm > PARALLEL_SINE, across / np.where(norm > 0, norm, 1), perpendicular(first)
    )
    angle = np.arctan2(norm[:, 0], dot(first, second))
    turn = angle[:, None] * np.linspace(0, 1, _ARC_POINTS)
    arc = np.cos(turn)[..., None] * first[:, None] + np.sin(turn)[..., None] * across[:, None]
    yield Stroke(StrokeStyle.ARC, at[:, None] + sizes.arc * arc)
    for arm in (first, second):
        yield Stroke(StrokeStyle.RAY, np.stack((at, at + sizes.ray * arm), axis=1))


def arms(kind: Kind, ends: ConstraintEnds) -> tuple[Array, Array]:
    """Return the unit directions between which an angle lies, from the base on, (n, 3) each."""
    w, v = ends.w, ends.v
    if kind.law.is_cosine:
        return v, kind.law.sign * w
    line, normal = (w, v) if kind.base.value == "H" else (v, w)
    flat = line - dot(line, normal)[:, None] * normal
    norm = np.linalg.norm(flat, axis=1, keepdims=True)
    flat = np.where(norm > PARALLEL_SINE, flat / np.where(norm > 0, norm, 1), perpendicular(normal))
    return (flat, line) if line is w else (line, flat)


def perpendicular(directions: Array) -> Array:
    """Return one unit vector perpendicular to each unit vector, ``(..., 3) -> (..., 3)``.

    It is horizontal, unless the direction is vertical: then it is the first axis.
    """
    horizontal = np.stack(
        (-directions[..., 1], directions[..., 0], np.zeros_like(directions[..., 0])), axis=-1
    )
    norm = np.linalg.norm(horizontal, axis=-1, keepdims=True)
    safe = np.where(norm > PARALLEL_SINE, norm, 1.0)
    return np.where(norm > PARALLEL_SINE, horizontal / safe, np.array([1.0, 0.0, 0.0]))


def _along(r: Array, direction: Array) -> Array:
    return np.asarray(dot(r, direction)[:, None] * direction)


def _square(at: Array, leg: Array, aside: Array, size: Array) -> Stroke:
    """Return the mark of the right angle between a leg and a unit direction."""
    norm = np.linalg.norm(leg, axis=1, keepdims=True)
    up = size * leg / np.where(norm > 0, norm, 1.0)
    side = size * aside
    return Stroke(StrokeStyle.SQUARE, np.stack((at + side, at + side + up, at + up), axis=1))


#: Half of what is drawn of a rail without a range, in sizes of the scene.
_RAIL = 0.2


def with_drives(instance: Instance, poses: Poses) -> Poses:
    """Return poses with the numbers of the drives at each, where an instance has cranks or slides.

    Poses that state coordinates, or that the rods do not reach, are not changed: their points stay
    where they are stated, and the rods change their lengths.
    """
    if poses.coordinates or not len(poses.T):
        return poses
    drives = Machine.of(instance)
    moved = np.flatnonzero(drives.moved).tolist()
    q = drives.inverse(poses.R, poses.T)[:, moved] / drives.units[moved]
    if np.isnan(q).any():
        return poses
    names = tuple(drives.names[k] for k in moved)
    return replace(poses, coordinates=names, places=q)


def arm_strokes(instance: Instance, poses: Poses, size: float) -> list[tuple[Stroke, ...]]:
    """Return what is drawn of the arm or rail of each constraint at poses; nothing of values.

    An arm leads from the axis of its crank to the point, a rail along the range of its slide.
    Drives that are no coordinates of the poses are where the instance states them.
    """
    drives, count = Machine.of(instance), len(poses.T)
    if not drives.moves or not count:
        return [()] * len(instance.constraints)
    q = np.zeros((count, drives.count))
    for name, column in zip(poses.coordinates, poses.places.T, strict=False):
        if name in drives.names:
            k = drives.names.index(name)
            q[:, k] = column * drives.units[k]
    points = drives.points(q)
    found: list[tuple[Stroke, ...]] = []
    for k in range(len(instance.constraints)):
        sort = drives.sorts[drives.index[k]]
        if not drives.driven[k]:
            found.append(())
            continue
        start = np.broadcast_to(drives.middle[k], (count, 3))
        ends = start, points[:, k]
        if sort == "slide":
            low, high = _rail(drives, k, size)
            ends = start + low * drives.beside[k], start + high * drives.beside[k]
        line = np.stack(ends, axis=1)
        if drives.on_platform[k]:
            line = line @ np.swapaxes(poses.R, -1, -2) + poses.T[:, None]
        style = StrokeStyle.PERPENDICULAR if sort == "crank" else StrokeStyle.GUIDE
        found.append((Stroke(style, line),))
    return found


def drawn_drives(instance: Instance) -> list[dict[str, Any] | None]:
    """Return of each constraint the crank or slide that moves its point, as data for a page.

    Returns
    -------
    list
        None without one, else its ``sort``, the ``body`` of the point, ``middle``, ``across`` and
        ``beside``, ``unit``, ``factor`` and ``offset`` (`gspcli.geometry.machine.Drives`), and its
        ``range`` in radians or lengths, or None.
    """
    drives = Machine.of(instance)
    found: list[dict[str, Any] | None] = []
    for k, driven in enumerate(drives.driven.tolist()):
        drive = drives.index[k]
        ends = [drives.low[drive].item(), drives.high[drive].item()]
        one = {
            "sort": drives.sorts[drive],
            "body": BODIES[0] if drives.on_platform[k] else BODIES[1],
            **{name: getattr(drives, name)[k].tolist() for name in ("middle", "across", "beside")},
            "range": ends if np.isfinite(ends).all() else None,
            "unit": drives.units[drive].item(),
            "factor": drives.factors[drive].item(),
            "offset": drives.offsets[drive].item(),
        }
        found.append(one if driven else None)
    return found


def _rail(drives: Machine, k: int, size: float) -> tuple[float, float]:
    """Return the ends of a rail from its stated point."""
    low, high = drives.low[drives.index[k]], drives.high[drives.index[k]]
    if np.isfinite([low, high]).all():
        return float(low), float(high)
    return -_RAIL * size, _RAIL * size


def joined(
    strokes: Sequence[tuple[Stroke, ...]], more: Sequence[tuple[Stroke, ...]]
) -> tuple[tuple[Stroke, ...], ...]:
    """Return the strokes of each constraint with further ones."""
    return tuple((*each, *added) for each, added in zip(strokes, more, strict=True))


#: Points nearer to a plane or line than this fraction of the extent are drawn in it: measured
#: bodies are flat only up to their last decimals.
_FLAT = 2e-3
#: Points nearer to each other than this fraction of their coordinates are one.
_SAME = 1e-9


def convex_hull(points: Array) -> tuple[Array, ...]:
    """Return the faces of the convex hull of a few points, each of shape (k, 3).

    Points in one plane give one polygon, points on one line its two ends, and one point (or
    none) no face at all. Every triple of points is tried as a face, which for the dozen points
    of a body is quicker than being clever.
    """
    if not len(points):
        return ()
    offsets = points - points.mean(axis=0)
    extent = np.abs(offsets).max()
    _, singular, axes = np.linalg.svd(offsets, full_matrices=True)
    if extent <= _SAME * np.abs(points).max():
        return ()
    dimension = int((singular > _FLAT * singular[0]).sum())
    if dimension == 1:
        along = offsets @ definite_sign(axes[0])
        return (points[[along.argmin(), along.argmax()]],)
    if dimension == 2:
        return (_polygon(points, definite_sign(axes[2])),)
    faces: dict[frozenset[int], Array] = {}
    for triple in combinations(range(len(points)), 3):
        a, b, c = points[list(triple)]
        normal = np.cross(b - a, c - a)
        norm = np.linalg.norm(normal)
        if norm <= _FLAT * extent**2:
            continue  # a sliver is no face
        heights = (points - a) @ (normal / norm)
        flat = np.abs(heights) <= _FLAT * extent
        if (heights[~flat] > 0).all() or (heights[~flat] < 0).all():
            inside = frozenset(np.flatnonzero(flat).tolist())
            faces.setdefault(inside, _polygon(points[flat], normal / norm))
    return tuple(faces.values())


def _polygon(points: Array, normal: Array) -> Array:
    """Return the corners, in order, of the convex hull of points in a plane."""
    first = np.eye(3)[np.abs(normal).argmin()]
    first = np.cross(normal, first)
    first /= np.linalg.norm(first)
    flat = (points - points.mean(axis=0)) @ np.stack((first, np.cross(normal, first)), axis=1)
    order = sorted(range(len(flat)), key=lambda k: (flat[k, 0], flat[k, 1]))
    size = np.abs(flat).max()

    def half(indices: list[int]) -> list[int]:
        # Andrew's monotone chain.
        chain: list[int] = []
        for k in indices:
            while len(chain) > 1 and _turn(flat[chain[-2]], flat[chain[-1]], flat[k]) <= (
                _SAME * size**2
            ):
                chain.pop()
            chain.append(k)
        return chain[:-1]

    return points[half(order) + half(order[::-1])]


def _turn(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


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

    Feet are in the frame of the body, shape (n, 3). Where one is inside, both ends of the stroke
    are the foot; if all are, there is no stroke.
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
    ends: ConstraintEnds
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
            ends = connection(kind, p, w, x, v) if kind.is_distance else ConstraintEnds(p, x, w, v)
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
                    self.to_platform(other.ends.platform) if platform else other.ends.base
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


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses to show, before anything is drawn."""

    #: As in `SceneSeries`, like the note.
    title: str
    item: str
    #: Shapes (n, 3, 3) and (n, 3), real.
    R: Array
    T: Array
    #: Further numbers or words about each pose.
    facts: Mapping[str, list[Any]] = field(default_factory=dict)
    #: What moves the platform, its name and values; None for modes.
    parameter: tuple[str, Array] | None = None
    #: Condition numbers where they are known, shape (n,).
    conditions: Array | None = None
    note: str = ""
    #: Names of coordinates that move (`gspcli.geometry.coordinates`), c of them, and where they are
    #: at each pose, shape (n, c).
    coordinates: tuple[str, ...] = ()
    places: Array = field(default_factory=lambda: np.zeros((0, 0)))


def names_of(constraints: Sequence[Constraint]) -> list[tuple[str, str]]:
    """Return the names of both primitives; those without a name get letter and number."""
    return [
        (
            row.platform_name or f"{row.platform.primitive.value}{i}",
            row.base_name or f"{row.base.primitive.value.lower()}{i}",
        )
        for i, row in enumerate(constraints, start=1)
    ]


def series_of(
    arrangement: Arrangement, poses: Poses, strokes: Sequence[tuple[Stroke, ...]], labels: Array
) -> SceneSeries:
    """Return poses as they are shown."""
    R, T, conditions = poses.R, poses.T, poses.conditions
    values = np.asarray(measured(arrangement, R, T).real).copy()
    values[:, arrangement.distances] = np.abs(values[:, arrangement.distances])
    values[:, arrangement.angles] /= arrangement.in_radians
    facts = dict(poses.facts)
    if poses.parameter is not None and any(kind.has_sides for kind in arrangement.kinds):
        sides = sides_of(arrangement, R, T)
        facts["sides"] = [
            "".join({1: "+", -1: "−", 0: ""}[s] for s in row) for row in sides.tolist()
        ]
    if conditions is None:
        conditions = condition_numbers(arrangement, R, T)
    return SceneSeries(
        title=poses.title,
        item=poses.item,
        R=R,
        T=T,
        quaternions=quaternion_from_rotation(R),
        measured=values,
        conditions=conditions,
        strokes=tuple(strokes),
        labels=labels,
        facts=facts,
        parameter=poses.parameter,
        note=poses.note,
    )


def moving_series(instance: Instance, poses: Poses, size: float) -> SceneSeries:
    """Return poses at which primitives are elsewhere in their bodies; lines and planes as needed.

    Raises
    ------
    ArgumentError
        If a coordinate is none of the instance.
    """
    chosen = choose(instance, poses.coordinates)
    names = names_of(instance.constraints)
    parts: list[SceneSeries] = []
    for k, place in enumerate(poses.places):
        there = moved(instance, chosen, place)
        arrangement = Arrangement.of(there)
        one = replace(
            poses,
            R=poses.R[k : k + 1],
            T=poses.T[k : k + 1],
            facts={},
            conditions=None if poses.conditions is None else poses.conditions[k : k + 1],
        )
        stage = Stage(arrangement, names, one.R, one.T, size)
        platform, base = (
            stage.body(name, [getattr(row, name) for row in there.constraints]) for name in BODIES
        )
        shown = series_of(arrangement, one, *stage.drawn(platform, base))
        parts.append(replace(shown, bodies={"platform": [platform], "base": [base]}))
    return _joined(poses, parts, {one.body for one in chosen})


def _joined(poses: Poses, parts: Sequence[SceneSeries], moving: set[str]) -> SceneSeries:
    """Return the series of single poses as one, with the bodies that move."""
    facts = {**poses.facts}
    if parts and "sides" in parts[0].facts:
        facts["sides"] = [part.facts["sides"][0] for part in parts]
    bodies: dict[str, list[DrawnBody]] = {
        name: [part.bodies[name][0] for part in parts] for name in sorted(moving)
    }
    every = zip(*(part.strokes for part in parts), strict=True)
    return replace(
        parts[0],
        R=poses.R,
        T=poses.T,
        quaternions=quaternion_from_rotation(poses.R),
        measured=np.concatenate([part.measured for part in parts]),
        conditions=np.concatenate([part.conditions for part in parts]),
        strokes=tuple(
            tuple(
                Stroke(same[0].style, np.concatenate([stroke.points for stroke in same]))
                for same in zip(*each, strict=True)
            )
            for each in every
        ),
        labels=np.concatenate([part.labels for part in parts]),
        facts=facts,
        bodies=bodies,
    )


#: This many of the motions that were found are shown; often they are parts of one.
_MOTIONS = 8
#: Of more points only those farthest in this many directions are drawn: a hull of all takes long.
_CORNERS = 40


def drawn_diameters(instance: Instance) -> dict[int, float]:
    """Return the stated diameters of legs that are not zero, by the index of the constraint."""
    if instance.shapes is None:
        return {}
    legs = [k for k, row in enumerate(instance.constraints) if row.kind is DPP]
    stated = [one.value for one in instance.shapes.diameters]
    every = stated * len(legs) if len(stated) == 1 else stated
    return {k: diameter for k, diameter in zip(legs, every, strict=True) if diameter > 0}


def drawn_shells(instance: Instance) -> dict[str, tuple[Array, ...]]:
    """Return the faces of the stated outlines by the name of the body, in its frame."""
    found = {}
    for name in ("platform", "base"):
        stated = () if instance.shapes is None else getattr(instance.shapes, name)
        if stated:
            points = np.array([[x.value for x in point] for point in stated])
            faces = tuple(face for face in convex_hull(_corners(points)) if len(face) > 2)
            if faces:
                found[name] = faces
    return found


def _corners(points: Array) -> Array:
    """Return the points that are farthest in directions all around, if there are many."""
    if len(points) <= _CORNERS:
        return points
    # Directions on a spiral, evenly over the sphere.
    k = np.arange(_CORNERS)
    height, angle = 1 - (2 * k + 1) / _CORNERS, k * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - height**2)
    directions = np.stack((across * np.cos(angle), across * np.sin(angle), height), axis=1)
    return np.asarray(points[np.unique((points @ directions.T).argmax(axis=0))])


def scene_of(
    result: SolveResult, tracks: Sequence[Poses] = (), *, only: int | None = None, summary: str = ""
) -> Scene:
    """Return the scene of a result: its assembly modes, its motions, and tracks of the platform.

    With the index of the `only` mode to be shown, lines and planes are drawn no larger than it
    needs. The summary is the text about the result; if empty, its account.
    """
    instance, arrangement = result.instance, result.arrangement
    shown = [_modes(result.drawn, only)]
    if only is None:
        shown += [*_motions(result), *(with_drives(instance, poses) for poses in tracks)]
    still = [poses for poses in shown if not poses.coordinates]
    R = np.concatenate([poses.R for poses in still])
    T = np.concatenate([poses.T for poses in still])
    names = names_of(instance.constraints)
    staged = Stage(arrangement, names, R, T)
    platform, base = (
        staged.body(name, [getattr(row, name) for row in instance.constraints]) for name in BODIES
    )
    strokes, labels = staged.drawn(platform, base)
    series, first = [], 0
    for poses in shown:
        drives = arm_strokes(instance, poses, staged.size)
        if poses.coordinates:
            moving = moving_series(instance, poses, staged.size)
            series.append(replace(moving, strokes=joined(moving.strokes, drives)))
            continue
        chosen = slice(first, first + len(poses.R))
        here = [tuple(Stroke(s.style, s.points[chosen]) for s in each) for each in strokes]
        here = [*joined(here, drives)]
        series.append(series_of(arrangement, poses, here, labels[chosen]))
        first = chosen.stop
    units, kind, diameters = instance.units, instance.type, drawn_diameters(instance)
    arms = {k: arm.diameter.value for k, arm in arms_of(instance).items()}
    return Scene(
        title=instance.name or kind.id,
        type_id=f"{kind.id} (type {kind.number}, {kind.platform_class.id})",
        summary=summary or f"{result.account_text}.",
        length_unit=units.length,
        angle_unit=units.angle.value,
        size=staged.size,
        platform=platform,
        base=base,
        bonds=tuple(
            DrawnConstraint(
                i + 1, row.kind, *names[i], row.value.value, diameters.get(i), arms.get(i) or None
            )
            for i, row in enumerate(instance.constraints)
        ),
        series=tuple(series),
        shells=drawn_shells(instance),
    )


def first_mode(result: SolveResult) -> int:
    """Return the index of the mode that is shown first, which is home; 0 if there is none."""
    return 0 if result.home is None else result.home.number - 1


def _modes(result: SolveResult, only: int | None) -> Poses:
    chosen = slice(result.counts.real) if only is None else slice(only, only + 1)
    real = result.solutions[chosen]
    length = result.arrangement.length
    facts: dict[str, list[Any]] = {"residual": [printed_residual(s.residual, length) for s in real]}
    if any(solution.sides for solution in real):
        signs = {"positive": "+", "negative": "−"}
        facts["sides"] = ["".join(signs[side] for side in s.sides.values()) for s in real]
    if any(solution.multiplicity > 1 for solution in real):
        facts["multiplicity"] = [solution.multiplicity for solution in real]
    facts["certified"] = ["yes" if solution.certified else "no" for solution in real]
    return Poses(
        "Assembly modes",
        "mode",
        result.R[chosen].real,
        result.T[chosen].real,
        facts=facts,
        conditions=result.conditions[chosen],
    )


def _motions(result: SolveResult) -> list[Poses]:
    real = [motion for motion in result.motions if motion.real and motion.dimension][:_MOTIONS]
    return [
        Poses(
            "Self-motion" + (f" {number}" if len(real) > 1 else ""),
            "pose",
            motion.R.real,
            motion.T.real,
            parameter=("step", np.arange(len(motion.R), dtype=float)),
            conditions=np.full(len(motion.R), np.inf),
            note="A sample of the motion that was found: all values are kept along it.",
        )
        for number, motion in enumerate(real, start=1)
    ]
