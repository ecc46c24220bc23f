"""Ways to the poses of a platform, in the order of what they cost: the contents of the solver.

Short ones yield ends for all choices of sides, of which the ledger proves what the kernel
can; they know no proof and no count. Long ones go on with one choice of sides from what is
proved, and yield whenever somebody may have enough.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from gspcli.solver.ledger import Ends
from gspcli.solver.problem import Problem
from gspcli.solver.solved_starts import STARTS

if TYPE_CHECKING:
    from gspcli.solver.side import Side

Short = Callable[[Problem], Iterator[Ends]]


def short_strategies(problem: Problem) -> Iterator[Short]:
    """Yield those that suit a platform; each is imported when it is needed."""
    if problem.has_closed_form:
        # All rotations, then all translations.
        from gspcli.solver.strategies.closed_form import closed_form

        yield closed_form
    elif STARTS.platform(problem.arrangement) and problem.is_kept and problem.limit != 0:
        # Planar or symmetric bodies, shared joints: from the second time on.
        from gspcli.solver.strategies.same_geometry import same_geometry

        yield same_geometry
    if problem.is_reducible and not problem.has_closed_form:
        # Anything in general position.
        from gspcli.solver.strategies.stored_start import quick_paths

        yield quick_paths
    elif not problem.has_closed_form:
        from gspcli.solver.strategies.stored_start import short_series

        yield short_series
    from gspcli.solver.strategies.careful_paths import careful_paths

    yield careful_paths


def long_strategies() -> tuple[Callable[[Side], Iterator[None]], ...]:
    """Return the others, which most platforms do not need."""
    from gspcli.solver.strategies import elimination, more_digits

    return (
        more_digits.simple_ends,  # in balls what the kernel does not prove
        more_digits.with_32_digits,
        elimination.early_elimination,  # where most paths lead nowhere
        more_digits.with_64_digits,
        elimination.elimination,
        more_digits.along_other_paths,  # where paths have jumped
    )


def steps(side: Side) -> Iterator[int]:
    """Run one long strategy after the other; yield the place of each before and within it."""
    for place, strategy in enumerate(long_strategies()):
        yield place
        for _ in strategy(side):
            yield place
