"""What is done about poses that the first strategies leave open, in the order of the cost."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from gspcli.solver.side_poses import SidePoses
from gspcli.solver.strategies.elimination import by_elimination, early_elimination
from gspcli.solver.strategies.more_digits import (
    along_other_paths,
    with_32_digits,
    with_64_digits,
    with_more_steps,
)
from gspcli.solver.strategies.special_families import (
    from_points_off_lines,
    from_turned_directions,
)

FURTHER: tuple[Callable[[SidePoses], Iterator[None]], ...] = (
    with_32_digits,
    # Poses far away because directions are nearly parallel, or points nearly on a line.
    from_turned_directions,
    from_points_off_lines,
    # Eigenvectors, where most paths lead to no pose.
    early_elimination,
    with_64_digits,
    with_more_steps,
    # Eigenvectors with more and more bits.
    by_elimination,
    # Some paths have jumped.
    along_other_paths,
)
