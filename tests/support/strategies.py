"""What strategies of the solver add, before anything is proved."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np

from gspcli.certification.equations.local_frames import StudyFrames
from gspcli.solver.problem import Problem
from gspcli.solver.search import Search

Strategy = Callable[[Search], None]


class _Recorded(Search):
    """A search that proves nothing."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        self.ends: list[SimpleNamespace] = []

    def add(self, points: np.ndarray, frames: StudyFrames, **rest: Any) -> None:
        self.ends.append(SimpleNamespace(points=points, frames=frames, **rest))


def added(strategy: Strategy, problem: Problem) -> list[SimpleNamespace]:
    """Return all that a strategy adds, with the names of the arguments of `Search.add`."""
    search = _Recorded(problem)
    strategy(search)
    return search.ends


def spoilt(strategy: Strategy, spoil: Callable[[SimpleNamespace], None]) -> Strategy:
    """Return a strategy whose ends are changed before they are added."""

    def changed(search: Search) -> None:
        for ends in added(strategy, search.problem):
            spoil(ends)
            search.add(**vars(ends))

    return changed
