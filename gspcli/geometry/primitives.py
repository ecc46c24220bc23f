"""Points, lines and planes with exact coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Primitive
from gspcli.geometry.numbers import Number

Vector = tuple[Number, Number, Number]
Array = NDArray[np.float64]


def vector(x: object, y: object, z: object) -> Vector:
    """Return an exact vector from three numbers of any accepted kind."""
    return (Number.of(x), Number.of(y), Number.of(z))  # type: ignore[arg-type]


def as_array(exact: Vector) -> Array:
    """Return a vector in floating point, shape (3,)."""
    return np.array([number.value for number in exact])


def _unit(exact: Vector) -> Array:
    direction = as_array(exact)
    # Scaled first, so that the norm of a tiny or huge vector neither under- nor overflows.
    direction /= np.max(np.abs(direction))
    return np.asarray(direction / np.linalg.norm(direction))


@dataclass(frozen=True)
class Point:
    """A point.

    Attributes
    ----------
    position
        Coordinates in the frame of the body.
    """

    position: Vector
    primitive = Primitive.POINT

    @cached_property
    def point(self) -> Array:
        """The point, shape (3,), in length units."""
        return as_array(self.position)


@dataclass(frozen=True)
class Line:
    """An oriented line.

    Attributes
    ----------
    position
        A point on the line.
    direction
        A nonzero vector along it, of any length.
    """

    position: Vector
    direction: Vector
    primitive = Primitive.LINE

    @cached_property
    def point(self) -> Array:
        """A point on the line, shape (3,), in length units."""
        return as_array(self.position)

    @cached_property
    def unit(self) -> Array:
        """The unit direction, shape (3,)."""
        return _unit(self.direction)


@dataclass(frozen=True)
class Plane:
    """An oriented plane.

    Attributes
    ----------
    position
        A point in the plane.
    normal
        A nonzero normal of any length; it points to the positive side.
    """

    position: Vector
    normal: Vector
    primitive = Primitive.PLANE

    @cached_property
    def point(self) -> Array:
        """A point in the plane, shape (3,), in length units."""
        return as_array(self.position)

    @cached_property
    def unit(self) -> Array:
        """The unit normal, shape (3,)."""
        return _unit(self.normal)


Geometry = Point | Line | Plane
