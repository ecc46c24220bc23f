"""The one description of a picture: two bodies, six constraints, and the poses to show.

Everything is in the frame and the length unit of the base, except the outlines of the platform,
which are in its own frame and move with the pose. The page and the drawings for papers show the
same scenes; neither computes any geometry of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field
from enum import Enum
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli import __version__
from gspcli.catalogue.kinds import Kind, Primitive
from gspcli.geometry.measurement import printed_conditions
from gspcli.records import dataclass

Array = NDArray[np.float64]
SCHEMA = "gsp.scene/1"

#: Coordinates in a page are rounded to this fraction of `Scene.size`: far below a pixel.
_RESOLUTION = 1e-4


class StrokeStyle(Enum):
    """What a stroke of a constraint means."""

    LEG = "leg"
    """The distance itself: between two points."""
    PERPENDICULAR = "perpendicular"
    """The distance itself: at right angles to a line or plane, or to two lines."""
    ARC = "arc"
    """The angle itself."""
    RAY = "ray"
    """A direction moved to where the angle is drawn."""
    SQUARE = "square"
    """The mark of a right angle."""
    GUIDE = "guide"
    """The way from the drawn part of a line or plane to a point of it outside."""


@dataclass(frozen=True, eq=False)
class DrawnPrimitive:
    """A primitive of a body as it is drawn."""

    #: Its name and sort.
    name: str
    primitive: Primitive
    #: The point (1, 3), the ends of the part of the line that is drawn (2, 3), or the corners of
    #: that part of the plane (4, 3).
    outline: Array
    #: Unit direction of the line or normal of the plane, shape (3,); None for a point.
    direction: Array | None

    @property
    def centre(self) -> Array:
        """The middle of what is drawn, shape (3,)."""
        return np.asarray(self.outline.mean(axis=0))


@dataclass(frozen=True, eq=False)
class DrawnBody:
    """The base or the platform."""

    #: ``base`` or ``platform``.
    name: str
    #: Its primitives.
    elements: tuple[DrawnPrimitive, ...]
    #: The convex hull of the middles of its points and lines: polygons, each of shape (k, 3). One
    #: polygon if they are in a plane, one of two corners if they are on a line, none if they are in
    #: one point.
    faces: tuple[Array, ...]


@dataclass(frozen=True)
class DrawnConstraint:
    """A constraint as the labels name it."""

    #: From 1.
    number: int
    #: What is measured.
    kind: Kind
    #: Between which primitives.
    platform_name: str
    base_name: str
    #: The value asked for, in the units of the scene.
    value: float
    #: Of a leg whose file states it; else None.
    diameter: float | None = None
    #: The diameter of the arm of its crank; else None.
    arm: float | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the constraint as plain data."""
        stated = {"diameter": self.diameter, "arm": self.arm}
        thick = {key: value for key, value in stated.items() if value is not None}
        return {
            "number": self.number,
            "kind": self.kind.name,
            "platform": self.platform_name,
            "base": self.base_name,
            "value": self.value,
            **thick,
        }


@dataclass(frozen=True, eq=False)
class Stroke:
    """A line drawn for a constraint at each of n poses: points of shape (n, k, 3)."""

    style: StrokeStyle
    points: Array


@dataclass(frozen=True, eq=False)
class SceneSeries:
    """Poses to look at one after the other: the assembly modes, or a motion."""

    #: What the poses are, such as ``Assembly modes``.
    title: str
    #: What one of them is called, such as ``mode``.
    item: str
    #: The poses, shapes (n, 3, 3), (n, 3), (n, 4).
    R: Array
    T: Array
    quaternions: Array
    #: What each constraint measures, in the units of the scene, shape (n, 6).
    measured: Array
    #: Condition number of each pose, shape (n,).
    conditions: Array
    #: For each constraint what is drawn for it.
    strokes: tuple[tuple[Stroke, ...], ...]
    #: Where the number of each constraint is written, shape (n, 6, 3).
    labels: Array
    #: Further numbers or words about each pose, by their name: lists of length n.
    facts: Mapping[str, list[Any]]
    #: The name and the values, shape (n,), of what moves the platform; None for modes.
    parameter: tuple[str, Array] | None = None
    #: What should be known about the series, or empty.
    note: str = ""
    #: Where primitives move in their body: by the name of the body how it is at each pose.
    bodies: Mapping[str, Sequence[DrawnBody]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.R)


@dataclass(frozen=True, eq=False)
class Scene:
    """A platform to look at."""

    #: The name of the instance (or its type), and its type.
    title: str
    type_id: str
    #: What was found, in a sentence or two.
    summary: str
    #: The units of all numbers; angles of `DrawnConstraint.value` and `SceneSeries.measured` only.
    length_unit: str
    angle_unit: str
    #: The radius of base and platform together at a typical pose: the unit of all marks.
    size: float
    #: The bodies.
    platform: DrawnBody
    base: DrawnBody
    #: The constraints.
    bonds: tuple[DrawnConstraint, ...]
    #: What there is to show; the assembly modes come first.
    series: tuple[SceneSeries, ...]
    #: By the name of a body the faces of the outline that the file states, in its frame.
    shells: Mapping[str, tuple[Array, ...]] = field(default_factory=dict)

    @cached_property
    def decimals(self) -> int:
        """Decimals of drawn coordinates."""
        return max(0, -math.floor(math.log10(self.size * _RESOLUTION)))

    def unit(self, bond: DrawnConstraint) -> str:
        """Return the unit in which a constraint is measured."""
        return self.length_unit if bond.kind.is_distance else self.angle_unit

    def to_json(self) -> dict[str, Any]:
        """Return the scene as plain data of schema ``gsp.scene/1``."""
        shells = {
            name: [self._drawn(face) for face in faces] for name, faces in self.shells.items()
        }
        return {
            "schema": SCHEMA,
            "version": __version__,
            "title": self.title,
            "type": self.type_id,
            "units": {"length": self.length_unit, "angle": self.angle_unit},
            "size": self.size,
            "platform": self._body(self.platform),
            "base": self._body(self.base),
            "constraints": [bond.to_json() for bond in self.bonds],
            "series": [self._series(series) for series in self.series],
            **({"shells": shells} if shells else {}),
        }

    def _drawn(self, points: Array) -> Any:
        # Adding zero turns -0.0 into 0.0.
        return (points.round(self.decimals) + 0.0).tolist()

    def _body(self, body: DrawnBody) -> dict[str, Any]:
        return {
            "elements": [
                {
                    "name": element.name,
                    "primitive": element.primitive.value,
                    "outline": self._drawn(element.outline),
                    "direction": None
                    if element.direction is None
                    else element.direction.round(9).tolist(),
                }
                for element in body.elements
            ],
            "faces": [self._drawn(face) for face in body.faces],
        }

    def _series(self, series: SceneSeries) -> dict[str, Any]:
        parameter = None
        if series.parameter is not None:
            name, values = series.parameter
            parameter = {"name": name, "values": _numbers(values)}
        return {
            "title": series.title,
            "item": series.item,
            "note": series.note,
            "T": series.T.tolist(),
            "q": series.quaternions.tolist(),
            "measured": _numbers(series.measured),
            "condition": _numbers(printed_conditions(series.conditions)),
            "strokes": [
                [{"style": s.style.value, "points": self._drawn(s.points)} for s in strokes]
                for strokes in series.strokes
            ],
            "labels": self._drawn(series.labels),
            "facts": dict(series.facts),
            "parameter": parameter,
            "bodies": {
                name: [self._body(body) for body in bodies]
                for name, bodies in series.bodies.items()
            },
        }


def _numbers(values: Array) -> Any:
    """Return numbers that JSON can say: twelve digits, null for what is not finite."""
    if values.ndim > 1:
        return [_numbers(row) for row in values]
    return [float(f"{value:.12g}") if math.isfinite(value) else None for value in values]
