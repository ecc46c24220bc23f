"""Ways to the poses of a platform, in the order of what they cost: the contents of the solver.

The first ones yield ends for all choices of sides, of which the ledger proves what the kernel can;
they know no proof and no count. The others go on from what is proved for one choice of sides, and
yield whenever that may be enough.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from enum import IntEnum
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gspcli.solver.ledger import Ends
    from gspcli.solver.problem import Problem
    from gspcli.solver.side import Side

    Strategy = Callable[[Problem], Iterator[Ends]]


class Further(IntEnum):
    """Strategies for what the first ones leave, each named by its function."""

    IN_BALLS = 0
    """Ends that are simple beyond doubt, but which double precision does not prove."""
    WITH_32_DIGITS = 1
    """Paths that have led nowhere, with 32 digits."""
    FROM_TURNED_DIRECTIONS = 2
    """Poses far away because directions are nearly parallel."""
    EARLY_ELIMINATION = 3
    """Eigenvectors, where most paths lead nowhere."""
    WITH_64_DIGITS = 4
    """Paths that have still led nowhere, with 64 digits."""
    BY_ELIMINATION = 5
    """Eigenvectors with more and more bits."""
    ALONG_OTHER_PATHS = 6
    """All paths along other random ones, where some have jumped."""


_ROOM = "gspcli.solver.strategies"
_FURTHER = {
    Further.IN_BALLS: "more_digits",
    Further.WITH_32_DIGITS: "more_digits",
    Further.FROM_TURNED_DIRECTIONS: "turned_directions",
    Further.EARLY_ELIMINATION: "elimination",
    Further.WITH_64_DIGITS: "more_digits",
    Further.BY_ELIMINATION: "elimination",
    Further.ALONG_OTHER_PATHS: "more_digits",
}


def first_strategies(problem: Problem) -> Iterator[Strategy]:
    """Yield those that suit a platform, each imported when it is needed."""
    if problem.has_closed_form:
        # Three angles: all rotations, then all translations.
        yield _named("closed_form", "closed_form")
    elif problem.has_kept_geometry:
        # Planar or symmetric bodies, shared joints: from the second platform of a geometry on.
        yield _named("same_geometry", "same_geometry")
    if problem.is_reducible and not problem.has_closed_form:
        # Points, planes and angles in general position.
        yield _named("stored_start", "reduced_paths")
    elif not problem.has_closed_form:
        # Lines in general position.
        yield _named("stored_start", "short_series")
    # Everything else, with all the care that double precision allows.
    yield _named("stored_start", "careful_paths")


def further_strategies(side: Side) -> Iterator[Further]:
    """Run one of the others after the other; yield before each, and within it."""
    for place, module in _FURTHER.items():
        yield place
        for _ in _named(module, place.name.lower())(side):
            yield place


def _named(module: str, name: str) -> Callable[..., Iterator[Any]]:
    strategy: Callable[..., Iterator[Any]] = getattr(import_module(f"{_ROOM}.{module}"), name)
    return strategy
