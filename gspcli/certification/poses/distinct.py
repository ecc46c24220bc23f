"""Comparison of isolated solutions: proved the same, proved different, or undecided."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from flint import arb
from numpy.typing import NDArray

from gspcli.certification.equations.pose_balls import PoseBall
from gspcli.certification.numbers.balls import float_ends
from gspcli.certification.numbers.rounding import OUTWARD
from gspcli.certification.poses.isolation import Isolation

#: Fractional parts of multiples of the golden ratio: a linear form without symmetries.
_WEIGHTS = tuple((k * 0.6180339887498949) % 1 for k in range(1, 25))


def close_pairs(poses: Sequence[PoseBall]) -> Iterator[tuple[int, int]]:
    """Yield the pairs of poses, by ascending indices, whose balls have a common point.

    All other pairs are proved to be different poses. A linear form of the 24 real numbers of a
    pose sorts them first, so that n poses do not cost n^2 comparisons.
    """
    ends = [float_ends(_linear_form(pose)) for pose in poses]
    order = sorted(range(len(poses)), key=lambda k: ends[k][0])
    for position, first in enumerate(order):
        for second in order[position + 1 :]:
            if ends[second][0] > ends[first][1]:
                break
            if _overlap(poses[first], poses[second]):
                yield min(first, second), max(first, second)


@np.errstate(all="ignore")
def all_different(entries: NDArray[np.complex128], deviations: NDArray[np.float64]) -> bool:
    """Whether poses with error bounds are proved to be pairwise different.

    Parameters
    ----------
    entries
        The entries of R, and of T divided by the scale, shape (n, 12).
    deviations
        Bounds of their errors, shape (n,).
    """
    low, high = _intervals(entries, deviations)
    if not np.isfinite(high - low).all():
        return False
    order = np.argsort(low)
    following = np.searchsorted(low[order], high[order], side="right")
    for position, end in enumerate(following.tolist()):
        others = order[position + 1 : end]
        if len(others):
            first = order[position]
            gaps = np.abs(entries[others] - entries[first]).max(axis=1)
            if not (gaps > (deviations[others] + deviations[first]) * OUTWARD).all():
                return False
    return True


@np.errstate(all="ignore")
def are_different(
    entries: NDArray[np.complex128], deviations: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Whether a linear form proves all poses different, for each of many sets of them, (b,).

    Parameters
    ----------
    entries, deviations
        As for `all_different`, shapes (b, n, 12) and (b, n).
    """
    low, high = _intervals(entries, deviations)
    order = low.argsort(axis=1)
    low, high = (np.take_along_axis(x, order, axis=1) for x in (low, high))
    # What is not a number proves nothing.
    return np.asarray((high[:, :-1] < low[:, 1:]).all(axis=1) & np.isfinite(high - low).all(axis=1))


def _intervals(
    entries: NDArray[np.complex128], deviations: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the ends of the intervals in which a linear form of each pose is, shapes (..., n)."""
    parts = np.concatenate((entries.real, entries.imag), axis=-1)
    weights = np.array(_WEIGHTS)
    forms = parts @ weights
    # The error of the form, with its few roundings.
    reach = (weights.sum() * deviations + (OUTWARD - 1) * (np.abs(parts) @ weights)) * OUTWARD
    return forms - reach, forms + reach


@np.errstate(all="ignore")
def places(
    entries: NDArray[np.complex128], deviations: NDArray[np.float64], known: int
) -> NDArray[np.intp]:
    """Return for each of n poses the first one from which it is not proved different, shape (n,).

    Parameters
    ----------
    entries, deviations
        As for `all_different`.
    known
        The first poses, in this number, are proved to be different.
    """
    low, high = _intervals(entries, deviations)
    unknown = ~np.isfinite(high - low)
    low, high = np.where(unknown, -np.inf, low), np.where(unknown, np.inf, high)
    order = np.argsort(low)
    following = np.searchsorted(low[order], high[order], side="right")
    alike: dict[int, list[int]] = {}
    for position in np.flatnonzero(following > np.arange(len(order)) + 1).tolist():
        first, others = int(order[position]), order[position + 1 : following[position]]
        gaps = np.abs(entries[others] - entries[first]).max(axis=1)
        apart = gaps > (deviations[others] + deviations[first]) * OUTWARD
        for other in others[~apart].tolist():
            alike.setdefault(max(first, other), []).append(min(first, other))
    found = np.arange(len(entries))
    for k in sorted(alike):
        if k >= known:
            # Only poses that have a place of their own.
            there = [j for j in alike[k] if found[j] == j]
            found[k] = min(there, default=k)
    return found


def same(first: Isolation, second: Isolation) -> bool:
    """Whether two isolated solutions are proved to be the same."""
    return first.contains(second) or second.contains(first)


def _linear_form(pose: PoseBall) -> arb:
    total = arb(0)
    for k, entry in enumerate(pose.entries):
        total += entry.real * _WEIGHTS[2 * k] + entry.imag * _WEIGHTS[2 * k + 1]
    return total


def _overlap(first: PoseBall, second: PoseBall) -> bool:
    return all(x.overlaps(y) for x, y in zip(first.entries, second.entries, strict=True))
