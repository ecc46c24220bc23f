"""Which of several isolated solutions are the same, which are not, which nobody knows yet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from flint import arb

from gspcli.certification.balls import float_ends
from gspcli.certification.isolation import Isolation
from gspcli.certification.poses import PoseBall

#: Fractional parts of multiples of the golden ratio: a linear form that no symmetry respects.
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


def same(first: Isolation, second: Isolation) -> bool:
    """Whether two isolated solutions are proved to be one."""
    return first.contains(second) or second.contains(first)


def _linear_form(pose: PoseBall) -> arb:
    total = arb(0)
    for k, entry in enumerate(pose.entries):
        total += entry.real * _WEIGHTS[2 * k] + entry.imag * _WEIGHTS[2 * k + 1]
    return total


def _overlap(first: PoseBall, second: PoseBall) -> bool:
    return all(x.overlaps(y) for x, y in zip(first.entries, second.entries, strict=True))
