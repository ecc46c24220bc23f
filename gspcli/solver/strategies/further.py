"""What is done about poses that the first strategies leave open, in the order of the cost."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from gspcli.solver.side_poses import FEW, SidePoses
from gspcli.solver.strategies.elimination import by_elimination, early_elimination
from gspcli.solver.strategies.known_poses import from_known_poses
from gspcli.solver.strategies.more_digits import (
    along_other_paths,
    with_32_digits,
    with_64_digits,
    with_more_steps,
)
from gspcli.solver.strategies.special_families import (
    from_larger_bodies,
    from_points_off_lines,
    from_turned_directions,
)

FURTHER: tuple[Callable[[SidePoses], Iterator[None]], ...] = (
    # Poses far away of a platform of the same geometry.
    from_known_poses,
    with_32_digits,
    # Poses far away because directions are nearly parallel, or points nearly on a line.
    from_turned_directions,
    from_points_off_lines,
    # Poses far away because a body is small.
    from_larger_bodies,
    # Eigenvectors, where most paths lead to no pose.
    early_elimination,
    with_64_digits,
    with_more_steps,
    # Eigenvectors with more and more bits.
    by_elimination,
    # Some paths have jumped.
    along_other_paths,
)


def is_exhausted(side: SidePoses) -> bool:
    """Return whether all further strategies have been tried."""
    return side.begun == len(FURTHER)


def go_on(side: SidePoses) -> None:
    """Do the next part of the further strategies, up to where the poses may be all."""
    if side.running is None:
        side.running = FURTHER[side.begun](side)
    if next(side.running, side) is side:
        side.begun, side.running = side.begun + 1, None


def go_on_until(
    side: SidePoses, last: Callable[[SidePoses], Iterator[None]], most: int | None = None
) -> None:
    """Go on as long as poses are missing.

    Parameters
    ----------
    side
        The poses for a choice of sides.
    last
        The last of the further strategies that may be used.
    most
        How many poses there can be, if that is known.
    """
    paths, end = side.paths.count, FURTHER.index(last) + 1
    side.most = most
    while side.begun < end:
        found = len(side.found)
        missing = min(paths - found - len(side.infinite), (most or paths) - found)
        if missing <= 0:
            break
        # Eigenvectors are the last way to many poses that no path leads to.
        tried = by_elimination if side.all_simple else with_more_steps
        if side.begun > FURTHER.index(tried) and missing * FEW > paths:
            break
        go_on(side)
