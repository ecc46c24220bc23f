"""Quintic splines through rows of numbers, and their two derivatives at the rows.

SciPy's `make_interp_spline` gives the same (a test compares them); loading it takes four times as
long as 10 000 rows take here. The collocation matrix of B-splines is banded and totally positive,
so that none of its principal parts is singular: it is eliminated in blocks, in any order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_DEGREE = 5
#: A spline of this degree has this many coefficients at least, and a row for each.
FEWEST_ROWS = _DEGREE + 1
#: Rows of a block of the banded matrix; at least its width to either side.
_BLOCK = 8


def derivatives(t: Array, rows: Array) -> tuple[Array, Array]:
    """Return the first and second derivative at each row of the quintic spline through them.

    Its knots are all rows but the second, third, last but one and last but two (no knot there).

    Parameters
    ----------
    t
        Increasing, shape (n,), n at least 6.
    rows
        Shape (n, m).
    """
    knots = np.concatenate(([t[0]] * 6, t[3:-3], [t[-1]] * 6))
    first, values = _basis(knots, _DEGREE, t)
    coefficients = _solve_banded(first, values, rows)
    found = []
    for degree in (_DEGREE, _DEGREE - 1):
        # The derivative is a spline of a degree less without the outermost knots.
        spans = knots[degree + 1 : -1] - knots[1 : -degree - 1]
        coefficients = degree * np.diff(coefficients, axis=0) / spans[:, None]
        knots = knots[1:-1]
        first, values = _basis(knots, degree - 1, t)
        window = coefficients[first[:, None] + np.arange(degree)]
        found.append(np.einsum("nk,nkm->nm", values, window))
    return found[0], found[1]


def _basis(knots: Array, degree: int, t: Array) -> tuple[NDArray[np.int64], Array]:
    """Return which B-splines do not vanish at t: the first, (n,), and values, (n, degree + 1)."""
    span = np.clip(np.searchsorted(knots, t, "right") - 1, degree, len(knots) - degree - 2)
    values = np.zeros((len(t), degree + 1))
    values[:, 0] = 1.0
    for k in range(1, degree + 1):
        saved = np.zeros(len(t))
        for r in range(k):
            above, below = knots[span + r + 1] - t, t - knots[span + 1 - k + r]
            part = values[:, r] / (above + below)
            values[:, r] = saved + above * part
            saved = below * part
        values[:, k] = saved
    return span - degree, values


def _solve_banded(first: NDArray[np.int64], values: Array, right: Array) -> Array:
    """Solve for the coefficients: row i has `values[i]` from column `first[i]` on."""
    n, width = values.shape
    count = -(-n // _BLOCK)
    rows = np.arange(n)
    # Three blocks beside each other for each block of rows: before, on and after the diagonal.
    band = np.zeros((count, _BLOCK, 3 * _BLOCK))
    block, row = np.divmod(rows, _BLOCK)
    column = first - (block - 1) * _BLOCK
    for k in range(width):
        band[block, row, column + k] = values[:, k]
    padding = np.arange(n, count * _BLOCK)
    band[-1, padding % _BLOCK, padding % _BLOCK + _BLOCK] = 1.0
    given = np.zeros((count * _BLOCK, right.shape[1]))
    given[:n] = right
    before, on, after = np.split(band, 3, axis=2)
    found = _solve_blocks(before, on, after, given.reshape(count, _BLOCK, -1))
    return found.reshape(count * _BLOCK, -1)[:n]


def _solve_blocks(before: Array, on: Array, after: Array, right: Array) -> Array:
    """Solve a block tridiagonal system by cyclic reduction: every second block, all at once.

    Blocks (m, b, b), right sides (m, b, r).
    """
    if len(on) == 1:
        return np.asarray(np.linalg.solve(on, right))
    b = on.shape[1]
    odd = np.linalg.solve(
        on[1::2], np.concatenate((before[1::2], after[1::2], right[1::2]), axis=2)
    )
    to_before, to_after, alone = np.split(odd, (b, 2 * b), axis=2)
    # The even blocks between: those before and after each are expressed by the next even ones.
    before, on, after, right = before[::2], on[::2].copy(), after[::2], right[::2].copy()
    lower, upper = np.zeros_like(on), np.zeros_like(on)
    on[1:] -= before[1:] @ to_after[: len(on) - 1]
    right[1:] -= before[1:] @ alone[: len(on) - 1]
    lower[1:] = -before[1:] @ to_before[: len(on) - 1]
    on[: len(odd)] -= after[: len(odd)] @ to_before
    right[: len(odd)] -= after[: len(odd)] @ alone
    upper[: len(odd)] = -after[: len(odd)] @ to_after
    found = np.empty((len(on) + len(odd), *right.shape[1:]))
    found[::2] = even = _solve_blocks(lower, on, upper, right)
    found[1::2] = alone - to_before @ even[: len(odd)]
    followed = len(even) - 1
    found[1::2][:followed] -= to_after[:followed] @ even[1:]
    return found
