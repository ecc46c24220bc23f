"""The strokes of each kind of constraint, at many poses at a time.

A distance is drawn as its shortest connection, with marks of its right angles. An angle is drawn as
an arc between the two directions, both moved to a point of the base's primitive; for AHL to the
platform's plane, in which the angle lies. The conventions are those of the paper's Section 4: an
AHH angle lies between one normal and the opposite of the other, an angle of a line and a plane is
measured from the line's projection.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.quaternions import cross, dot
from gspcli.geometry.tolerances import PARALLEL_SINE
from gspcli.pictures.scene import Stroke, StrokeStyle

Array = NDArray[np.float64]

_ARC_POINTS = 13


class Sizes(NamedTuple):
    """How large marks are drawn, in length units."""

    square: float
    ray: float
    arc: float


class StrokeEnds(NamedTuple):
    """Where a constraint meets its primitives at n poses, in the frame of the base.

    Attributes
    ----------
    platform, base
        The end of the shortest connection at each body, or the point at which an angle is
        drawn (both times), shape (n, 3).
    w, v
        Unit direction or normal of the primitive of the platform and of the base, (n, 3); zero
        for points.
    """

    platform: Array
    base: Array
    w: Array
    v: Array


def connection(kind: Kind, p: Array, w: Array, x: Array, v: Array) -> StrokeEnds:
    """Return the ends of the shortest connection of a distance.

    Parameters
    ----------
    kind
        The kind of the distance.
    p, w
        A point of the platform's primitive and its unit direction, shape (n, 3).
    x, v
        The same of the base's primitive.
    """
    r = p - x
    if kind is DPL:
        return StrokeEnds(p, x + _along(r, v), w, v)
    if kind is DLP:
        return StrokeEnds(p - _along(r, w), x, w, v)
    if kind is DPH:
        return StrokeEnds(p, p - _along(r, v), w, v)
    if kind is DHP:
        return StrokeEnds(x + _along(r, w), x, w, v)
    if kind is DLL:
        normal = cross(w, v)
        square = dot(normal, normal)[:, None]
        parallel = square < PARALLEL_SINE**2
        safe = np.where(parallel, 1.0, square)
        s = dot(cross(v, r), normal)[:, None] / safe
        t = dot(cross(w, r), normal)[:, None] / safe
        at_platform = np.where(parallel, p, p + s * w)
        at_base = np.where(parallel, x + _along(r, v), x + t * v)
        return StrokeEnds(at_platform, at_base, w, v)
    if kind is not DPP:
        raise ValueError(kind)
    return StrokeEnds(p, x, w, v)


def distance_strokes(kind: Kind, ends: StrokeEnds, sizes: Sizes) -> Iterator[Stroke]:
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


def angle_strokes(kind: Kind, ends: StrokeEnds, sizes: Sizes) -> Iterator[Stroke]:
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


def arms(kind: Kind, ends: StrokeEnds) -> tuple[Array, Array]:
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
