"""Bisection: up to which size something holds, of many at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def bisected(
    holds: Callable[[Array], NDArray[np.bool_]],
    low: Array,
    high: Array,
    halvings: int,
    *,
    close: float = 1.0,
    first: float = 0.5,
) -> tuple[Array, Array]:
    """Return sizes at which something holds, and at which it does not, nearer to each other, (n,).

    Parameters
    ----------
    holds
        Whether it holds at sizes, ``(n,) -> (n,)``: as at `low`, and not as at `high`.
    halvings
        The most halvings; they end when no `high` is more than `close` times its `low`.
    first
        The part of `high` that is tried as long as `low` is zero: any order of magnitude is found.
    """
    for _ in range(halvings):
        if (high <= low * close).all():
            break
        middle = np.where(low > 0, (low + high) / 2, high * first)
        good = holds(middle)
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    return low, high
