"""The shortest step that satisfies linear inequalities (Lawson and Hanson's LDP)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Relative size below which a multiplier or a gradient counts as zero.
_ZERO = 1e-11


def shortest_step(normals: Array, least: Array, longest: float = np.inf) -> Array | None:
    """Return the shortest vector x with ``normals @ x >= least``, or None if there is none.

    C. L. Lawson, R. J. Hanson, *Solving Least Squares Problems* (1974), chapter 23: the
    dual problem is one of least squares with nonnegative unknowns. Its rest r falls, and
    ``1 - |r|^2`` over ``|r|^2`` is the square of a length that x has at least.

    Parameters
    ----------
    normals
        Rows of norm about 1, shape (m, n).
    least
        Shape (m,).
    longest
        Longer vectors are not returned.
    """
    scale = float(np.abs(least).max(initial=0.0))
    if scale == 0 or (least <= 0).all():
        return np.zeros(normals.shape[1])
    matrix = np.concatenate((normals.T, least[None] / scale))
    goal = np.zeros(len(matrix))
    goal[-1] = 1.0
    # The rest vanishes if some combination of the rows says 0 >= 1.
    hopeless = max(_ZERO, 1 / (1 + (longest / scale) ** 2))
    rest = matrix @ nonnegative_least_squares(matrix, goal, hopeless) - goal
    if rest @ rest < hopeless:
        return None
    return np.asarray(-scale * rest[:-1] / rest[-1])


def nonnegative_least_squares(matrix: Array, goal: Array, enough: float = 0.0) -> Array:
    """Return the x >= 0 that minimizes ``|matrix @ x - goal|``, shape (m, n), (m,) -> (n,).

    Lawson and Hanson, chapter 23, on normal equations of the positive unknowns. With `enough`, the
    first x on the way there that brings the square of that below.
    """
    right = matrix.T @ goal
    count = len(right)
    # The ridge keeps the passive equations regular if columns are dependent.
    ridge = _ZERO * float((matrix * matrix).sum()) / max(count, 1)
    x = np.zeros(count)
    passive = np.zeros(count, bool)
    for _ in range(3 * count):
        rest = goal - matrix @ x
        if rest @ rest < enough:
            break
        gradient = np.where(passive, -np.inf, rest @ matrix)
        best = int(gradient.argmax())
        if gradient[best] <= _ZERO * np.abs(right).max():
            break
        passive[best] = True
        while True:
            index = np.flatnonzero(passive)
            columns = matrix[:, index]
            inner = columns.T @ columns
            inner.flat[:: len(index) + 1] += ridge
            wanted = np.linalg.solve(inner, right[index])
            if (wanted > 0).all():
                break
            # Go towards the solution until the first unknown vanishes, and drop it.
            wrong = wanted <= 0
            ratio = x[index[wrong]] / (x[index[wrong]] - wanted[wrong])
            x[index] += ratio.min() * (wanted - x[index])
            passive[index[wrong][ratio <= ratio.min()]] = False
            x[~passive] = 0.0
        x[index] = wanted
    return x
