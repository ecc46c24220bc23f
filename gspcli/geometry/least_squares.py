"""Least squares by Levenberg and Marquardt's method, from many starts at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Arrays with the same leading axes, one entry for each start.
Point = tuple[Array, ...]

_FIRST_DAMPING, _LEAST_DAMPING, _LARGEST_DAMPING = 1e-3, 1e-15, 1e8
#: A descent ends where the sum of squares would fall by less than this part of it with a damping
#: of at most `_FREE`, or where the largest number of a step is rounding.
_DECREASE, _FREE, _ROUNDING = 1e-14, 1e-6, 1e-13


class Ends(NamedTuple):
    """Where descents end."""

    point: Point
    residuals: Array
    """Shape (..., m)."""
    ended: NDArray[np.bool_]
    """Which came to an end; the others were given up."""

    @property
    def squares(self) -> Array:
        """The sums of squares, shape (...)."""
        return np.asarray((self.residuals**2).sum(axis=-1))


def descend(
    equations: Callable[..., tuple[Array, Array]],
    moved: Callable[..., Point],
    start: Point,
    *,
    steps: int = 100,
    noise: float = 0.0,
    enough: float = -1.0,
) -> Ends:
    """Return where descents of sums of squares from many starts end: minima, if they end.

    A step solves ``(J^T J + d s I) step = -J^T r`` with the largest eigenvalue s of ``J^T J``
    (Levenberg 1944, Marquardt 1963). It is of least norm where the matrix is singular.

    Parameters
    ----------
    equations
        Gives the residuals r at a point, shape (..., m), and their derivatives J by a step, shape
        (..., m, k). Derivatives that are not finite count as zero.
    moved
        Gives the point after steps, ``moved(step, *point)`` with a step of shape (..., k). Steps
        whose k numbers are alike should have effects that are.
    start
        Where the descents begin.
    steps
        How many steps are tried at most.
    noise
        A change of the sum of squares that says nothing, beside rounding, is 1e-14 of this.
    enough
        All descents end when one sum of squares is at most this.
    """
    point = start
    with np.errstate(all="ignore"):
        residuals, slopes = equations(*point)
        squares = (residuals**2).sum(axis=-1)
        damping, ended = np.full(squares.shape, _FIRST_DAMPING), ~np.isfinite(squares)
        for _ in range(steps):
            if ended.all() or (squares <= enough).any():
                break
            slopes = np.nan_to_num(slopes, posinf=0.0, neginf=0.0)
            gradient = np.einsum("...mk,...m->...k", slopes, np.nan_to_num(residuals))
            values, axes = np.linalg.eigh(np.swapaxes(slopes, -1, -2) @ slopes)
            size = np.maximum(values, 0.0) + damping[..., None] * values[..., -1:]
            along = np.einsum("...kj,...k->...j", axes, gradient) / np.where(size > 0, size, 1.0)
            step = -np.einsum("...kj,...j->...k", axes, along)
            gain = np.abs((gradient * step).sum(axis=-1))
            ended |= (damping <= _FREE) & (gain <= _DECREASE * (squares + noise))
            ended |= np.abs(step).max(axis=-1) <= _ROUNDING
            tried = moved(step, *point)
            after, by = equations(*tried)
            costs = (after**2).sum(axis=-1)
            better = costs <= squares
            point = tuple(_chosen(better, a, b) for a, b in zip(tried, point, strict=True))
            residuals, slopes = _chosen(better, after, residuals), _chosen(better, by, slopes)
            squares = np.where(better, costs, squares)
            changed = np.where(better, damping / 10, damping * 10)
            damping = np.clip(changed, _LEAST_DAMPING, _LARGEST_DAMPING)
    return Ends(point, residuals, ended & np.isfinite(squares))


def _chosen(first: NDArray[np.bool_], a: Array, b: Array) -> Array:
    """Return the entries of a where the first are wanted, else those of b."""
    return np.where(first.reshape(first.shape + (1,) * (a.ndim - first.ndim)), a, b)
