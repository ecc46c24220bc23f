"""What the constraints measure at a pose, how far that is from their values, and how it moves.

The quantities are those of the paper's Section 4, in floating point and also at complex poses:
a distance is the complex square root of the complex square. A pose may be anything in leading
batch axes; the last axis of results runs over the constraints.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import AHH, ALL, DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.poses import Field, apply, cross, dot
from gspcli.geometry.primitives import Geometry, Point

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_SIGNS = {Side.POSITIVE: 1, Side.NEGATIVE: -1, Side.BOTH: 0}
#: Lines that meet at a smaller angle than this (radians) are measured as parallel ones.
_PARALLEL = 1e-9


class _Layout(NamedTuple):
    """What follows from the kinds alone; read-only arrays."""

    distances: Index
    angles: Index
    sided: NDArray[np.bool_]
    """Which constraints have sides, shape (n,)."""
    cosine: NDArray[np.bool_]
    """Of which angles the cosine is the value of ``R u . v``, up to sign."""
    sign: Array
    """That sign, for each angle."""


@cache
def _layout(kinds: tuple[Kind, ...]) -> _Layout:
    angles = [kind for kind in kinds if not kind.is_distance]
    layout = _Layout(
        distances=np.array([i for i, kind in enumerate(kinds) if kind.is_distance], int),
        angles=np.array([i for i, kind in enumerate(kinds) if not kind.is_distance], int),
        sided=np.array([kind.has_sides for kind in kinds], bool),
        cosine=np.array([kind in (ALL, AHH) for kind in angles], bool),
        sign=np.array([-1.0 if kind is AHH else 1.0 for kind in angles], float),
    )
    for part in layout:
        part.setflags(write=False)
    return layout


@dataclass(frozen=True, eq=False)
class Arrangement:
    """The numbers of an instance in floating point.

    Attributes
    ----------
    kinds
        The kinds of the n constraints, in the order of the instance.
    y, x
        A point of each platform and of each base primitive, shape (n, 3), length units.
    u, v
        Unit direction or normal of each platform and of each base primitive, shape (n, 3);
        zero for points.
    values
        The distances and angles, shape (n,), in the units of the instance.
    sides
        The sides asked for: 1, -1 or, for both, 0; shape (n,).
    in_radians
        The angle unit in radians.
    """

    kinds: tuple[Kind, ...]
    y: Array
    x: Array
    u: Array
    v: Array
    values: Array
    sides: NDArray[np.int64]
    in_radians: float

    @classmethod
    def of(cls, instance: Instance) -> Arrangement:
        """Return the numbers of an instance."""
        rows = instance.constraints
        return cls(
            kinds=tuple(row.kind for row in rows),
            y=np.array([row.platform.point for row in rows]),
            x=np.array([row.base.point for row in rows]),
            u=np.array([_direction(row.platform) for row in rows]),
            v=np.array([_direction(row.base) for row in rows]),
            values=np.array([row.value.value for row in rows]),
            sides=np.array([_SIGNS[row.side] for row in rows]),
            in_radians=instance.units.angle.in_radians,
        )

    def with_values(self, values: Array) -> Arrangement:
        """Return the same geometry with other values, shape (n,)."""
        return replace(self, values=values)

    @cached_property
    def signs(self) -> Index:
        """The sides to look on: as `sides`, but a distance of zero has only one, shape (n,)."""
        return np.where(_layout(self.kinds).sided & (self.values == 0), 1, self.sides)

    @property
    def distances(self) -> Index:
        """Indices of the distance constraints."""
        return _layout(self.kinds).distances

    @property
    def angles(self) -> Index:
        """Indices of the angle constraints."""
        return _layout(self.kinds).angles

    @cached_property
    def targets(self) -> Array:
        """The values with angles in radians, shape (n,)."""
        targets = self.values.copy()
        targets[self.angles] *= self.in_radians
        return targets

    def cosines(self, values: Array) -> Array:
        """Return the values of ``R u . v`` that angles ask for (Section 4).

        Parameters
        ----------
        values
            Values of all constraints, shape (..., n), in the units of the instance. The
            result runs over `angles`.
        """
        layout = _layout(self.kinds)
        values = values[..., layout.angles] * self.in_radians
        return layout.sign * np.where(layout.cosine, np.cos(values), np.sin(values))

    @cached_property
    def _points(self) -> Array:
        """The points of the distance constraints of the platform and of the base, (2, d, 3)."""
        return np.array((self.y[self.distances], self.x[self.distances]))

    @cached_property
    def _centres(self) -> Array:
        """The means of these points, shape (2, 3)."""
        return np.asarray(self._points.sum(axis=1) / self._points.shape[1])

    @property
    def platform_centre(self) -> Array:
        """Mean of the platform points of the distance constraints, shape (3,)."""
        return np.asarray(self._centres[0])

    @property
    def base_centre(self) -> Array:
        """Mean of the base points of the distance constraints, shape (3,)."""
        return np.asarray(self._centres[1])

    @cached_property
    def extent(self) -> float:
        """The largest distance of a point from the centre of its body, of distances only."""
        offsets = self._points - self._centres[:, None]
        return math.sqrt((offsets * offsets).sum(axis=2).max())

    @cached_property
    def length(self) -> float:
        """A typical length: the largest of `extent` and the distances, or one if all vanish."""
        return self.length_with(self.values)

    def length_with(self, values: Array) -> float:
        """Return the typical length with other values, shape (..., n)."""
        return max(self.extent, float(abs(values[..., self.distances]).max())) or 1.0

    @cached_property
    def normalised(self) -> Arrangement:
        """The same with lengths of order one, and frames at the centres of the points.

        `restored` takes its translations back.
        """
        return self.in_units_of(self.length)

    def in_units_of(self, length: float) -> Arrangement:
        """Return the same in another unit of length, frames at the centres of the points."""
        values = self.values.copy()
        values[self.distances] /= length
        return replace(
            self,
            y=(self.y - self.platform_centre) / length,
            x=(self.x - self.base_centre) / length,
            values=values,
        )

    def restored(self, R: Field, T: Field, length: float | None = None) -> Field:
        """Return translations of `in_units_of` (`normalised` if None) in the given frames."""
        unit = self.length if length is None else length
        return unit * T + self.base_centre - apply(R, self.platform_centre)


def _direction(geometry: Geometry) -> Array | tuple[float, ...]:
    return (0.0, 0.0, 0.0) if isinstance(geometry, Point) else geometry.unit


def _select(arrangement: Arrangement, *kinds: Kind) -> list[int]:
    return [i for i, kind in enumerate(arrangement.kinds) if kind in kinds]


def _root(square: Field) -> Field:
    """Return a square root, real for real squares (rounding may make those negative)."""
    root: Field = np.sqrt(square if np.iscomplexobj(square) else np.maximum(square, 0.0))
    return root


def _perpendicular(r: Field, w: Field) -> Field:
    """Return the part of r perpendicular to the unit vector w."""
    across: Field = r - dot(r, w)[..., None] * w
    return across


def measured(arrangement: Arrangement, R: Field, T: Field) -> Field:
    """Return what each constraint measures, ``(..., 3, 3), (..., 3) -> (..., n)``.

    Distances to planes are signed by the normal; line-line distances are signed by the
    orientation of the lines; angles are in radians. A complex distance is one of two square
    roots, a complex angle one branch of the inverse function.
    """
    r, w = placed(arrangement, R, T)
    v = arrangement.v
    values = np.zeros(r.shape[:-1], dtype=np.result_type(R, T))
    for kind in set(arrangement.kinds):
        k = _select(arrangement, kind)
        r_k, w_k, v_k = r[..., k, :], w[..., k, :], v[k]
        if kind is DPP:
            value = _root(dot(r_k, r_k))
        elif kind is DPL:
            across = _perpendicular(r_k, v_k)
            value = _root(dot(across, across))
        elif kind is DLP:
            across = _perpendicular(r_k, w_k)
            value = _root(dot(across, across))
        elif kind is DPH:
            value = dot(r_k, v_k)
        elif kind is DHP:
            value = -dot(r_k, w_k)
        elif kind is DLL:
            value = _line_distance(r_k, w_k, v_k)
        else:
            value = _angle(kind, w_k, v_k)
        values[..., k] = value
    return values


def placed(arrangement: Arrangement, R: Field, T: Field) -> tuple[Field, Field]:
    """Return ``r = R y + T - x`` and ``w = R u`` of each constraint, ``(..., n, 3)``."""
    turned = np.swapaxes(R, -1, -2)
    return arrangement.y @ turned + T[..., None, :] - arrangement.x, arrangement.u @ turned


def _line_distance(r: Field, w: Field, v: Field) -> Field:
    normal = cross(w, np.broadcast_to(v, w.shape))
    square = dot(normal, normal)
    parallel = np.abs(square) < _PARALLEL**2
    across = _perpendicular(r, v)
    skew = dot(r, normal) / np.sqrt(np.where(parallel, 1.0, square))
    return np.where(parallel, _root(dot(across, across)), skew)


def _angle(kind: Kind, w: Field, v: Field) -> Field:
    """Return the angle of directions by half angles, exact also near 0 and 180 degrees."""
    w = -w if kind is AHH else w
    near, far = w - v, w + v
    sine, cosine = _root(dot(near, near)), _root(dot(far, far))
    if np.iscomplexobj(sine):
        # arctan of the smaller quotient; its two forms differ by a quarter turn.
        small = np.abs(sine) <= np.abs(cosine)
        a, b = np.where(small, sine, cosine), np.where(small, cosine, sine)
        half = np.arctan(a / b)
        half = np.where(small, half, np.pi / 2 - half)
    else:
        half = np.arctan2(sine, cosine)
    return 2 * half if kind in (ALL, AHH) else np.pi / 2 - 2 * half


def residuals(arrangement: Arrangement, R: Field, T: Field) -> Array:
    """Return how far each constraint is from its value, in the units of the instance.

    Measured on the constraint as stated, ``(..., 3, 3), (..., 3) -> (..., n)``: the distance
    or angle itself, not its square or cosine. Where the sign of a measured distance means
    nothing (or both sides are allowed) the nearer sign counts.
    """
    values = measured(arrangement, R, T)
    targets = arrangement.targets
    difference = np.abs(values - targets)
    free = np.array([kind.is_distance for kind in arrangement.kinds]) & (arrangement.signs == 0)
    opposite = np.where(free, np.abs(values + targets), np.inf)
    signed = np.abs(values - np.where(arrangement.signs < 0, -targets, targets))
    result = np.where(free, np.minimum(difference, opposite), signed)
    result[..., arrangement.angles] /= arrangement.in_radians
    return np.asarray(result)


def sides_of(arrangement: Arrangement, R: Field, T: Field) -> NDArray[np.int64]:
    """Return on which side each DPH and DHP point lies: 1, -1, or 0 for other kinds."""
    values = measured(arrangement, R, T).real
    sided = _layout(arrangement.kinds).sided
    sign = np.where(values < 0, -1, 1)
    return np.where(sided, np.where(arrangement.signs == 0, sign, arrangement.signs), 0)


def jacobian(arrangement: Arrangement, R: Field, T: Field) -> Field:
    """Return the derivatives of `measured` with respect to a twist, ``(..., n, 6)``.

    The twist (omega, tau) moves the pose to ``exp([s omega]x) R`` and ``T + s tau``: a
    rotation in the axes of the base about the origin of the platform, and a translation. At a
    distance or sine of zero the measured value has no derivative, and neither has the row.
    """
    r, w = placed(arrangement, R, T)
    v = arrangement.v
    turned = r - T[..., None, :] + arrangement.x
    rows = np.zeros((*r.shape[:-1], 6), dtype=np.result_type(R, T))
    for kind in set(arrangement.kinds):
        k = _select(arrangement, kind)
        r_k, w_k, y_k = r[..., k, :], w[..., k, :], turned[..., k, :]
        v_k = np.broadcast_to(v[k], w_k.shape)
        if kind.is_distance:
            force, moment = _distance_gradient(kind, r_k, w_k, v_k)
            rows[..., k, :3] = cross(y_k, force) + moment
            rows[..., k, 3:] = force
        else:
            rows[..., k, :3] = _angle_gradient(kind, w_k, v_k)
    return rows


def _distance_gradient(kind: Kind, r: Field, w: Field, v: Field) -> tuple[Field, Field]:
    """Return the derivative with respect to r, and that with respect to turning w."""
    if kind is DPP:
        return r / _root(dot(r, r))[..., None], np.zeros_like(r)
    if kind is DPL:
        across = _perpendicular(r, v)
        return across / _root(dot(across, across))[..., None], np.zeros_like(r)
    if kind is DLP:
        across = _perpendicular(r, w)
        distance = _root(dot(across, across))[..., None]
        return across / distance, -dot(r, w)[..., None] / distance * cross(w, r)
    if kind is DPH:
        return v, np.zeros_like(r)
    if kind is DHP:
        return -w, -cross(w, r)
    normal = cross(w, v)
    square = dot(normal, normal)[..., None]
    parallel = np.abs(square) < _PARALLEL**2
    length = np.sqrt(np.where(parallel, 1.0, square))
    n = normal / length
    g = (r - dot(r, n)[..., None] * n) / length
    across = _perpendicular(r, v)
    distance = _root(dot(across, across))[..., None]
    along = across / np.where(distance == 0, 1.0, distance)
    force = np.where(parallel, along, n)
    return force, np.where(parallel, 0.0, cross(w, cross(v, g)))


def _angle_gradient(kind: Kind, w: Field, v: Field) -> Field:
    # The cosine of a line-plane angle is the sine of the angle of the directions.
    turn = cross(w, v)
    return (-turn if kind is ALL else turn) / _root(dot(turn, turn))[..., None]


def condition_numbers(arrangement: Arrangement, R: Field, T: Field) -> Array:
    """Return the condition number of each pose, free of units, ``(..., 3, 3) -> (...)``.

    It is the ratio of the largest to the smallest singular value of the 6x6 Jacobian matrix
    whose twists turn about the centre of the platform points, whose turning columns are
    divided by the typical length of the arrangement, and whose rows are scaled to norm one. It
    depends neither on frames nor on units, and is infinite at a singular pose.
    """
    # A measure without a derivative (parallel lines, distance or angle zero) is not finite here.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rows = jacobian(arrangement, R, T)
        # About the centre c of the platform: T + s (omega x R c moved back) leaves R c + T alone.
        offset = apply(R, arrangement.platform_centre)[..., None, :]
        rows[..., :3] -= cross(np.broadcast_to(offset, rows[..., 3:].shape), rows[..., 3:])
        rows[..., :3] /= arrangement.length
        norms = np.linalg.norm(rows, axis=-1, keepdims=True)
        defined = np.isfinite(norms).all(axis=(-1, -2)) & (norms > 0).all(axis=(-1, -2))
        rows = np.where(defined[..., None, None], rows / np.where(norms > 0, norms, 1.0), 0.0)
        values = np.linalg.svd(rows, compute_uv=False)
        condition = values[..., 0] / values[..., -1]
    return np.where(defined, condition, np.inf)
