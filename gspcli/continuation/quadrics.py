"""Quadrics in Study coordinates: their coefficients, the five spaces, the swap of p and q.

A Study point is ``z = (e0, e1, e2, e3, f0, f1, f2, f3)`` in C^8 up to scale, with
``e.f = 0``. It stands for the motion ``x -> R x + T`` of the unit quaternion ``e / sqrt(N)``,
``N = e.e``, and ``T = 2 vec(f e*) / N``. A quadric is

    Q(z) = sum_{i<=j} A_ij e_i e_j + sum_{ij} B_ij e_i f_j + c f.f

and is stored as its 27 coefficients: ten of A (row by row, ``i <= j``), sixteen of B (row by
row), c. The functions of the motion that are quadrics after multiplication by N are constants
of this module; a space is the linear space that some of them span:

====== ================ ===========
space  functions        dimension
====== ================ ===========
a      1, R             10
p      1, R, T          13
q      1, R, U = R^T T  13
l      1, R, T x R      19
s      1, R, T, U, T.T  17
====== ================ ===========
"""

from __future__ import annotations

from typing import Final, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Number = TypeVar("Number", np.float64, np.complex128)

COEFFICIENTS: Final = 27
LETTERS: Final = "apqls"
"""The spaces in their canonical order."""

_ROW, _COLUMN = np.triu_indices(4)
_CROSS = ((1, 2, 3), (2, 3, 1), (3, 1, 2))


def pack(a: ArrayLike, b: ArrayLike, c: ArrayLike) -> NDArray[np.inexact]:
    """Return the coefficients ``(..., 27)`` of ``e^T a e + e^T b f + c f.f``.

    Parameters
    ----------
    a, b
        Matrices ``(..., 4, 4)``; only the symmetric part of `a` matters.
    c
        Scalars ``(...)``.
    """
    a, b, c = np.asarray(a), np.asarray(b), np.asarray(c)
    upper = (a + np.swapaxes(a, -1, -2))[..., _ROW, _COLUMN] * np.where(_ROW == _COLUMN, 0.5, 1.0)
    flat = b.reshape(*b.shape[:-2], 16)
    return np.concatenate([upper, flat, c[..., None]], axis=-1)


def unpack(
    quadrics: NDArray[np.inexact],
) -> tuple[NDArray[np.inexact], NDArray[np.inexact], NDArray[np.inexact]]:
    """Return the matrices ``a`` (symmetric), ``b`` and the scalar ``c`` of packed quadrics."""
    half = 0.5 * quadrics[..., :10]
    a = np.zeros((*quadrics.shape[:-1], 4, 4), dtype=quadrics.dtype)
    a[..., _ROW, _COLUMN] += half
    a[..., _COLUMN, _ROW] += half
    b = quadrics[..., 10:26].reshape(*quadrics.shape[:-1], 4, 4)
    return a, b, quadrics[..., 26]


def monomials(points: NDArray[np.inexact]) -> NDArray[np.inexact]:
    """Return the 27 monomials ``(..., 27)`` at Study points ``(..., 8)``."""
    e, f = points[..., :4], points[..., 4:]
    mixed = (e[..., :, None] * f[..., None, :]).reshape(*e.shape[:-1], 16)
    square = (f * f).sum(axis=-1, keepdims=True)
    return np.concatenate([e[..., _ROW] * e[..., _COLUMN], mixed, square], axis=-1)


def evaluate(quadrics: NDArray[np.inexact], points: NDArray[np.inexact]) -> NDArray[np.inexact]:
    """Return the values ``(..., P, K)`` of quadrics ``(..., K, 27)`` at points ``(..., P, 8)``."""
    return np.asarray(monomials(points) @ np.swapaxes(quadrics, -1, -2))


def gradients(quadrics: NDArray[np.inexact], points: NDArray[np.inexact]) -> NDArray[np.inexact]:
    """Return the gradients ``(P, K, 8)`` of quadrics ``(K, 27)`` at points ``(P, 8)``."""
    a, b, c = unpack(quadrics)
    e, f = points[:, None, :4], points[:, None, 4:]
    by_e = (2 * a @ e[..., None] + b @ f[..., None])[..., 0]
    by_f = (e[..., None, :] @ b)[..., 0, :] + 2 * c[:, None] * f
    return np.concatenate([by_e, by_f], axis=-1)


def _rotation_forms() -> FloatArray:
    """Return the symmetric matrices ``(3, 3, 4, 4)`` with ``N R_ij = e^T S_ij e``."""
    forms = np.zeros((3, 3, 4, 4))
    for i in range(3):
        forms[i, i, 0, 0] = 1.0
        for k in range(3):
            forms[i, i, k + 1, k + 1] = 1.0 if k == i else -1.0
        for j in range(3):
            if i != j:
                k = 3 - i - j
                sign = -1.0 if (j - i) % 3 == 1 else 1.0
                forms[i, j, i + 1, j + 1] = forms[i, j, j + 1, i + 1] = 1.0
                forms[i, j, 0, k + 1] = forms[i, j, k + 1, 0] = sign
    return forms


def _translation_forms(sign: float) -> FloatArray:
    """Return B of ``2 (e0 f_i - e_i f0 + sign (e x f)_i)``: T for +1, U for -1."""
    forms = np.zeros((3, 4, 4))
    for row, (i, j, k) in enumerate(_CROSS):
        forms[row, 0, i], forms[row, i, 0] = 2.0, -2.0
        forms[row, j, k], forms[row, k, j] = 2.0 * sign, -2.0 * sign
    return forms


_ZERO = np.zeros((4, 4))
_S = _rotation_forms()
NORM: Final = pack(np.eye(4), _ZERO, 0.0)
"""N itself: the quadric of the constant function 1; shape (27,)."""
ROTATION: Final = pack(_S, np.zeros_like(_S), np.zeros((3, 3)))
"""N R_ij, shape (3, 3, 27)."""
TRANSLATION: Final = pack(np.zeros((3, 4, 4)), _translation_forms(1.0), np.zeros(3))
"""N T_i, shape (3, 27)."""
BODY_TRANSLATION: Final = pack(np.zeros((3, 4, 4)), _translation_forms(-1.0), np.zeros(3))
"""N U_i with U = R^T T, shape (3, 27)."""
# R is quadratic in e and (1 + eps f e*/N) turns R by eps T, so N [T]x R is the derivative of
# N R along f: twice the polar form.
MOMENT: Final = pack(np.zeros_like(_S), 2.0 * _S, np.zeros((3, 3)))
"""N (T x R)_ij, the i-th component of T x (column j of R); shape (3, 3, 27)."""
RHO: Final = pack(_ZERO, _ZERO, 4.0)
"""N T.T, shape (27,)."""

_A = np.vstack([NORM[None], ROTATION.reshape(9, 27)])
BASES: Final[dict[str, FloatArray]] = {
    "a": _A,
    "p": np.vstack([_A, TRANSLATION]),
    "q": np.vstack([_A, BODY_TRANSLATION]),
    "l": np.vstack([_A, MOMENT.reshape(9, 27)]),
    "s": np.vstack([_A, TRANSLATION, BODY_TRANSLATION, RHO[None]]),
}
"""For each space a basis ``(dimension, 27)``."""

_SIGN = np.array([1.0, -1.0, -1.0, -1.0])
_CONJUGATION = np.r_[_SIGN[_ROW] * _SIGN[_COLUMN], np.outer(_SIGN, _SIGN).ravel(), 1.0]
_POINT_CONJUGATION = np.r_[_SIGN, _SIGN]


def swap_quadrics(quadrics: NDArray[Number]) -> NDArray[Number]:
    """Return the quadrics ``Q(z*)``, ``z* = (e*, f*)``: base and platform exchanged.

    ``z*`` is the inverse motion, so that T becomes -U and U becomes -T: the space p becomes
    q and q becomes p; the others stay. The map is its own inverse.
    """
    return np.multiply(quadrics, _CONJUGATION, dtype=quadrics.dtype)


def swap_points(points: NDArray[Number]) -> NDArray[Number]:
    """Return the inverse motions ``(e*, f*)`` of Study points ``(..., 8)``."""
    return np.multiply(points, _POINT_CONJUGATION, dtype=points.dtype)


def swap_letters(spaces: str) -> str:
    """Return the spaces with p and q exchanged."""
    return spaces.translate(str.maketrans("pq", "qp"))


def random_complex(rng: np.random.Generator, *shape: int) -> ComplexArray:
    """Return complex standard normal numbers."""
    return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)


def random_quadrics(spaces: str, rng: np.random.Generator) -> ComplexArray:
    """Return random quadrics of norm 1, one of each space named, shape (len(spaces), 27)."""
    rows = np.array([random_complex(rng, len(BASES[x])) @ BASES[x] for x in spaces])
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))
