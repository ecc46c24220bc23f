"""Ends that doubles leave open: in balls, then paths with 32 and with 64 digits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gspcli.continuation.pursuit import joined_ends
from gspcli.solver.side import Index, Side


def simple_ends(side: Side) -> Iterator[None]:
    """Locate the ends of careful paths that are simple beyond doubt, and not proved by the kernel."""
    ends, reached = side.pursuit.first(), side.reached
    simple = ends.simple & ~reached
    side.locate(ends.take(simple))
    yield
    side.astray = np.flatnonzero(~reached & ~simple)
    if side.found.add_close_conjugates():
        yield


def with_32_digits(side: Side) -> Iterator[None]:
    """Follow the paths that have led nowhere with 32 digits."""
    side.astray = yield from followed(side, side.astray, 0)


def with_64_digits(side: Side) -> Iterator[None]:
    """Follow those that have still led nowhere with 64."""
    yield from followed_on(side, side.astray, 0)


def along_other_paths(side: Side) -> Iterator[None]:
    """Follow all paths along other random ones, as long as that leads to more poses."""
    if not len(side.found) and side.left is not None and not side.left.settled.any():
        # All poses are farther away than any paths lead.
        return
    for attempt in range(1, MOST_ATTEMPTS):
        before = len(side.found)
        left = yield from followed(side, np.arange(side.pursuit.paths), attempt)
        yield from followed_on(side, left, attempt)
        if attempt + 1 >= _ATTEMPTS and len(side.found) == before:
            break


#: Sets of random paths that are tried, and at most if each of them leads to more poses.
_ATTEMPTS, MOST_ATTEMPTS = 3, 8


def followed(side: Side, index: Index, attempt: int):
    """Add the poses at the ends of some paths, with 32 digits; return which led to none."""
    new = np.zeros(len(index), np.bool_)
    for which, ends in side.pursuit.deeply(index, side.target, attempt):
        new[which[ends.settled]] = side.add(ends.take(ends.settled))
        yield
    if side.found.add_close_conjugates():
        yield
    # Two paths to one pose: one of them has jumped.
    return index[~new]


def followed_on(side: Side, index: Index, attempt: int) -> Iterator[None]:
    """Add the poses at the ends of some paths, with 64 digits, and keep those of the others."""
    left = []
    for _, ends in side.pursuit.deepest(index, side.target, attempt):
        left.append(ends.take(~side.add(ends)))
        yield
    side.found.add_close_conjugates()
    side.left = joined_ends(left)
    yield
