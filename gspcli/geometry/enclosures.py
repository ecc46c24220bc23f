"""Proofs in doubles: vectors that depend on parameters, enclosed with all rounding.

An enclosure stands for all functions of u that differ from ``mid + lin . u`` by vectors of norm at
most `rad`, for all u of a set: the cube ``[-1, 1]^m`` or the unit ball. A number is a vector with
one component; without parameters (m = 0) an enclosure is a ball. Formulas are written once, as for
numbers, and nothing is added by hand.

Rounding is bounded here only, by three constants, with u = 2^-53. `ROUND`: a sum of at most 24
products of numbers that carry a rounding or two errs by at most 27 u times the sum of the moduli,
which is at most ``|a| |b|``. `OUT`: a size, or a radius, is made of nonnegative numbers by fewer
than 200 sums, products and roots, so that it errs by less than 2^-45 of itself. `TINY`: squares
below the normal range lose less than its square.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

ROUND = 2.0**-48
OUT = 1 + 2.0**-44
TINY = 2.0**-480


def above(bound: Any) -> Any:
    """Round up a bound, which is made of nonnegative numbers as `OUT` asks for."""
    return bound * OUT


def below(bound: Any) -> Any:
    """Round down a number, which is made of nonnegative numbers as `OUT` asks for."""
    return bound * (2 - OUT)


def roundings(count: float, scale: Any) -> Any:
    """Bound the errors of some sums of products, each as `ROUND` asks for.

    Parameters
    ----------
    count
        How many of them are added.
    scale
        At least the sum of the moduli of the products of each.
    """
    return count * ROUND * scale


def size(vectors: Array) -> Array:
    """Bound the norms of vectors from above, ``(..., d) -> (...)``."""
    if vectors.shape[-1] == 1:
        return np.asarray(np.abs(vectors[..., 0]))
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", vectors, vectors)) * OUT + TINY)


def _frobenius(matrices: Array) -> Array:
    return size(matrices.reshape(*matrices.shape[:-2], -1))


def operator_norm(matrices: Array) -> Array:
    """Bound the spectral norms of matrices from above, ``(..., k, d) -> (...)``."""
    moduli = np.abs(matrices)
    both = np.sqrt(moduli.sum(axis=-1).max(axis=-1) * moduli.sum(axis=-2).max(axis=-1)) * OUT
    return np.asarray(np.minimum(both, _frobenius(matrices)))


class Enclosure:
    """Vectors with d components."""

    __slots__ = ("cube", "lin", "mid", "rad")
    #: The middles, shape (..., d).
    mid: Array
    #: Bounds of the distances from ``mid + lin . u``, shape (...); several for each vector may be
    #: on axes before.
    rad: Array
    #: The linear parts, shape (..., d, m).
    lin: Array
    #: Whether u is in the cube, else in the unit ball.
    cube: bool

    def __init__(
        self, mid: ArrayLike, rad: ArrayLike = 0.0, lin: Array | None = None, *, cube: bool = True
    ) -> None:
        self.mid = np.asarray(mid, float)
        self.lin = np.zeros((*self.mid.shape, 0)) if lin is None else lin
        bound = np.asarray(rad, float)
        shape = np.broadcast_shapes(bound.shape, self.mid.shape[:-1])
        self.rad, self.cube = np.broadcast_to(bound, shape), cube

    @classmethod
    def rounded(cls, mid: ArrayLike, scale: ArrayLike = 0.0) -> Enclosure:
        """Return computed vectors that err by `ROUND` times their size, or a larger scale."""
        mid = np.asarray(mid, float)
        return cls(mid, ROUND * np.maximum(size(mid), scale))

    @classmethod
    def between(cls, low: Array, high: Array) -> Enclosure:
        """Return all numbers between two, which may err by `ROUND` of the larger, shape (...)."""
        rad = (high - low) / 2 + 3 * ROUND * np.maximum(np.abs(low), np.abs(high))
        return cls(((low + high) / 2)[..., None], rad * OUT)

    def widened(self, more: ArrayLike) -> Enclosure:
        """Return the enclosure of all vectors that are at most so far away."""
        return self._with(self.mid, self.lin, self.rad + np.asarray(more))

    def take(self, *index: object) -> Enclosure:
        """Return a part of the vectors."""
        lin = np.broadcast_to(self.lin, (*self.mid.shape, self.lin.shape[-1]))
        return Enclosure(self.mid[index], self.rad[index], lin[index], cube=self.cube)  # type: ignore[index]

    @property
    def is_ball(self) -> bool:
        """Whether there are no parameters."""
        return not self.lin.shape[-1]

    @property
    def slope(self) -> Array:
        """Bounds of ``|lin . u|``, shape (...)."""
        if self.is_ball:
            return np.zeros(self.mid.shape[:-1])
        columns = np.sqrt((self.lin**2).sum(axis=-2)) * OUT
        total = columns.sum(axis=-1) if self.cube else np.sqrt((columns**2).sum(axis=-1))
        return np.asarray(total * OUT + TINY)

    @property
    def reach(self) -> Array:
        """Bounds of the distance from `mid`, shape (...)."""
        if self.is_ball:
            return self.rad
        return np.asarray((self.slope + self.rad) * OUT)

    @property
    def most(self) -> Array:
        """Bounds of the norm from above, shape (...)."""
        return np.asarray((size(self.mid) + self.reach) * OUT)

    @property
    def least(self) -> Array:
        """Bounds of the norm from below, shape (...)."""
        inner = (size(self.mid) - 2 * TINY) * (2 - OUT**2)
        return np.maximum(inner - self.reach * OUT, 0.0)

    @property
    def ends(self) -> tuple[Array, Array]:
        """Bounds of a number (d = 1) from below and above, shape (...)."""
        room = (self.reach + ROUND * np.abs(self.mid[..., 0])) * OUT
        return self.mid[..., 0] - room, self.mid[..., 0] + room

    def _with(self, mid: Array, lin: Array, rad: Array) -> Enclosure:
        return Enclosure(mid, np.where(np.isfinite(rad), rad * OUT, np.inf), lin, cube=self.cube)

    def _like(self, other: Enclosure) -> tuple[Array, Array, bool]:
        """Return the linear parts of both with the same parameters, and whether in the cube."""
        a, b = self.lin, other.lin
        if not a.shape[-1]:
            return np.zeros((*self.mid.shape, b.shape[-1])), b, other.cube
        if not b.shape[-1]:
            return a, np.zeros((*other.mid.shape, a.shape[-1])), self.cube
        return a, b, self.cube

    def __neg__(self) -> Enclosure:
        return Enclosure(-self.mid, self.rad, -self.lin, cube=self.cube)

    def __add__(self, other: Enclosure) -> Enclosure:
        a, b, cube = self._like(other)
        rad = self.rad + other.rad + ROUND * (self.most + other.most)
        found = self._with(self.mid + other.mid, a + b, rad)
        found.cube = cube
        return found

    def __sub__(self, other: Enclosure) -> Enclosure:
        return self + -other

    def __mul__(self, other: Enclosure) -> Enclosure:
        """Return the product with a number or of a number."""
        return self._product(other, np.multiply)

    def __rmul__(self, factor: ArrayLike) -> Enclosure:
        """Return the product with exact numbers, shape (...) or one."""
        f = np.asarray(factor, float)[..., None]
        rad = np.abs(f[..., 0]) * (self.rad + ROUND * self.most)
        return self._with(f * self.mid, f[..., None] * self.lin, rad)

    def cross(self, other: Enclosure) -> Enclosure:
        """Return the vector product."""
        return self._product(other, _cross)

    def dot(self, other: Enclosure) -> Enclosure:
        """Return the scalar product, a number."""
        return self._product(other, lambda a, b: (a * b).sum(axis=-1, keepdims=True))

    def across(self, unit: Enclosure) -> Enclosure:
        """Return the part at right angles to vectors of norm one."""
        if not (self.is_ball and unit.is_ball):
            return self - unit * unit.dot(self)
        e = unit.mid
        mid = self.mid - e * (e * self.mid).sum(axis=-1, keepdims=True)
        # Projections shorten, and the norm of the difference of two is at most |e - e'|.
        rad = self.rad + unit.rad * size(self.mid) + ROUND * self.most
        return self._with(mid, np.zeros((*mid.shape, 0)), rad)

    def under(self, matrix: Array, of: ArrayLike | None = None) -> Enclosure:
        """Return exact matrices (..., k, d) times the vectors; `of` bounds their spectral norms."""
        of = operator_norm(matrix) if of is None else np.asarray(of)
        mid = (matrix @ self.mid[..., None])[..., 0]
        rad = of * self.rad + ROUND * _frobenius(matrix) * self.most
        return self._with(mid, matrix @ self.lin, rad)

    def quadric(self, matrix: Array, of: ArrayLike | None = None) -> Enclosure:
        """Return ``x . M x / 2`` for exact symmetric matrices, a number."""
        of = operator_norm(matrix) if of is None else np.asarray(of)
        gradient = (matrix @ self.mid[..., None])[..., 0]
        mid = (gradient * self.mid).sum(axis=-1, keepdims=True) / 2
        lin = np.einsum("...i,...im->...m", gradient, self.lin)[..., None, :]
        rad = size(gradient) * self.rad + of * self.reach**2 / 2
        return self._with(mid, lin, rad + ROUND * _frobenius(matrix) * self.most**2)

    def _product(self, other: Enclosure, times: Callable[[Array, Array], Array]) -> Enclosure:
        """Return a bilinear product whose norm is at most the product of the norms."""
        mid = times(self.mid, other.mid)
        p, q, cube = self._like(other)
        columns = [
            times(self.mid, q[..., i]) + times(p[..., i], other.mid) for i in range(p.shape[-1])
        ]
        lin = np.stack(columns, axis=-1) if columns else np.zeros((*mid.shape, 0))
        a, b, da, db = size(self.mid), size(other.mid), self.reach, other.reach
        rad = a * other.rad + self.rad * b + da * db + ROUND * (a + da) * (b + db)
        found = self._with(mid, lin, rad + TINY)
        found.cube = cube
        return found

    def _of(self, value: Array, slope: Array, bend: Array, error: float = 0.0) -> Enclosure:
        """Return a function of a number by its derivatives: the second one is bounded."""
        reach, factor = self.reach, slope[..., None]
        rad = np.abs(slope[..., 0]) * (self.rad + ROUND * reach) + bend * reach**2 / 2
        return self._with(value, factor * self.lin, rad + error + 4 * ROUND * np.abs(value[..., 0]))

    def inverse(self) -> Enclosure:
        """Return 1 / x; infinite radii where x may be zero."""
        f = 1 / self.mid
        return self._of(f, -(f**2), 2 / self.least**3)

    def sqrt(self) -> Enclosure:
        """Return the root; infinite radii where x may not be positive."""
        low = self.ends[0]
        root = np.sqrt(self.mid)
        bend = np.where(low > 0, 0.25 / np.where(low > 0, low, 1.0) ** 1.5, np.inf)
        return self._of(root, 0.5 / root, bend * OUT)

    def sin(self) -> Enclosure:
        """Return the sine."""
        return self._of(np.sin(self.mid), np.cos(self.mid), np.ones(self.rad.shape), ROUND)

    def cos(self) -> Enclosure:
        """Return the cosine."""
        return self._of(np.cos(self.mid), -np.sin(self.mid), np.ones(self.rad.shape), ROUND)

    def norm(self) -> Enclosure:
        """Return the norm.

        With n = |m|, ``|m + h|`` is at least ``n + m . h / n``, by Cauchy's inequality, and at most
        that and ``|h|^2 / (2 n)``, whose square is larger. It also differs from n by at most |h|.
        """
        n = np.sqrt((self.mid**2).sum(axis=-1, keepdims=True))
        lin = np.einsum("...i,...im->...m", self.mid / n, self.lin)[..., None, :]
        rad = self.rad
        if not self.is_ball:
            rad = rad + self.reach**2 / (2 * n[..., 0] * (2 - OUT))
        return self._with(n, lin, rad + 4 * ROUND * self.most)

    def unit(self) -> Enclosure:
        """Return x / |x|; infinite radii where x may be zero.

        ``|a / |a| - b / |b||`` is at most ``2 |a - b| / (|a| + |b|)``. The second derivative of
        x / |x| has the norm ``(4/3)^(1/2) / |x|^2``.
        """
        n = np.sqrt((self.mid**2).sum(axis=-1, keepdims=True))
        e, least, reach = self.mid / n, self.least, self.reach
        along = np.einsum("...i,...im->...m", e, self.lin)
        lin = (self.lin - e[..., None] * along[..., None, :]) / n[..., None]
        if not self.is_ball:
            rad = self.rad / (least + reach) + 0.58 * reach**2 / least**2
        else:
            rad = reach / (least + reach / 2)
        return self._with(e, lin, np.where(least > 0, rad + 4 * ROUND, np.inf))


def _cross(a: Array, b: Array) -> Array:
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    return np.stack((y * w - z * v, z * u - x * w, x * v - y * u), axis=-1)


def joined(*parts: Enclosure) -> Enclosure:
    """Return the vectors one after the other, as longer ones."""
    lin = np.concatenate([part.lin for part in parts], axis=-2)
    squares: Array = sum(part.rad**2 for part in parts)  # type: ignore[assignment]
    mid = np.concatenate([part.mid for part in parts], axis=-1)
    return Enclosure(mid, np.sqrt(squares) * OUT + TINY, lin, cube=parts[0].cube)


def singular_values(rows: Enclosure) -> tuple[Array, Array]:
    """Bound the least and the largest singular value of square matrices, given by rows.

    No singular value changes by more than the Frobenius norm of the change, by Weyl's inequality.
    LAPACK's err by a small multiple of n u times the largest (Anderson et al., LAPACK Users'
    Guide, 4.9).
    """
    values = np.linalg.svd(rows.mid, compute_uv=False)
    room = (size(rows.reach) + 16 * ROUND * values[..., 0]) * OUT
    return np.maximum(values[..., -1] - room, 0.0), values[..., 0] + room


def spectral_norm(matrices: Array) -> Array:
    """Bound the norms of symmetric matrices from above: eigenvalues as accurate as above."""
    values = np.abs(np.linalg.eigvalsh(matrices)).max(axis=-1)
    return np.asarray(values * (1 + 16 * ROUND) * OUT)


class Matrix:
    """Symmetric matrices within radii of middles, in the spectral norm."""

    __slots__ = ("mid", "rad", "top")
    #: The middles, shape (..., d, d), their radii, and bounds of their norms, shapes (...).
    mid: Array
    rad: Array
    top: Array

    def __init__(self, mid: Array, rad: Array, top: Array) -> None:
        self.mid, self.rad, self.top = mid, rad, top

    @classmethod
    def exact(cls, mid: Array, rad: ArrayLike = 0.0) -> Matrix:
        """Return the matrices within radii of some."""
        top = spectral_norm(mid)
        return cls(mid, np.broadcast_to(np.asarray(rad, float), top.shape), top)

    @property
    def most(self) -> Array:
        """Bounds of the norms, shape (...)."""
        return np.asarray((self.top + self.rad) * OUT)

    @classmethod
    def outer(cls, a: Enclosure, b: Enclosure) -> Matrix:
        """Return ``a b^T + b a^T``."""
        product = a.mid[..., :, None] * b.mid[..., None, :]
        x, y, dx, dy = size(a.mid), size(b.mid), a.reach, b.reach
        rad = 2 * (x * dy + dx * y + dx * dy + ROUND * x * y) * OUT
        return cls(product + np.swapaxes(product, -1, -2), rad, 2 * x * y * OUT)

    def __add__(self, other: Matrix) -> Matrix:
        top = (self.top + other.top) * OUT
        # An entry is at most `top`; the norm of a matrix of roundings is at most d of the largest.
        rounding = ROUND * self.mid.shape[-1] * top
        return Matrix(self.mid + other.mid, (self.rad + other.rad + rounding) * OUT, top)

    def __sub__(self, other: Matrix) -> Matrix:
        return self + Matrix(-other.mid, other.rad, other.top)

    def __rmul__(self, factor: float) -> Matrix:
        """Return the product with a power of two."""
        return Matrix(factor * self.mid, abs(factor) * self.rad, abs(factor) * self.top)

    def times(self, number: Enclosure) -> Matrix:
        """Return the product with a number."""
        far, reach = size(number.mid), number.reach
        rounding = ROUND * self.mid.shape[-1] * far * self.top
        rad = far * self.rad + reach * (self.top + self.rad) + rounding
        return Matrix(number.mid[..., None] * self.mid, rad * OUT, far * self.top * OUT)


class Jet:
    """Functions of vectors x with their derivatives, enclosed for all x of a set."""

    __slots__ = ("bend", "gradient", "value")
    #: Numbers, shape (..., 1).
    value: Enclosure
    #: First derivatives, shape (..., d).
    gradient: Enclosure
    #: Second derivatives, shape (..., d, d).
    bend: Matrix

    def __init__(self, value: Enclosure, gradient: Enclosure, bend: Matrix) -> None:
        self.value, self.gradient, self.bend = value, gradient, bend

    @classmethod
    def quadric(cls, matrix: Matrix, x: Enclosure) -> Jet:
        """Return ``x . M x / 2``."""
        value = x.quadric(matrix.mid, matrix.top).widened(matrix.rad * x.most**2 / 2)
        gradient = x.under(matrix.mid, matrix.top).widened(matrix.rad * x.most)
        return cls(value, gradient, matrix)

    def __add__(self, other: Jet) -> Jet:
        gradient = self.gradient + other.gradient
        return Jet(self.value + other.value, gradient, self.bend + other.bend)

    def __sub__(self, other: Jet) -> Jet:
        gradient = self.gradient - other.gradient
        return Jet(self.value - other.value, gradient, self.bend - other.bend)

    def __mul__(self, other: Jet) -> Jet:
        gradient = self.value * other.gradient + other.value * self.gradient
        bend = other.bend.times(self.value) + self.bend.times(other.value)
        bend = bend + Matrix.outer(self.gradient, other.gradient)
        return Jet(self.value * other.value, gradient, bend)

    def times(self, number: Enclosure) -> Jet:
        """Return the product with numbers that do not depend on x."""
        return Jet(number * self.value, number * self.gradient, self.bend.times(number))
