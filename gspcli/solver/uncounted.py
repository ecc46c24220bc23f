"""How long to go on with a system in special position whose solutions nobody has counted."""

from __future__ import annotations

from gspcli.solver.side import Side

#: If at most one path in so many is missing, paths jumped rather than that the platform is special:
#: other paths find what is missing. Otherwise no count says whether more means would find more.
FEW = 50
#: The place of the last strategy that follows the paths with more digits.
_WITH_64_DIGITS = 3


def until(side: Side, last: int, most: int | None = None) -> None:
    """Run long strategies up to one by its place, as long as poses are missing.

    Parameters
    ----------
    side, last
        The poses, and the last strategy that is worth it.
    most
        How many there can be, if that is known.
    """
    paths = side.pursuit.paths
    for place in side.steps:
        found = len(side.found)
        missing = min(paths - found - len(side.infinite), (most or paths) - found)
        if missing <= 0 or place > last:
            break
        if place > _WITH_64_DIGITS and missing * FEW > paths:
            break
