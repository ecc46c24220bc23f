"""Spurious solutions: the lines of a DLL are parallel and have another distance.

``M^2 + d^2 C^2 = d^2`` holds for parallel lines, because M and the sine are zero. Such solutions
are counted by inclusion and exclusion: for sets of DLL the solutions are counted at which certain
functions do not vanish.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain, combinations

from gspcli.certification.counting.motion_equations import MotionEquation
from gspcli.certification.counting.residue_counts import ResidueCount

#: The most DLL whose lines may be parallel together.
_MOST = 3


def spurious(
    lines: Sequence[tuple[MotionEquation, MotionEquation]],
    result: ResidueCount,
    run: Callable[..., ResidueCount],
) -> tuple[int, int] | None:
    """Return the number of spurious solutions, with multiplicity and distinct.

    Parameters
    ----------
    lines
        For each DLL the functions that vanish if its lines are parallel, and if they have its
        distance.
    result
        A count with the first of these as conditions, each a group of its own.
    run
        A function that counts again with other `conditions` and `groups`.

    Returns
    -------
    tuple or None
        None if it is not known.
    """
    if result.distinct is None or len(result.apart) < len(lines):
        return None
    singular = [
        pair for pair, (n, _) in zip(lines, result.apart, strict=True) if n < result.solutions
    ]
    if not singular:
        return 0, 0
    if len(singular) > _MOST:
        return None
    # Condition 2 k is the crossing of the k-th DLL, and 2 k + 1 its distance. Solutions that are
    # spurious for all of J: all crossings vanish, and no distance does.
    terms: list[tuple[int, list[int]]] = []
    for bad in _subsets(range(len(singular))):
        for crossed in _subsets(bad):
            if bad:
                sign = -1 if (len(bad) + 1 + len(crossed)) % 2 else 1
                group = [2 * k + 1 for k in bad] + [2 * k for k in crossed]
                terms.append((sign, group))
    conditions = [condition for pair in singular for condition in pair]
    found = run(conditions=conditions, groups=[group for _, group in terms])
    if len(found.apart) < len(terms):
        return None
    counts = [sign * n for (sign, _), (n, _) in zip(terms, found.apart, strict=True)]
    distinct = [sign * n for (sign, _), (_, n) in zip(terms, found.apart, strict=True)]
    return sum(counts), sum(distinct)


def _subsets(items: Sequence[int]) -> list[tuple[int, ...]]:
    return list(chain.from_iterable(combinations(items, n) for n in range(len(items) + 1)))
