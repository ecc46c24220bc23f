"""A search for platforms with many real solutions.

After P. Dietmaier (1998): take a conjugate pair of solutions that is close to a fold, move the
platform so that the pair comes together and becomes real, and keep all real solutions from
coming together meanwhile. A step is the shortest change of the platform's numbers that does this
to first order (`gspcli.reality.fold_distances`), of limited length. After each step all solutions
are followed along a random complex path; the search accepts no step that loses a real one.

It works on reduced platforms (`gspcli.reality.platforms`).
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, Kind
from gspcli.continuation.systems import Structure
from gspcli.defaults import SEED
from gspcli.geometry.shortest_step import shortest_step
from gspcli.reality.fold_distances import Folds, moved
from gspcli.reality.patterns import Pattern
from gspcli.reality.platforms import Platforms, random_platforms, reduced
from gspcli.reality.solved_platforms import Solved, followed_from, solved
from gspcli.records import dataclass
from gspcli.workers import HERE, Workers

Array = NDArray[np.float64]

#: Sizes of random platforms, in turn by the number of the attempt. Types with distances of points
#: and lines begin with the small ones, which have more real solutions there.
_SIZES = (1.0, 0.3)
#: Real solutions are kept this far from folds, or if they are nearer, ...
_MARGIN = 0.005
#: ... moved away by the first factor. For a given platform they are kept beyond the second factor
#: only: near limits too many folds are near to move away from all of them.
_GROWTH, _LEEWAY = 1.3, 0.8
#: First, largest and smallest length of a step; numbers are of the order of one.
_RADIUS, _MAX_RADIUS, _MIN_RADIUS = 0.05, 0.3, 1e-3
#: The largest ratio of the shortest step for a pair to its part towards the fold.
_DETOUR = 4.0
#: Mean rank, by distance, of the conjugate pair that a step brings together.
_RANK = 2.0
#: One of this many attempts begins with a random platform; the others begin with the best known
#: platform, with random changes of about one of these sizes.
_TURNS, _SHAKES = 4, (0.0, 0.01, 0.03, 0.06, 0.1)
#: An attempt ends after this many steps without a new real pair.
_PATIENCE = 200
#: Solutions are followed from those of the last platform; after this many steps all are solved.
_AFRESH = 50
#: Limits of the numbers: points, distances, and the least difference from 1 of a cosine.
_LARGEST, _SMALLEST, _COSINE = 4.0, 0.02, 1e-3
#: Distance to folds up to which a finished platform is improved, and with how many steps.
_COMFORT, _IMPROVEMENTS = 0.03, 60


def _acceptable(platform: Platforms, limit: float = _LARGEST) -> bool:
    """Return whether the numbers of a platform are neither too large nor degenerate."""
    values = np.abs(platform.values)
    distance = np.array([kind.is_distance for kind in platform.kinds])
    smallest = np.where([kind in (DPH, DHP, DLL) for kind in platform.kinds], 0.0, _SMALLEST)
    return bool(
        _largest(platform) < limit
        and (values >= np.where(distance, smallest, 0.0)).all()
        and (values[~distance] < 1 - _COSINE).all()
    )


def _largest(platform: Platforms) -> float:
    """Return the largest number of a platform."""
    parts = (platform.y, platform.x, platform.values)
    return max(float(np.abs(part).max()) for part in parts)


def _centred(platform: Platforms) -> Platforms:
    """Return a platform with origins in the middle of its points, of which few may be far."""
    distance = np.array([kind.is_distance for kind in platform.kinds])
    y, x = (
        (part - np.median(part[distance], axis=0)) * distance[:, None]
        for part in (platform.y, platform.x)
    )
    return replace(platform, y=y, x=x)


@dataclass(frozen=True)
class Search:
    """The settings of a search.

    Attributes
    ----------
    kinds
        The kinds of the six constraints.
    seed
        Source of the random numbers.
    target
        The number of real solutions of a reduced platform at which the search may end; None:
        all solutions.
    start
        The reduced platform that every attempt begins with; random ones if None.
    deadline
        Time (`time.time`, the same on all machines) at which attempts end.
    starts
        The number of random platforms at the beginning of an attempt; the best one is improved.
    steps
        The number of platforms that an attempt may solve after that; None for no limit.
    special
        The special platforms to search; None for all reduced ones.
    solutions
        The number of their solutions; None for that of their type.
    """

    kinds: tuple[Kind, ...]
    seed: int = SEED
    target: int | None = None
    start: Platforms | None = None
    deadline: float | None = None
    starts: int = 32
    steps: int | None = None
    special: Pattern | None = None
    solutions: int | None = None

    @property
    def pattern(self) -> Pattern:
        """What the platforms have in common."""
        return self.special or Pattern(self.kinds)

    @property
    def structure(self) -> Structure:
        """The structure of the systems of reduced platforms."""
        platforms = reduced(random_platforms(self.kinds, 1, np.random.default_rng(self.seed)))
        return next(platforms.systems()).structure.canonical()

    @property
    def is_late(self) -> bool:
        """Whether the deadline has passed."""
        return self.deadline is not None and time.time() > self.deadline

    def near(self, best: Platforms | None, number: int) -> Search:
        """Return the search of an attempt if a platform is known.

        Attempts begin in turn with random platforms and with random changes of the best one.
        """
        if best is None or number % _TURNS == 0:
            return self
        rng = np.random.default_rng([self.seed, number])
        shake = self.pattern.projected(rng.normal(size=self.pattern.free.shape))
        return replace(self, start=moved(best, rng.choice(_SHAKES) * shake.ravel()))

    @property
    def _limit(self) -> float:
        """The largest size of numbers."""
        return _LARGEST if self.start is None else max(_LARGEST, 1.5 * _largest(self.start))

    def attempt(self, number: int) -> Solved | None:
        """Return the best platform that one attempt finds, None if it finds none in time."""
        rng = np.random.default_rng([self.seed, number])
        best = self._first(rng, number)
        if best is None:
            return None
        best = self._raised(best, rng)
        return self.comfortable(best, number)

    def _first(self, rng: np.random.Generator, number: int) -> Solved | None:
        if self.start is not None:
            return solved(_centred(self.start), self.seed, self.solutions)
        best: Solved | None = None
        platforms = self.pattern.of(reduced(random_platforms(self.kinds, self.starts, rng)))
        lines = any(kind in (DPL, DLP) for kind in self.kinds)
        size = _SIZES[(number + lines) % len(_SIZES)]
        platforms = replace(platforms, y=size * platforms.y, x=size * platforms.x)
        for k in range(self.starts):
            if best is not None and self.is_late:
                break
            found = solved(_centred(platforms[k]), self.seed, self.solutions)
            if found is not None and (best is None or found.count > best.count):
                best = found
        return best

    def _raised(self, best: Solved, rng: np.random.Generator) -> Solved:
        """Return the platform after steps that make pairs real."""
        goal = min(self.target or len(best.points), len(best.points))
        radius, idle, followed = _RADIUS, 0, 0
        near = best.folds(self.pattern)
        while best.count < goal and idle < _PATIENCE and not self.is_late:
            if followed == self.steps:
                break
            idle += 1
            step = _raising_step(near, radius, rng, _GROWTH if self.start is None else _LEEWAY)
            if step is None:
                radius = radius / 2 if radius > 2 * _MIN_RADIUS else _RADIUS
                continue
            platform = _centred(moved(best.platform, step))
            new = None
            if _acceptable(platform, self._limit):
                followed += 1
                if followed % _AFRESH:
                    new = followed_from(best, platform, rng)
                else:
                    new = solved(platform, self.seed, self.solutions)
            if new is None or new.count < best.count:
                radius = radius / 2 if radius > 2 * _MIN_RADIUS else _RADIUS
                continue
            radius = min(1.5 * radius, _MAX_RADIUS)
            if new.count > best.count:
                idle = 0
            best, near = new, new.folds(self.pattern)
        return best

    def comfortable(
        self, best: Solved, number: int, *, comfort: float = _COMFORT, most: int = _IMPROVEMENTS
    ) -> Solved:
        """Return a platform with as many real solutions, farther from folds, to be rounded.

        Parameters
        ----------
        best
            A platform of the pattern.
        number
            The number of an attempt, for random numbers.
        comfort, most
            The distance to folds that suffices, and the most steps.
        """
        rng = np.random.default_rng([self.seed, number, 1])
        radius, nearest = _RADIUS, best.margin(self.pattern)
        for _ in range(most):
            if nearest > comfort or radius < _MIN_RADIUS or self.is_late:
                break
            real = best.folds(self.pattern)[1]
            near = real.distances < nearest + 2 * radius
            wanted = np.minimum(nearest + radius, 1.5 * nearest)
            step = shortest_step(
                real.normals[near], wanted - real.distances[near], _DETOUR * radius
            )
            new = None
            if step is not None:
                platform = _centred(moved(best.platform, step))
                if _acceptable(platform, self._limit):
                    new = followed_from(best, platform, rng)
            further = nearest if new is None else new.margin(self.pattern)
            if new is None or new.count < best.count or further <= nearest:
                radius /= 2
                continue
            best, nearest, radius = new, further, min(1.5 * radius, _MAX_RADIUS)
        return best


def _raising_step(
    near: tuple[Folds, Folds], radius: float, rng: np.random.Generator, growth: float
) -> Array | None:
    """Return a step of about a length at most that brings one conjugate pair together."""
    pairs, real = near
    rank = min(int(rng.exponential(_RANK)), len(pairs.distances) - 1)
    chosen = np.argsort(pairs.distances)[rank]
    towards = min(float(pairs.distances[chosen]) + _MARGIN, radius)
    close = real.distances < 3 * radius + _MARGIN
    kept = np.minimum(_MARGIN, growth * real.distances[close])
    return shortest_step(
        np.concatenate((-pairs.normals[[chosen]], real.normals[close])),
        np.concatenate(([towards], kept - real.distances[close])),
        _DETOUR * radius,
    )


def attempts(
    search: Search, first: int = 0, end: int | None = None, workers: Workers = HERE
) -> Iterator[tuple[int, Solved | None]]:
    """Yield the numbers and results of attempts, in order, until the deadline has passed.

    Each attempt depends only on the search and its number, unless the deadline ends it.

    Parameters
    ----------
    search
        The search.
    first, end
        The first attempt, and the first that is not made any more.
    workers
        The processes that make them.
    """
    numbers = itertools.count(first) if end is None else range(first, end)
    wanted = itertools.takewhile(lambda _: not search.is_late, numbers)
    yield from enumerate(workers.in_order(search.attempt, wanted), start=first)
