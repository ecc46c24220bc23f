"""Platforms in floating point: the primitives and the values of their constraints."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import Kind, Primitive
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.primitives import Point, unit_vectors
from gspcli.geometry.quaternions import Field, apply, pose_from_study
from gspcli.records import dataclass

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_SIGNS = {Side.POSITIVE: 1, Side.NEGATIVE: -1, Side.BOTH: 0}
#: A point this many times farther away than the others does not count in the centre of a body.
_FAR = 100.0


def angle_of(kind: Kind, cosine: float) -> float:
    """Return the angle of a kind, in radians, that asks for a value of ``R u . v``."""
    law = kind.law
    return math.acos(law.sign * cosine) if law.is_cosine else math.asin(law.sign * cosine)


class Placed(NamedTuple):
    """The vectors of the constraints at a pose, in the axes of the base, each (..., n, 3)."""

    r: Field
    """From the base's point to the platform's, ``R y + T - x``."""
    w: Field
    """The direction or normal of the platform's primitive, ``R u``."""
    arm: Field
    """From the origin of the platform to its point, ``R y``."""


@dataclass(frozen=True, eq=False)
class Bodies:
    """The primitives of n constraints on both bodies, for one platform or a batch of platforms."""

    #: The kinds of the n constraints.
    kinds: tuple[Kind, ...]
    #: A point of each platform and of each base primitive, shape (..., n, 3), length units.
    y: Array
    x: Array
    #: Unit direction or normal of each platform and of each base primitive, shape (..., n, 3); zero
    #: for points.
    u: Array
    v: Array

    def placed(self, R: Field, T: Field) -> Placed:
        """Return the vectors of the constraints at poses, ``(..., 3, 3), (..., 3)``."""
        turned = np.swapaxes(R, -1, -2)
        arm = self.y @ turned
        return Placed(arm + T[..., None, :] - self.x, self.u @ turned, arm)


class _Layout(NamedTuple):
    """Read-only arrays that depend on the kinds only."""

    distances: Index
    angles: Index
    sided: NDArray[np.bool_]
    """Which constraints have sides, shape (n,)."""
    directed: NDArray[np.bool_]
    """Which primitives of the platform and of the base are no points, shape (2, n)."""
    cosine: NDArray[np.bool_]
    """Of which angles the cosine is the value of ``R u . v``, up to sign."""
    sign: Array
    """That sign, for each angle."""


@cache
def _layout(kinds: tuple[Kind, ...]) -> _Layout:
    angles = [kind.law for kind in kinds if not kind.is_distance]
    parts = [*[kind.platform for kind in kinds], *[kind.base for kind in kinds]]
    layout = _Layout(
        distances=np.array([i for i, kind in enumerate(kinds) if kind.is_distance], int),
        angles=np.array([i for i, kind in enumerate(kinds) if not kind.is_distance], int),
        sided=np.array([kind.has_sides for kind in kinds], bool),
        directed=np.array([part is not Primitive.POINT for part in parts], bool).reshape(2, -1),
        cosine=np.array([law.is_cosine for law in angles], bool),
        sign=np.array([law.sign for law in angles], float),
    )
    for part in layout:
        part.setflags(write=False)
    return layout


@dataclass(frozen=True, eq=False)
class Arrangement(Bodies):
    """The numbers of an instance in floating point.

    Attributes
    ----------
    kinds, y, x, u, v
        See `Bodies`; in the order of the instance, without batch axes.
    values
        The distances and angles, shape (n,), in the units of the instance.
    sides
        The sides asked for: 1, -1 or, for both, 0; shape (n,).
    in_radians
        The angle unit in radians.
    """

    values: Array
    sides: NDArray[np.int64]
    in_radians: float

    @classmethod
    def of(cls, instance: Instance) -> Arrangement:
        """Return the numbers of an instance."""
        rows = instance.constraints
        kinds = tuple([row.kind for row in rows])
        points = np.array(instance.coordinates).reshape(2, -1, 3)
        directions = np.zeros_like(points)
        given = [body.vector for body in instance.primitives if not isinstance(body, Point)]
        if given:
            directions[_layout(kinds).directed] = unit_vectors(given)
        return cls(
            kinds=kinds,
            y=points[0],
            x=points[1],
            u=directions[0],
            v=directions[1],
            values=np.array([row.value.value for row in rows]),
            sides=np.array([_SIGNS[row.side] for row in rows]),
            in_radians=instance.units.angle.in_radians,
        )

    def with_points(self, y: Array, x: Array) -> Arrangement:
        """Return the platform with its points elsewhere, for each pose of a batch.

        Its centres and its typical length stay those of the stated points.

        Parameters
        ----------
        y, x
            Points of the primitives, shapes (..., n, 3), with the leading axes of poses.
        """
        moved = replace(self, y=y, x=x)
        moved.__dict__["_centred"] = self._centred
        return moved

    def part(self, rows: slice) -> Arrangement:
        """Return the platform of some rows of a batch; itself if all rows have the same points."""
        return self if self.y.ndim == 2 else self.with_points(self.y[rows], self.x[rows])

    def with_values(self, values: Array) -> Arrangement:
        """Return the same geometry with other values, shape (n,)."""
        return replace(self, values=values)

    @cached_property
    def signs(self) -> Index:
        """The sides to solve for: as `sides`, but 1 for a distance of zero, shape (n,)."""
        return np.where(self.sided & (self.values == 0), 1, self.sides)

    @cached_property
    def _layout(self) -> _Layout:
        return _layout(self.kinds)

    @property
    def sided(self) -> NDArray[np.bool_]:
        """Which constraints have sides, shape (n,)."""
        return self._layout.sided

    @property
    def distances(self) -> Index:
        """Indices of the distance constraints."""
        return self._layout.distances

    @property
    def angles(self) -> Index:
        """Indices of the angle constraints."""
        return self._layout.angles

    @cached_property
    def targets(self) -> Array:
        """The values with angles in radians, shape (n,)."""
        targets = self.values.copy()
        targets[..., self.angles] *= self.in_radians
        return targets

    def cosines(self, values: Array) -> Array:
        """Return the values of ``R u . v`` that angles ask for (Section 4).

        Parameters
        ----------
        values
            Values of all constraints, shape (..., n), in the units of the instance. The
            result runs over `angles`.
        """
        layout = self._layout
        values = values[..., layout.angles] * self.in_radians
        return layout.sign * np.where(layout.cosine, np.cos(values), np.sin(values))

    @cached_property
    def _points(self) -> Array:
        """The points of the distance constraints of the platform and of the base, (2, d, 3)."""
        return np.array((self.y[self.distances], self.x[self.distances]))

    @cached_property
    def _centred(self) -> tuple[Array, float]:
        """The means of these points without far ones, shape (2, 3), and `extent`."""
        return _kernel.centres(self._points, far=_FAR)

    @property
    def platform_centre(self) -> Array:
        """Mean of the platform points of the distance constraints, shape (3,).

        A point does not count if it is a hundred times farther from the others than they are from
        each other: coordinates about a mean that includes it would lose digits.
        """
        return np.asarray(self._centred[0][0])

    @property
    def base_centre(self) -> Array:
        """Mean of the base points of the distance constraints without far ones, shape (3,)."""
        return np.asarray(self._centred[0][1])

    @property
    def extent(self) -> float:
        """The largest distance of a point from the centre of its body, of distances only."""
        return self._centred[1]

    @cached_property
    def length(self) -> float:
        """A typical length: the largest of `extent` and the distances, or one if all vanish."""
        return self.length_with(self.values)

    def length_with(self, values: Array) -> float:
        """Return the typical length with other values, shape (..., n)."""
        return max(self.extent, float(abs(values[..., self.distances]).max())) or 1.0

    @cached_property
    def normalized(self) -> Arrangement:
        """The arrangement with lengths of order one and frames at the centres of the points.

        `restored` converts translations back to the given frames and unit.
        """
        return self.in_units_of(self.length)

    def in_units_of(self, length: float) -> Arrangement:
        """Return the arrangement in another unit of length, frames at the centres of the points."""
        values = self.values.copy()
        values[self.distances] /= length
        platform, base = self._centred[0]
        y, x = (self.y - platform) / length, (self.x - base) / length
        return Arrangement(self.kinds, y, x, self.u, self.v, values, self.sides, self.in_radians)

    def poses_of(self, points: Field) -> tuple[Field, Field]:
        """Return the poses R, T in the given frames of Study points (n, 8) of `normalized`."""
        R, T = pose_from_study(points[:, :4], points[:, 4:])
        return R, self.restored(R, T)

    def restored(self, R: Field, T: Field, length: float | None = None) -> Field:
        """Return translations of `in_units_of` (`normalized` if None) in the given frames."""
        unit = self.length if length is None else length
        return unit * T + self.base_centre - apply(R, self.platform_centre)
