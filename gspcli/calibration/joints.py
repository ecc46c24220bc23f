"""Joints of legs from lengths at known poses, without a first guess.

The square of a length l is linear in the unknown joints p (platform) and b (base): ``l^2 - T.T =
(p.p + b.b) + 2 U.p - 2 T.b - 2 R:(b p^T)`` with ``U = R^T T``, 16 unknowns a leg if the products of
p and b count as unknowns of their own. A constant that is missing in the lengths is one more. If
the log does not determine all of these, the solution of least norm is still a start: Gauss and
Newton's method for the six or seven numbers of a leg follows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Unknowns of a leg in the linear equations, without the missing constant.
UNKNOWNS = 16
#: Singular values below this part of the largest are zero; the starts leave out more of them.
_ROUNDING, _KEPT = 1e-10, (16, 13, 10, 7)
_STEPS, _DECREASE = 40, 1e-6

#: Of a robust fit rows are left out with residuals of more than this many times the median.
_ROUNDS, _FAR_OUT = 40, 10.0


class Joints(NamedTuple):
    """What explains the lengths of six legs best.

    Units are those of the lengths.
    """

    numbers: Array
    """Joints on the platform and on the base, and the missing constant, shape (6, 7)."""
    residual: Array
    """The residual of each length, shape (n, 6)."""

    @property
    def squares(self) -> float:
        """The sum of the squares of the residuals."""
        return float((self.residual**2).sum())


def columns_of(R: Array, T: Array) -> Array:
    """Return the columns of the linear equations, scaled, shape (n, 16)."""
    size = float(np.abs(T).max(initial=0.0)) or 1.0
    U = np.einsum("nab,na->nb", R, T)
    return np.hstack((np.ones((len(T), 1)), U / size, T / size, R.reshape(-1, 9)))


def left_of_lengths(R: Array, T: Array, lengths: Array, factors: Array, *, offsets: bool) -> Array:
    """Return how far lengths are from satisfying the linear equations, a length for each factor.

    Parameters
    ----------
    R, T
        Poses, shapes (n, 3, 3) and (n, 3).
    lengths
        Shape (n, 6).
    factors
        What T may have to be multiplied by, shape (k,).
    offsets
        Whether a constant is missing in the lengths of each leg.

    Returns
    -------
    Array
        Root mean squares, shape (k,).
    """
    basis, s, _ = np.linalg.svd(columns_of(R, T), full_matrices=False)
    basis = basis[:, s > _ROUNDING * s[0]]
    rho = (T**2).sum(axis=1)
    square = lengths**2

    def across(part: Array) -> Array:
        left: Array = part - basis @ (basis.T @ part)
        return left

    rest, of_rho, of_length = across(square), across(rho), across(lengths)
    left = rest[None] - factors[:, None, None] ** 2 * of_rho[None, :, None]
    if offsets:
        weight = (of_length**2).sum(axis=0)
        there = np.where(weight > 0, weight, 1.0)
        left = left - of_length * ((left * of_length).sum(axis=1) / there)[:, None]
    freedom = max(len(T) - basis.shape[1] - offsets, 1)
    found: Array = np.sqrt((left**2 / (4 * square.mean(axis=0))).sum(axis=(1, 2)) / (6 * freedom))
    return found


def linear_starts(R: Array, T: Array, lengths: Array, *, offsets: bool) -> Array:
    """Return starts for the joints, least-norm solutions with several ranks, shape (k, 6, 7)."""
    columns, rho = columns_of(R, T), (T**2).sum(axis=1)
    size = float(np.abs(T).max(initial=0.0)) or 1.0
    long = float(lengths.mean())
    starts = np.zeros((len(_KEPT), 6, 7))
    for leg, length in enumerate(lengths.T):
        full = np.column_stack((columns, -2 * length / long)) if offsets else columns
        U, s, V = np.linalg.svd(full, full_matrices=False)
        parts = U.T @ (length**2 - rho)
        for k, kept in enumerate(_KEPT):
            some = (np.arange(len(s)) < kept + offsets) & (s > _ROUNDING * s[0])
            found = V.T @ np.where(some, parts / np.where(some, s, 1.0), 0.0)
            joints = found[1:7] / (2 * size) * ([1] * 3 + [-1] * 3)
            starts[k, leg] = np.append(joints, found[16] / long if offsets else 0.0)
    return starts


def fitted(R: Array, T: Array, lengths: Array, starts: Array, *, offsets: bool) -> Joints:
    """Return the joints of least squares from the best of some starts, each leg for itself.

    Parameters
    ----------
    R, T, lengths
        As for `left_of_lengths`.
    starts
        Shape (k, 6, 7).
    offsets
        Whether the missing constants are estimated; zero otherwise.
    """
    found, left = all_fitted(R, T, lengths, starts, offsets=offsets)
    best = (left**2).sum(axis=-1).argmin(axis=0)
    legs = np.arange(6)
    return Joints(found[best, legs], left[best, legs].T)


def all_fitted(
    R: Array,
    T: Array,
    lengths: Array,
    starts: Array,
    *,
    offsets: bool,
    weights: Array | None = None,
) -> tuple[Array, Array]:
    """Return where each start ends, (k, 6, 7), and the residuals there, (k, 6, n).

    With weights of lengths, shape (6, n), the residuals are multiplied by them.
    """
    count = 7 if offsets else 6
    found = starts.copy()
    damping = np.full(found.shape[:2], 1e-3)
    left, slopes = _equations(R, T, lengths, found, weights)
    cost = (left**2).sum(axis=-1)
    for _ in range(_STEPS):
        J = slopes[..., :count]
        normal = np.swapaxes(J, -1, -2) @ J
        diagonal = np.diagonal(normal, axis1=-2, axis2=-1)
        ridge = damping[..., None] * (diagonal + 1e-12 * diagonal.max(axis=-1, keepdims=True))
        right = np.swapaxes(J, -1, -2) @ left[..., None]
        step = np.linalg.solve(normal + ridge[..., None] * np.eye(count), right)[..., 0]
        tried = found.copy()
        tried[..., :count] -= step
        after, by = _equations(R, T, lengths, tried, weights)
        costs = (after**2).sum(axis=-1)
        better = costs <= cost
        small = better & (cost - costs <= _DECREASE * cost)
        found = np.where(better[..., None], tried, found)
        left = np.where(better[..., None], after, left)
        slopes = np.where(better[..., None, None], by, slopes)
        cost = np.where(better, costs, cost)
        damping = np.clip(np.where(better, damping / 10, damping * 10), 1e-15, 1e8)
        if small.all():
            break
    return found, left


def without_far(
    R: Array, T: Array, lengths: Array, joints: Joints, *, offsets: bool
) -> tuple[Joints, NDArray[np.bool_]]:
    """Return joints for which wrong lengths count little, and which rows have none of these.

    Repeated least squares with the weights of Cauchy's law, whose width is twice the median.
    """
    found = joints.numbers
    left = residuals(R, T, lengths, found)
    for _ in range(_ROUNDS):
        width = 2 * np.median(np.abs(left), axis=0) + 1e-15 * lengths.mean()
        weights = (1 + (left / width) ** 2).T ** -0.5
        ends, _ = all_fitted(R, T, lengths, found[None], offsets=offsets, weights=weights)
        found = ends[0]
        left = residuals(R, T, lengths, found)
    far = _FAR_OUT * np.median(np.abs(left), axis=0)
    return Joints(found, left), np.asarray((np.abs(left) <= far).all(axis=1))


def residuals(R: Array, T: Array, lengths: Array, joints: Array) -> Array:
    """Return the residuals of lengths, shape (n, 6), with joints of shape (6, 7)."""
    left: Array = _equations(R, T, lengths, joints[None])[0][0].T
    return left


def _equations(
    R: Array, T: Array, lengths: Array, joints: Array, weights: Array | None = None
) -> tuple[Array, Array]:
    """Return the residuals of lengths, (k, 6, n), and their derivatives, (k, 6, n, 7)."""
    along = np.einsum("nab,klb->klna", R, joints[..., :3]) + T - joints[..., None, 3:6]
    size = np.maximum(np.linalg.norm(along, axis=-1), 1e-300)
    unit = along / size[..., None]
    by_p = np.einsum("nab,klna->klnb", R, unit)
    left = size - lengths.T - joints[..., None, 6]
    slopes = np.concatenate((by_p, -unit, -np.ones((*size.shape, 1))), axis=-1)
    if weights is not None:
        left, slopes = left * weights, slopes * weights[..., None]
    return left, slopes
