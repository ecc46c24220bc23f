"""Quadrics in Study coordinates: their coefficients, the five spaces, the swap of p and q.

A Study point is ``z = (e0, e1, e2, e3, f0, f1, f2, f3)`` in C^8 up to scale, with
``e.f = 0``. It stands for the motion ``x -> R x + T`` of the unit quaternion ``e / sqrt(N)``,
``N = e.e``, and ``T = 2 vec(f e*) / N``. A quadric is

    Q(z) = sum_{i<=j} A_ij e_i e_j + sum_{ij} B_ij e_i f_j + c f.f

and is stored as its 27 coefficients: ten of A (row by row, ``i <= j``), sixteen of B (row by
row), c. The functions of the motion that are quadrics after multiplication by N are those of
`gspcli.geometry.study`; a space is the linear space that some of them span:

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

from itertools import chain
from typing import Final, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.geometry import study

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Number = TypeVar("Number", np.float64, np.complex128)

COEFFICIENTS: Final = 27
LETTERS: Final = "apqls"
"""The spaces in their canonical order."""

_ROW, _COLUMN = np.triu_indices(4)


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


def _forms() -> FloatArray:
    """Return N times the functions of the motion, in the order of `study.forms`, (27, 27)."""
    hessians = study.form_hessians()
    parts = hessians[:, :4, :4] / 2, hessians[:, :4, 4:], hessians[:, 4, 4] / 2
    return np.asarray(pack(*parts), np.float64)


FORMS: Final = _forms()
NORM: Final = FORMS[study.NORM]
"""N itself: the quadric of the constant function 1; shape (27,)."""
_A = (study.NORM, *chain(*study.ROTATION))
SPACES: Final[dict[str, tuple[int, ...]]] = {
    "a": _A,
    "p": (*_A, *study.TRANSLATION),
    "q": (*_A, *study.BODY),
    "l": (*_A, *chain(*study.MOMENT)),
    "s": (*_A, *study.TRANSLATION, *study.BODY, study.RHO),
}
"""For each space the places of its functions in `FORMS`."""
BASES: Final = {letter: FORMS[list(places)] for letter, places in SPACES.items()}
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
