"""Study points that may be real or conjugates of others, without proof."""

from __future__ import annotations

import numpy as np
from flint import ctx
from numpy.typing import NDArray

from gspcli.certification.numbers.balls import largest
from gspcli.certification.poses.locator import LAST_PRECISION, Complex, Locator
from gspcli.geometry.quaternions import Field

#: Points that agree to this part of their largest entry are alike.
_ALIKE = 1e-13
#: Points with 32 digits and more that agree to this part are conjugates.
_CONJUGATE = 1e-24
#: Points with smaller imaginary parts may be real.
_NEARLY_REAL = 1e-6


def is_nearly_real(point: Field) -> bool:
    """Whether a Study point, shape (8,), may be one of a real pose."""
    unit, size = _in_patch(point)
    return bool(np.abs(unit.imag / size).max() < _NEARLY_REAL)


def conjugate_sources(points: Field, low: Field | None = None) -> NDArray[np.intp]:
    """Return for each Study point the index of an earlier conjugate, else its own, shape (k,).

    NaN end points have no conjugate. Points that differ in double precision are no conjugates: near
    many a pose there is another one, where directions are nearly parallel, and its conjugate. The
    same holds for points that differ in further digits, doubles to add, ``low`` (k, m, 8).
    """
    source = np.arange(len(points))
    for i, point in enumerate(points):
        if is_nearly_real(point):
            continue
        k = np.abs(point[:4]).argmax()
        others = points[:i].conj()
        with np.errstate(divide="ignore", invalid="ignore"):
            unit, size = _in_patch(point)
            gaps = np.abs((others / others[:, k : k + 1] - unit) / size).max(axis=1, initial=0.0)
        for j in np.flatnonzero(gaps < _ALIKE).tolist():
            if low is None or not low.shape[1] or are_conjugates(points[[i, j]], low[[i, j]]):
                source[i] = source[j]
                break
    return source


def _in_patch(point: Field) -> tuple[Field, NDArray[np.float64]]:
    """Return a point whose largest coordinate of e is 1, and the sizes of its parts."""
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = point / point[np.abs(point[:4]).argmax()]
        return unit, np.repeat([1.0, np.abs(unit[4:]).max()], 4)


def are_conjugates(points: Complex, low: Complex) -> bool:
    """Whether two points that are conjugates in doubles agree in further digits.

    Parameters
    ----------
    points, low
        The points and doubles to add to them, shapes (2, 8) and (2, k, 8).
    """
    one, other = np.concatenate((points[:, None], low), axis=1)
    k = int(np.abs(one[0, :4]).argmax())
    with ctx.workprec(LAST_PRECISION):
        sums = (Locator.exact_sum(part) for part in (one, other.conj()))
        first, second = ([x / part[k] for x in part] for part in sums)
        gaps = [x - y for x, y in zip(first, second, strict=True)]
        return bool(
            largest(gaps[:4]) < _CONJUGATE and largest(gaps[4:]) < _CONJUGATE * largest(first[4:])
        )
