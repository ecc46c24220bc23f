"""Residuals of constraints at a pose, and the condition number of a pose.

As `gspcli.geometry.measurement`: poses may be complex and have leading batch axes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, Law
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.quaternions import Field, apply, cross, dot
from gspcli.geometry.tolerances import NEARLY_PARALLEL_SINE_SQUARE

Array = NDArray[np.float64]

_DIGITS = 60
#: A height below this part of the lengths in its sum may have either sign, by rounding.
_SIGN_KNOWN = 2.0**-45
#: A singular value of a 6x6 matrix of doubles below this part of the largest may be zero.
_ROUNDING = 6 * float(np.finfo(np.float64).eps)
#: Poses in one block: their matrices fit into the cache, and larger blocks take twice the time.
_TOGETHER = 1024


def residuals(arrangement: Arrangement, R: Field, T: Field) -> Array:
    """Return measured minus stated value of each constraint, in the units of the instance.

    The distance or angle itself counts, not its square or cosine:
    ``(..., 3, 3), (..., 3) -> (..., n)``. Where a measured distance has no sign, or both sides are
    allowed, the nearer sign is taken. An arrangement with values of shape (..., n) serves poses
    of many sets of values.
    """
    values = measured(arrangement, R, T)
    targets = arrangement.targets
    difference = np.abs(values - targets)
    free = np.array([kind.is_distance for kind in arrangement.kinds]) & (arrangement.signs == 0)
    opposite = np.where(free, np.abs(values + targets), np.inf)
    signed = np.abs(values - np.where(arrangement.signs < 0, -targets, targets))
    result = np.where(free, np.minimum(difference, opposite), signed)
    result[..., arrangement.angles] /= arrangement.in_radians
    return np.asarray(result)


def relative_residuals(arrangement: Arrangement, R: Field, T: Field) -> Array:
    """Return `residuals` without units: lengths by that of the platform, angles in radians."""
    units = np.full(len(arrangement.kinds), arrangement.length)
    units[arrangement.angles] = 1 / arrangement.in_radians
    return np.asarray(residuals(arrangement, R, T) / units)


def proved_residuals(arrangement: Arrangement, R: Field, T: Field) -> Array:
    """Return residuals at poses for which the constraints are proved to hold as stated.

    Nearly parallel lines of a DLL are measured as skew lines with more digits. Where rounding alone
    may separate them from parallel ones they are measured as parallel, too, and the smaller
    residual counts. The doubles of a pose are taken as exact: lines at an angle of s lose as many
    digits of their distance as s has zeros. ``(b, 3, 3), (b, 3) -> (b, n)``.
    """
    result = residuals(arrangement, R, T)
    lines = [k for k, kind in enumerate(arrangement.kinds) if kind is DLL]
    if not lines:
        return result
    w = arrangement.placed(R, T).w[:, lines]
    normals = cross(w, np.broadcast_to(arrangement.v[lines], w.shape))
    squares = np.abs(dot(normals, normals))
    targets = np.broadcast_to(arrangement.targets, result.shape)
    for pose, line in zip(*np.nonzero(squares < NEARLY_PARALLEL_SINE_SQUARE), strict=True):
        k = lines[line]
        distance = _skew_distance(arrangement, R[pose], T[pose], k)
        if distance is not None:
            skew = min(abs(distance - targets[pose, k]), abs(distance + targets[pose, k]))
            result[pose, k] = min(skew, result[pose, k])
    return result


def _skew_distance(arrangement: Arrangement, R: Field, T: Field, k: int) -> complex | None:
    """Return the distance of two lines that are not exactly parallel, else None."""
    # Few poses need mpmath, and its import takes as long as a solve.
    from mpmath import MPContext

    context = MPContext()
    context.dps = _DIGITS

    def exactly(numbers: Field) -> list[Any]:
        return [context.mpmathify(x) for x in numbers.tolist()]

    y, x, u, v = (
        exactly(a[k]) for a in (arrangement.y, arrangement.x, arrangement.u, arrangement.v)
    )
    rows, place = [exactly(row) for row in R], exactly(T)
    w = [context.fdot(row, u) for row in rows]
    r = [context.fdot(row, y) + t - b for row, t, b in zip(rows, place, x, strict=True)]
    normal = [w[i - 2] * v[i - 1] - w[i - 1] * v[i - 2] for i in range(3)]
    square = context.fdot(normal, normal)
    return complex(context.fdot(r, normal) / context.sqrt(square)) if square else None


def sides_of(arrangement: Arrangement, R: Field, T: Field) -> NDArray[np.int64]:
    """Return on which side each DPH and DHP point lies: 1, -1, or 0 for other kinds."""
    values = measured(arrangement, R, T).real
    sign = np.where(values < 0, -1, 1)
    return np.where(arrangement.sided, np.where(arrangement.signs == 0, sign, arrangement.signs), 0)


def known_sides(arrangement: Arrangement, R: Field, T: Field) -> NDArray[np.int64]:
    """Return the sides of `sides_of`, but 0 where rounding may change the sign of a height.

    For poses ``(n, 3, 3), (n, 3)`` rounded to doubles, the error of a height is some units in the
    last place of the largest length in its sum.
    """
    small = np.abs(arrangement.targets) <= _SIGN_KNOWN * _size(arrangement, R, T)[..., None]
    return np.where(small & (arrangement.signs == 0), 0, sides_of(arrangement, R, T))


def without_derivative(arrangement: Arrangement, R: Field, T: Field) -> NDArray[np.bool_]:
    """Return which constraints measure a distance to a point or line that may be zero, (..., n).

    There the distance has no derivative: what is computed has the direction of rounding errors.
    """
    roots = np.array([kind.law is Law.SQUARE for kind in arrangement.kinds])
    if not roots.any():
        return np.zeros((*T.shape[:-1], len(roots)), np.bool_)
    values = np.abs(measured(arrangement, R, T))
    return np.asarray(roots & (values <= _SIGN_KNOWN * _size(arrangement, R, T)[..., None]))


def _size(arrangement: Arrangement, R: Field, T: Field) -> Array:
    """Return the largest length that values at poses are made of, shape (...)."""
    extent = max(np.abs(arrangement.y).max(initial=0), np.abs(arrangement.x).max(initial=0))
    return np.asarray((1 + np.abs(R).max(axis=(-1, -2))) * extent + np.abs(T).max(axis=-1))


def condition_numbers(
    arrangement: Arrangement, R: Field, T: Field, length: float | Array | None = None
) -> Array:
    """Return the condition number of each pose, free of units, ``(..., 3, 3) -> (...)``.

    It is the ratio of the largest to the smallest singular value of the 6x6 Jacobian matrix.
    Twists turn about the centre of the platform points, columns of rotations are divided by the
    typical length (that of the arrangement for None, else shape (...)), and rows are scaled to
    norm one. The number depends neither on frames nor on units. It is infinite at a singular
    pose and at a pose that doubles cannot distinguish from one.
    """
    lengths = np.broadcast_to(arrangement.length if length is None else length, T.shape[:-1])
    if R.ndim > 2 and len(R) > _TOGETHER:
        parts = [slice(first, first + _TOGETHER) for first in range(0, len(R), _TOGETHER)]
        return np.concatenate(
            [condition_numbers(arrangement.part(k), R[k], T[k], lengths[k]) for k in parts]
        )
    unit = lengths[..., None, None]
    # The row of a value without a derivative (parallel lines, distance or angle zero) is not
    # finite.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rows = jacobian(arrangement, R, T)
        # About the centre c of the platform: T + s (omega x R c moved back) leaves R c + T alone.
        offset = apply(R, arrangement.platform_centre)[..., None, :]
        rows[..., :3] -= cross(np.broadcast_to(offset, rows[..., 3:].shape), rows[..., 3:])
        rows[..., :3] /= unit
        norms = np.linalg.norm(rows, axis=-1, keepdims=True)
        defined = np.isfinite(norms).all(axis=(-1, -2)) & (norms > 0).all(axis=(-1, -2))
        defined &= ~without_derivative(arrangement, R, T).any(axis=-1)
        rows = np.where(defined[..., None, None], rows / np.where(norms > 0, norms, 1.0), 0.0)
        values = np.linalg.svd(rows, compute_uv=False)
        condition = values[..., 0] / values[..., -1]
    regular = values[..., -1] > _ROUNDING * values[..., 0]
    return np.where(defined & regular, condition, np.inf)
