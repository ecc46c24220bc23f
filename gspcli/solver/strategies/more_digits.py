"""Paths that have led to no pose in double precision: with 32 and with 64 digits."""

from __future__ import annotations

from collections.abc import Generator, Iterator

import numpy as np

from gspcli.continuation.tracked_paths import joined_ends
from gspcli.solver.side_poses import FEW, Index, SidePoses
from gspcli.solver.strategies.elimination import can_eliminate, is_eliminable, is_small

#: A platform that is special up to less than one in this many has poses where N is below 1e-32.
_DECIMALS = 10**9
#: Steps with 64 digits after which the paths that lead to poses have arrived: where three lines are
#: parallel up to 1e-5, one path in three takes more than `DEEPEST` has.
_STEPS = 2000
#: Sets of random paths that are tried, and at most if each of them leads to more poses.
_ATTEMPTS, _MOST_ATTEMPTS = 3, 8


def with_32_digits(side: SidePoses) -> Iterator[None]:
    """Follow with 32 digits the paths whose ends in double precision are not proved.

    That some of these ends are simple beyond doubt, and could be proved in balls, gains nothing:
    on 238 special platforms it added no pose.
    """
    count = side.paths.count
    reached = side.reached if len(side.reached) == count else np.zeros(count, np.bool_)
    side.unresolved = np.flatnonzero(~reached)
    if is_eliminable(side) and (is_small(side) or _has_many_decimals(side)):
        # If the platform is special, it is so up to less than 32 digits show. Then paths would take
        # a quarter of the time of a first solution and find no pose.
        return
    side.unresolved = yield from _followed(side, side.unresolved, 0)


def _has_many_decimals(side: SidePoses) -> bool:
    """Whether coordinates are written with more decimals than paths with 32 digits tell."""
    for primitive in side.problem.instance.primitives:
        for number in (*primitive.position, *getattr(primitive, "vector", ())):
            if (known := number.fraction) is not None and known.denominator > _DECIMALS:
                return True
    return False


def with_64_digits(side: SidePoses) -> Iterator[None]:
    """Follow with 64 digits the paths that have led to no pose with 32."""
    side.unresolved = yield from _followed_on(side, side.unresolved, 0)


def with_more_steps(side: SidePoses) -> Iterator[None]:
    """Follow with more steps the paths that have not arrived, if half of them lead to poses.

    Paths to multiple poses, and most of those to infinity, never arrive. Elimination is quicker
    where the platform is not too large for it.
    """
    if can_eliminate(side):
        return
    at_infinity = side.paths.count - (side.most or 0)
    if side.all_simple and len(side.unresolved) >= max(1, 2 * at_infinity):
        yield from _followed_on(side, side.unresolved, 0, _STEPS)


def along_other_paths(side: SidePoses) -> Iterator[None]:
    """Follow all paths in other random ways, as long as that leads to more poses."""
    if not len(side.found) and side.left is not None and not side.left.converged.any():
        # All poses are farther away than any paths lead.
        return
    missing = (side.most or side.paths.count) - len(side.found)
    if not can_eliminate(side) and len(side.unresolved) >= missing > side.paths.count / FEW:
        # The paths to them have not arrived, and none has jumped.
        return
    for attempt in range(1, _MOST_ATTEMPTS):
        before = len(side.found)
        left = yield from _followed(side, np.arange(side.paths.count), attempt)
        yield from _followed_on(side, left, attempt)
        if attempt + 1 >= _ATTEMPTS and len(side.found) == before:
            break


def _followed(side: SidePoses, index: Index, attempt: int) -> Generator[None, None, Index]:
    """Add the poses at the ends of some paths, with 32 digits; return which led to none."""
    new = np.zeros(len(index), np.bool_)
    for which, ends in side.paths.track(index, side.target, digits=32, attempt=attempt):
        new[which[ends.converged]] = side.add(ends.take(ends.converged))
        yield
    if side.found.add_close_conjugates():
        yield
    # Two paths to one pose: one of them has jumped.
    return index[~new]


def _followed_on(
    side: SidePoses, index: Index, attempt: int, steps: int | None = None
) -> Generator[None, None, Index]:
    """Add the poses at the ends of some paths, with 64 digits, and keep those of the others.

    Return which paths have not arrived.
    """
    left, open_ = [], [np.arange(0)]
    parts = side.paths.track(index, side.target, digits=64, attempt=attempt, steps=steps)
    for which, ends in parts:
        left.append(ends.take(~side.add(ends)))
        open_.append(index[which[~ends.converged]])
        yield
    side.found.add_close_conjugates()
    side.left = joined_ends(left)
    yield
    return np.concatenate(open_)
