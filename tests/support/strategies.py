"""What strategies of the solver add, before anything is proved."""

from __future__ import annotations

from collections.abc import Callable

from gspcli.solver.poses import Ends
from gspcli.solver.problem import Problem
from gspcli.solver.search import Search

Strategy = Callable[[Search], None]


class _Recorded(Search):
    """A search that proves nothing."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        self.ends: list[Ends] = []

    def add(self, ends: Ends) -> None:
        self.ends.append(ends)


def added(strategy: Strategy, problem: Problem) -> list[Ends]:
    """Return all ends that a strategy adds."""
    search = _Recorded(problem)
    strategy(search)
    return search.ends


def spoilt(strategy: Strategy, spoil: Callable[[Ends], None]) -> Strategy:
    """Return a strategy whose ends are changed before they are added."""

    def changed(search: Search) -> None:
        for ends in added(strategy, search.problem):
            spoil(ends)
            search.add(ends)

    return changed
