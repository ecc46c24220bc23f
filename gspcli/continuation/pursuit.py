"""The paths to one system, followed as carefully as somebody asks who can judge their ends."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from itertools import groupby, islice

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.accounts import (
    all_regular,
    random_start,
    regular_ends,
    settle,
)
from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.regularity import clearly_simple
from gspcli.continuation.solutions import SystemSolutions, solutions_of
from gspcli.continuation.start import StartSystem, start_system
from gspcli.continuation.systems import Coefficients, System
from gspcli.continuation.tracker import DEEP, DEFAULT, PathResults, TrackerOptions, track

_BATCH = 256
_BATCH_PATHS = 65_536


@dataclass(frozen=True, eq=False)
class PursuedEnds:
    """Where k paths ended, simple solutions or not.

    Attributes
    ----------
    points
        Study points in the coordinates of the target, of any norm, shape (k, 8).
    low
        What more digits than those of doubles add to them, shape (k, 8); zero if there are none.
    simple
        Which are beyond doubt simple solutions of the system in doubles, shape (k,).
    """

    points: ComplexArray
    low: ComplexArray
    simple: NDArray[np.bool_]

    def take(self, index: NDArray[np.bool_]) -> PursuedEnds:
        """Return some of the ends."""
        return PursuedEnds(self.points[index], self.low[index], self.simple[index])


class Pursuit:
    """The paths from the start system of a structure to one target.

    Parameters
    ----------
    start
        The start system.
    target
        The equations in canonical order, balanced.
    scale
        The unit of f in them (`Coefficients.balanced`).
    results
        The first attempt at all paths, (1, P).
    is_regular
        Whether all of them end at distinct finite regular solutions, as well as doubles tell.
    seed, jobs
        Source of random paths; threads.
    """

    def __init__(
        self,
        start: StartSystem,
        target: System,
        scale: float,
        results: PathResults,
        is_regular: bool,
        seed: int,
        jobs: int,
    ) -> None:
        self.is_regular = is_regular
        self.scale = scale
        self.seed = seed
        self._start = start
        self._target = target
        self._results = results
        self._jobs = jobs

    @property
    def paths(self) -> int:
        """The number of paths: the generic count of the structure."""
        return len(self._start.points)

    def first(self) -> PursuedEnds:
        """Return the ends of the first attempt at all paths."""
        return self._ends(self._results)

    def deeply(self, index: NDArray[np.intp], attempt: int = 0) -> PursuedEnds:
        """Follow some paths with 32 digits up to the target itself.

        Parameters
        ----------
        index
            Which paths, shape (k,).
        attempt
            Another number leads the same start points along other paths.
        """
        results = track(
            random_start(self._start, self.seed, attempt),
            self._target,
            self._start.points[index],
            options=DEEP,
            jobs=self._jobs,
        )
        return self._ends(results)

    def solutions(self) -> SystemSolutions:
        """Return where all paths end, by the means of numerical path tracking alone."""
        if self.is_regular:
            ends = regular_ends(self._results, 0)
        else:
            ends = settle(self._start, self._target, self._results, self.seed, self._jobs)
        return solutions_of(ends, self.scale, self.seed)

    def _ends(self, results: PathResults) -> PursuedEnds:
        points = results.points[0].copy()
        low = results.low[0].copy() if len(results.low) else np.zeros_like(points)
        for part in (points, low):
            part[:, 4:] *= self.scale
        return PursuedEnds(points, low, clearly_simple(results)[0])


def pursue(
    targets: Iterable[System],
    *,
    seed: int,
    jobs: int = 1,
    options: TrackerOptions = DEFAULT,
) -> Iterator[Pursuit]:
    """Yield the first attempt at the paths of many systems, in order.

    Consecutive systems of one structure are tracked together, which is what makes this quicker
    than a loop.

    Parameters
    ----------
    targets, seed, jobs, options
        As for `gspcli.continuation.solve.solve_systems`.
    """
    for structure, group in groupby(targets, key=lambda target: target.structure):
        start = start_system(structure.canonical())
        size = max(1, min(_BATCH, _BATCH_PATHS // len(start.points)))
        while batch := list(islice(group, size)):
            given = Coefficients.stacked([target.canonical() for target in batch])
            balanced, scale = given.balanced()
            results = track(
                random_start(start, seed, 0),
                balanced,
                start.points,
                options=options,
                jobs=jobs,
            )
            regular = all_regular(results).tolist()
            for i in range(len(batch)):
                row = PathResults(*(getattr(results, f.name)[i : i + 1] for f in fields(results)))
                target = System(start.system.structure, balanced.take(i))
                yield Pursuit(start, target, float(scale[i]), row, regular[i], seed, jobs)
