"""The paths to one system, tracked with 16 or 32 digits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from itertools import groupby, islice

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.accounts import classify_endpoints
from gspcli.continuation.endpoints import (
    ACCOUNTS,
    AccountOptions,
    all_regular,
    random_start,
    regular_ends,
)
from gspcli.continuation.ends import infinite, regular_error
from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.regularity import clearly_simple
from gspcli.continuation.retracked_paths import collided, retracked
from gspcli.continuation.solutions import SystemSolutions, solutions_of
from gspcli.continuation.start import StartSystem, start_system
from gspcli.continuation.systems import Coefficients, FineCoefficients, System
from gspcli.continuation.tracker import PathResults, PathStatus, track
from gspcli.continuation.tracker_options import (
    CAREFUL,
    DEEP,
    DEFAULT,
    TrackerOptions,
)
from gspcli.defaults import SEED
from gspcli.records import dataclass

#: Newton's method has converged if its last correction is at most this part of e.
_CONVERGES = 1e-3
#: Distances from the target below which doubles may not distinguish paths.
_NEAR = 1e-3
#: Steps from near the target within which most paths arrive that do not end at infinity.
_FEW_STEPS = 12
_BATCH = 256
_BATCH_PATHS = 65_536


@dataclass(frozen=True, eq=False)
class PathEnds:
    """The ends of k paths, simple solutions or not.

    Attributes
    ----------
    points
        Study points in the coordinates of the target, of any norm, shape (k, 8).
    low
        The digits beyond doubles: one more double to add, shape (k, 1, 8); (k, 0, 8) if there
        are none.
    simple
        Which are clearly simple solutions of the system in doubles, shape (k,).
    converged
        Whether Newton's method converges, with these digits, shape (k,).
    digits
        The number of digits of the computation.
    """

    points: ComplexArray
    low: ComplexArray
    simple: NDArray[np.bool_]
    converged: NDArray[np.bool_]
    digits: int

    def take(self, index: NDArray[np.bool_] | NDArray[np.intp]) -> PathEnds:
        """Return some of the ends."""
        return PathEnds(
            self.points[index],
            self.low[index],
            self.simple[index],
            self.converged[index],
            self.digits,
        )


class TrackedPaths:
    """The paths from the start system of a structure to one target.

    Parameters
    ----------
    start
        The start system.
    target
        The equations in canonical order, balanced.
    scale
        The unit of f in them (`Coefficients.balanced`).
    sizes
        The divisors of their factors, shape (6,) each.
    results
        The first attempt at all paths, (1, P).
    is_regular
        Whether all of them end at distinct finite regular solutions, by doubles.
    seed, jobs
        Source of random paths; threads.
    """

    def __init__(
        self,
        start: StartSystem,
        target: System,
        scale: float,
        sizes: tuple[FloatArray, FloatArray],
        results: PathResults,
        is_regular: bool,
        seed: int,
        jobs: int,
    ) -> None:
        self.is_regular = is_regular
        self.scale = scale
        self._sizes = sizes
        self.seed = seed
        self._start = start
        self._target = target
        self._results = results
        self._jobs = jobs

    @property
    def count(self) -> int:
        """The number of paths: the generic count of the structure."""
        return len(self._start.points)

    def first(self) -> PathEnds:
        """Return the ends of the first attempt at all paths."""
        return self._ends(self._results, DEFAULT.digits)

    def distinct_simple(self) -> ComplexArray:
        """Return the ends of the first attempt that no other path shares, shape (k, 8).

        They are finite and clearly simple solutions of the system in doubles.
        """
        results = self._results
        points, error = results.points[0], regular_error(results.correction[0])
        chosen = clearly_simple(results)[0] & ~infinite(points, error)
        chosen &= ~collided(points, error, chosen)
        ends: ComplexArray = self.first().points[chosen]
        return ends

    def balanced(self, given: Coefficients) -> Coefficients:
        """Return equations with more digits in the form in which they are tracked.

        Parameters
        ----------
        given
            The coefficients in canonical order: arrays of objects, no leading axes.
        """
        return given.in_units(np.array(self.scale)).divided(*self._sizes)

    def track(
        self,
        index: NDArray[np.intp],
        target: FineCoefficients,
        *,
        attempt: int = 0,
    ) -> Iterator[tuple[NDArray[np.intp], PathEnds]]:
        """Track some paths with more digits up to the target, from where fewer digits may fail.

        Parameters
        ----------
        index
            Which paths, shape (k,).
        target
            The equations (`balanced`).
        attempt
            Another number gives other paths from the same start points.

        Yields
        ------
        The paths that arrive after few steps, and their ends; then the other paths, arrived or not,
        and their ends. Most paths to infinity never arrive.
        """
        origin = random_start(self._start, self.seed, attempt)
        points, left = self._near(origin, target, index)
        yield from self._in_parts(origin, target, points, None, left, DEEP)

    def _in_parts(
        self,
        origin: System,
        target: FineCoefficients,
        points: ComplexArray,
        low: ComplexArray | None,
        left: FloatArray,
        options: TrackerOptions,
    ) -> Iterator[tuple[NDArray[np.intp], PathEnds]]:
        """Yield the paths that arrive after few steps, and their ends, then the other paths.

        Parameters
        ----------
        origin, points, low, left, options
            As for `track`.
        target
            The equations (`balanced`).
        """
        rest, limit = np.arange(len(points)), _FEW_STEPS
        while True:
            results = track(
                origin,
                target.high,
                points,
                more=target.more,
                low=low,
                left=left,
                options=replace(options, max_steps=min(limit, options.max_steps)),
                jobs=self._jobs,
            )
            ends = self._ends(results, options.digits)
            arrived = results.status[0] == PathStatus.REGULAR
            if limit >= options.max_steps or arrived.all():
                yield rest, ends
                return
            yield rest[arrived], ends.take(arrived)
            # The others continue from where they stopped.
            rest, limit = rest[~arrived], options.max_steps
            points, low, left = (
                x[0, ~arrived] for x in (results.points, results.low, results.left)
            )

    def _near(
        self, origin: System, target: FineCoefficients, index: NDArray[np.intp]
    ) -> tuple[ComplexArray, FloatArray]:
        """Return the last points of some paths that doubles can reach, and the rest of the way."""
        near = System(origin.structure, target.nearby(origin.coefficients, _NEAR))
        points = self._start.points[index]
        results = track(origin, near, points, options=CAREFUL, jobs=self._jobs)
        arrived = results.status[0] == PathStatus.REGULAR
        there = np.where(arrived[:, None], results.points[0], points)
        return there, np.where(arrived, _NEAR, 1.0)

    def solutions(self, options: AccountOptions = ACCOUNTS) -> SystemSolutions:
        """Return the ends of all paths by numerical path tracking only."""
        if self.is_regular:
            ends = regular_ends(self._results, 0)
        else:
            ends = classify_endpoints(
                self._start, self._target, self._results, self.seed, self._jobs, options
            )
        return solutions_of(ends, self.scale, self.seed)

    def _ends(self, results: PathResults, digits: int) -> PathEnds:
        points = results.points[0].copy()
        low = results.low[0].copy() if len(results.low) else np.zeros((len(points), 0, 8), complex)
        for part in (points, low):
            part[..., 4:] *= self.scale
        # The correction is negative if Newton's method was not run.
        correction, e = results.correction[0], np.abs(results.points[0, :, :4]).max(axis=1)
        converged = (correction >= 0) & (correction < _CONVERGES * e)
        return PathEnds(points, low, clearly_simple(results)[0], converged, digits)


def solve_systems(targets: Iterable[System], *, seed: int = SEED) -> Iterator[SystemSolutions]:
    """Yield the solutions of many systems, in order, as they become known.

    Each result has all isolated solutions, and evidence of any others. Consecutive systems of one
    structure are tracked together, which is quicker than a loop. Lost paths are tracked again with
    `CAREFUL` and `PARANOID`. Another seed gives the same solutions.
    """
    for tracked_paths in track_all(targets, seed=seed):
        yield tracked_paths.solutions()


def track_all(
    targets: Iterable[System],
    *,
    seed: int,
    jobs: int = 1,
    options: TrackerOptions = DEFAULT,
) -> Iterator[TrackedPaths]:
    """Yield the first attempt at the paths of many systems, in order.

    Consecutive systems of one structure are tracked together, which is quicker than a loop.

    Parameters
    ----------
    targets
        The systems; real ones have solutions in conjugate pairs.
    seed
        Source of the random paths. Another seed gives the same solutions.
    jobs
        Threads. The result does not depend on them.
    options
        Settings of the first attempt.
    """
    for structure, group in groupby(targets, key=lambda target: target.structure):
        start = start_system(structure.canonical())
        size = max(1, min(_BATCH, _BATCH_PATHS // len(start.points)))
        while batch := list(islice(group, size)):
            given = Coefficients.stacked([target.canonical() for target in batch])
            balanced, scale = given.balanced()
            sizes = given.in_units(scale).sizes()
            origin = random_start(start, seed, 0)
            attempts = first_attempts(origin, balanced, start.points, options=options, jobs=jobs)
            for i, (row, regular) in enumerate(attempts):
                target = System(start.system.structure, balanced.take(i))
                divisors = sizes[0][i], sizes[1][i]
                yield TrackedPaths(
                    start, target, float(scale[i]), divisors, row, regular, seed, jobs
                )


def first_attempts(
    origin: System,
    targets: Coefficients,
    points: ComplexArray,
    *,
    options: TrackerOptions,
    jobs: int,
) -> Iterator[tuple[PathResults, bool]]:
    """Yield the ends of paths from the solutions of a system to each of B targets.

    Parameters
    ----------
    origin, targets, points, options, jobs
        As for `track`.

    Yields
    ------
    The ends (1, P), after a second attempt at the few wrong paths, and whether all are
    distinct finite regular solutions, by doubles.
    """
    results = track(origin, targets, points, options=options, jobs=jobs)
    for i, regular in enumerate(all_regular(results).tolist()):
        row = PathResults(*(getattr(results, f.name)[i : i + 1] for f in fields(results)))
        if not regular:
            row = retracked(origin, System(origin.structure, targets.take(i)), points, row, jobs)
            regular = bool(all_regular(row)[0])
        yield row, regular
