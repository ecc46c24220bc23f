"""First-order enclosures of vectors that depend on six parameters, over a set about zero.

A form stands for all functions that differ from ``value + linear . x`` by vectors of norm at most
`rest` for all x of the set: the unit ball, or the cube with sides of two. Errors of rounding are
part of the rest.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.quaternions import cross, dot
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: A bound of the relative rounding error of an operation on three numbers and their derivatives.
ROUNDING = 2.0**-48


@dataclass(frozen=True, eq=False)
class Form:
    """Enclosures of vectors with d components; a number is a vector with one.

    Attributes
    ----------
    value
        The value at zero, shape (..., d).
    linear
        The derivatives at zero, shape (..., d, 6).
    rest
        A bound of the norm of the remainder, shape (...).
    cube
        Whether x is in the cube, else in the ball.
    """

    value: Array
    linear: Array
    rest: Array
    cube: bool

    @classmethod
    def constant(cls, value: Array, cube: bool) -> Form:
        """Return a vector that does not depend on x, itself rounded."""
        value = np.asarray(value, float)
        rest = ROUNDING * np.linalg.norm(value, axis=-1)
        return cls(value, np.zeros((*value.shape, 6)), rest, cube)

    @property
    def size(self) -> Array:
        """The norm of the value, shape (...)."""
        return np.asarray(np.linalg.norm(self.value, axis=-1))

    @property
    def reach(self) -> Array:
        """A bound of the distance of the vector from its value, shape (...)."""
        return np.asarray(self._slope + self.rest)

    @property
    def _slope(self) -> Array:
        columns = np.linalg.norm(self.linear, axis=-2)
        return np.asarray(np.linalg.norm(columns, ord=1 if self.cube else 2, axis=-1))

    def loosened(self, more: Array) -> Form:
        """Return the form with a greater rest."""
        return Form(self.value, self.linear, self.rest + more, self.cube)

    def __add__(self, other: Form) -> Form:
        rest = self.rest + other.rest + ROUNDING * (self.size + other.size)
        return Form(self.value + other.value, self.linear + other.linear, rest, self.cube)

    def __sub__(self, other: Form) -> Form:
        return self + -1.0 * other

    def __rmul__(self, factor: float) -> Form:
        """Return the multiple by a power of two, or its negative: nothing is rounded."""
        return Form(factor * self.value, factor * self.linear, abs(factor) * self.rest, self.cube)

    def __mul__(self, other: Form) -> Form:
        """Return the product with a number or of a number."""
        return self._product(other, np.multiply)

    def cross(self, other: Form) -> Form:
        """Return the vector product."""
        return self._product(other, cross)

    def dot(self, other: Form) -> Form:
        """Return the scalar product."""
        return self._product(other, lambda a, b: dot(a, b)[..., None])

    def _product(self, other: Form, times: Callable[[Array, Array], Array]) -> Form:
        """Return a bilinear product whose norm is at most the product of the norms."""
        value = times(self.value, other.value)
        linear = np.stack(
            [
                times(self.value, other.linear[..., i]) + times(self.linear[..., i], other.value)
                for i in range(6)
            ],
            axis=-1,
        )
        a, b, da, db = self.size, other.size, self.reach, other.reach
        rest = a * other.rest + self.rest * b + da * db + ROUNDING * (a + da) * (b + db)
        return Form(value, linear, rest, self.cube)
