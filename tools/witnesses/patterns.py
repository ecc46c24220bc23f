"""What remains of types whose DPL and DLP are split, and how many solutions of it can be real."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from gspcli.catalogue.kinds import DHP, DPH, Kind
from gspcli.continuation.start import path_count
from gspcli.continuation.tracked_paths import track_all
from gspcli.defaults import SEED
from gspcli.reality.maximize import Search
from gspcli.reality.patterns import Pattern
from gspcli.reality.platforms import Platforms, random_platforms, reduced
from gspcli.reality.solved_platforms import Solved, solved
from tools.witnesses.known import add_entry, numbers_of, read_journal
from tools.witnesses.splittings import Splitting

#: A platform with all solutions real is moved so far away from folds, in this many steps.
_COMFORT, _IMPROVEMENTS = 0.15, 300
#: Values of planes and angles of the random platforms that are counted.
_SPREAD = 0.3
#: Relative norms below are those of solutions at infinity.
_INFINITY = 1e-8


@cache
def generic_count(kinds: tuple[Kind, ...]) -> int:
    """Return how many solutions almost every reduced platform has."""
    return path_count(Search(kinds).structure)


def canonical(pattern: Pattern) -> tuple[Pattern, list[int]]:
    """Return a pattern up to the order of its constraints, and that order."""
    alike = itertools.groupby(
        sorted(range(len(pattern.kinds)), key=lambda i: pattern.kinds[i]),
        key=lambda i: pattern.kinds[i],
    )
    groups = pattern.same_points, pattern.same_u, pattern.same_v
    permuted: list[Iterator[tuple[int, ...]]] = [
        itertools.permutations(block) for _, block in alike
    ]
    if not any(groups):
        permuted = [iter([next(block)]) for block in permuted]

    def renamed(order: list[int]) -> tuple[tuple[tuple[int, ...], ...], ...]:
        place = {old: new for new, old in enumerate(order)}
        return tuple(
            tuple(sorted(tuple(sorted(place[i] for i in group)) for group in part))
            for part in groups
        )

    orders = (list(itertools.chain(*choice)) for choice in itertools.product(*permuted))
    order = min(orders, key=renamed)
    kinds = tuple(pattern.kinds[i] for i in order)
    same_points, same_u, same_v = renamed(order)
    return Pattern(kinds, same_points, same_u, same_v, pattern.right_angles), order


@dataclass
class Remaining:
    """What is known of a pattern.

    Attributes
    ----------
    pattern
        In canonical order.
    count
        How many solutions almost every platform of it seems to have, with planes and angles
        somewhere; 0 if they are infinitely many.
    best
        Its best platform so far.
    attempts, seconds
        What was done for it.
    """

    pattern: Pattern
    count: int
    best: Solved | None = None
    attempts: int = 0
    seconds: float = 0.0

    @classmethod
    def of(cls, pattern: Pattern) -> Remaining:
        """Count the solutions of a pattern, at two random platforms if they are special ones."""
        if not (pattern.same_points or pattern.same_u):
            return cls(pattern, generic_count(pattern.kinds))
        counts = [0]
        for seed in range(2):
            rng = np.random.default_rng([SEED, seed])
            platform = pattern.of(reduced(random_platforms(pattern.kinds, 1, rng)))
            values = platform.values.copy()
            for i, kind in enumerate(pattern.kinds):
                if kind in (DPH, DHP) or not (kind.is_distance or pattern.same_u):
                    values[0, i] = _SPREAD * rng.normal()
            (tracked_paths,) = track_all(replace(platform, values=values).systems(), seed=SEED)
            ends = tracked_paths.first()
            norm = np.abs((ends.points[:, :4] ** 2).sum(axis=-1))
            finite = norm > _INFINITY * np.linalg.norm(ends.points, axis=-1) ** 2
            counts.append(int((ends.simple & finite).sum()))
        return cls(pattern, max(counts))

    @property
    def entry(self) -> dict[str, Any]:
        """What goes to the journal of patterns."""
        numbers = None if self.best is None else numbers_of(self.best.platform)
        return {
            "pattern": str(self.pattern),
            "count": self.count,
            "attempts": self.attempts,
            "seconds": self.seconds,
            "numbers": numbers,
        }

    @classmethod
    def read(cls, pattern: Pattern, entry: dict[str, Any]) -> Remaining:
        """Return what an entry of the journal says."""
        best = None
        if entry["numbers"] is not None:
            numbers = (np.array(part, float) for part in entry["numbers"])
            best = solved(Platforms(pattern.kinds, *numbers), SEED, entry["count"])
        return cls(pattern, entry["count"], best, entry["attempts"], entry["seconds"])

    @property
    def real(self) -> int:
        """The most real solutions known."""
        return 0 if self.best is None else self.best.count

    @property
    def worth(self) -> tuple[int, float]:
        """That number, and how far the platform is from losing some."""
        return self.real, 0.0 if self.best is None else self.best.margin(self.pattern)

    def search(self, seconds: float) -> None:
        """Look for a platform with all solutions real, until this much time was spent."""
        search = Search(self.pattern.kinds, steps=4000, special=self.pattern, solutions=self.count)
        begin, before = time.process_time(), self.seconds
        while self.worth < (self.count, _COMFORT) and self.seconds < seconds:
            known = self.best.platform if self.best and self.real < self.count else None
            found = search.near(known, self.attempts).attempt(self.attempts)
            if found is not None and found.count == self.count:
                found = search.comfortable(found, 0, comfort=_COMFORT, most=_IMPROVEMENTS)
            if found is not None and (found.count, found.margin(self.pattern)) > self.worth:
                self.best = found
            self.attempts += 1
            self.seconds = before + time.process_time() - begin


class Patterns:
    """What is known of all patterns so far, kept in a journal of its own."""

    def __init__(self, journal: Path) -> None:
        self._journal = journal
        self._before = {entry["pattern"]: entry for entry in read_journal(journal)}
        self._known: dict[Pattern, Remaining] = {}

    def rest(self, splitting: Splitting) -> Remaining:
        """Return what is known of the rest of a splitting; its solutions are counted now."""
        pattern, _ = canonical(splitting.pattern)
        if pattern not in self._known and str(pattern) in self._before:
            self._known[pattern] = Remaining.read(pattern, self._before[str(pattern)])
        elif pattern not in self._known:
            self._known[pattern] = Remaining.of(pattern)
            add_entry(self._journal, self._known[pattern].entry)
        return self._known[pattern]

    def search(self, splitting: Splitting, seconds: float) -> Remaining:
        """Return the same after this many seconds of search."""
        rest = self.rest(splitting)
        if rest.seconds < seconds:
            rest.search(seconds)
            add_entry(self._journal, rest.entry)
        return rest
