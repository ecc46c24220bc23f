"""Which of several numbers, or vectors, is taken where only rounding errors tell them apart.

Symmetric platforms have equal loads, frequencies and singular values, and a vector of a kernel has
two signs. What is shown must be the same on every processor. So the first of equal numbers is
taken, and the one basis of equal directions that begins nearest to the coordinate axes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Numbers that differ by less than this part of their size are equal but for rounding errors.
ALIKE = 1e-9
Field = NDArray[Any]


def first_largest(values: ArrayLike, axis: int = -1) -> NDArray[np.int64]:
    """Return the index of the first of the largest numbers, as `argmax`; none may be NaN."""
    given = np.asarray(values, float)
    most = given.max(axis=axis, keepdims=True)
    room = np.where(np.isfinite(most), ALIKE * np.abs(most), 0.0)
    return np.asarray((given >= most - room).argmax(axis=axis))


def first_smallest(values: ArrayLike) -> NDArray[np.int64]:
    """Return the index of the first of the smallest numbers, as `argmin`; none may be NaN."""
    return first_largest(-np.asarray(values, float))


def ascending(values: ArrayLike, alike: float = ALIKE) -> NDArray[np.int64]:
    """Return the indices that sort numbers; those equal to the least stay in their order.

    Parameters
    ----------
    values
        None is negative or NaN, shape (n,).
    alike
        Numbers that exceed the least by less than this part of it are equal to it.
    """
    given = np.asarray(values, float)
    least = given.min(initial=np.inf)
    return np.argsort(np.where(given <= least * (1 + alike), least, given), kind="stable")


def definite_sign(vectors: Field) -> Field:
    """Return vectors, shape (..., n), times what makes the first largest entry positive.

    A real vector is kept or reversed; a complex one is turned by a phase. Zero stays zero.
    """
    first = first_largest(np.abs(vectors))[..., None]
    entry = np.take_along_axis(np.asarray(vectors), first, axis=-1)
    size = np.abs(entry)
    return np.asarray(vectors * np.where(size > 0, entry.conj() / np.where(size > 0, size, 1), 1))


def definite_basis(basis: Field) -> Field:
    """Return the orthonormal basis of a space that begins nearest to the coordinate axes.

    Parameters
    ----------
    basis
        Any orthonormal basis of it: columns, real or complex, shape (n, k).
    """
    projector = basis @ basis.conj().T
    chosen = []
    for _ in range(basis.shape[1]):
        sizes = np.diagonal(projector).real
        axis = int(first_largest(sizes))
        vector = projector[:, axis] / np.sqrt(sizes[axis])
        chosen.append(vector)
        projector = projector - np.outer(vector, vector.conj())
    return np.stack(chosen, axis=1) if chosen else basis


def definite_vectors(values: NDArray[np.float64], vectors: Field) -> Field:
    """Return eigenvectors, or singular vectors, that do not depend on rounding errors.

    Those of one value have a definite sign, those of equal values are a `definite_basis`.

    Parameters
    ----------
    values
        Their values in ascending or descending order, shape (k,). Two are equal if they differ by
        less than `ALIKE` of the largest.
    vectors
        The vectors as columns, shape (n, k).
    """
    apart = np.abs(np.diff(values)) > ALIKE * np.abs(values).max(initial=0.0)
    groups = np.split(np.arange(len(values)), np.flatnonzero(apart) + 1)
    return np.concatenate([definite_basis(vectors[:, group]) for group in groups], axis=1)


def definite_pairs(u: Field, values: NDArray[np.float64], vt: Field) -> tuple[Field, Field]:
    """Return singular vectors that do not depend on rounding errors where values are equal.

    Parameters
    ----------
    u, values, vt
        As `numpy.linalg.svd` returns them, shapes (b, n, n), (b, n), (b, n, n).

    Returns
    -------
    u, vt
        Of equal singular values the left vectors are a `definite_basis`, and the right ones are
        turned with them: the product is the same matrix, and so is that of the determinants.
    """
    gaps = -np.diff(values, axis=-1)
    close = gaps <= ALIKE * values[:, :1]
    rows = np.flatnonzero(close.any(axis=-1)).tolist()
    if not rows:
        return u, vt
    u, vt = u.copy(), vt.copy()
    for row in rows:
        for group in np.split(np.arange(values.shape[1]), np.flatnonzero(~close[row]) + 1):
            if len(group) > 1:
                basis = definite_basis(u[row][:, group])
                turn = basis.conj().T @ u[row][:, group]
                u[row][:, group], vt[row][group] = basis, turn @ vt[row][group]
    return u, vt
