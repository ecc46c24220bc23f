"""Construct platforms with many real solutions for types with DPL and DLP.

    python -m tools.witnesses.construct JOURNAL [--seconds N] [--minutes N] [--most SOLUTIONS]
        [--below SHARE]

For each family whose solutions are not all known to be real, and to which no simpler one with as
many solutions leads (`tools/witnesses/lift.py`): split its DPL and DLP (`gspcli.reality.splitting`)
in one of the ways that leave the most solutions, look for a platform of what remains with all of
them real, N seconds of processor time for each pattern, and go from there to a platform of the
family. The results go to the journal of `python -m tools.witnesses`, whose part `write` rounds
and certifies them.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from gspcli.catalogue.kinds import DHP, DPH, Kind
from gspcli.continuation.start import path_count
from gspcli.continuation.tracked_paths import track_all
from gspcli.defaults import SEED
from gspcli.geometry.quaternions import pose_from_study
from gspcli.reality.maximize import Search
from gspcli.reality.platforms import Platforms, random_platforms, reduced
from gspcli.reality.solved_platforms import Solved, quickly_solved, solved
from gspcli.reality.splitting import Pattern, Splitting, splittings
from tools.witnesses.known import (
    Known,
    add_entry,
    by_dependents,
    kinds_of,
    numbers_of,
    read_journal,
    result,
    solutions,
)

#: How far points that turn are away, in units of the largest distance of a place from their middle
#: over the square of the cosine; the cosines, and the distances that are tried.
_REACHES, _COSINES = (0.5, 2.0, 8.0), (0.4, 0.2, 0.1, 0.05, 0.025)
_GAPS = (0.2, 0.1, 0.05, 0.025, 0.012, 0.006, 0.003, 0.001)
#: A constraint that is not split has about this share of the real solutions of one that is.
_UNSPLIT = 0.6
#: How many ways are tried for a family.
_WAYS = 3
#: A platform with all solutions real is moved so far away from folds, in so many steps.
_COMFORT, _IMPROVEMENTS = 0.15, 300
#: Values of planes and angles of the random platforms that are counted.
_SPREAD = 0.3
#: Relative norms below are those of solutions at infinity.
_INFINITY = 1e-8


@cache
def _generic_count(kinds: tuple[Kind, ...]) -> int:
    """Return how many solutions almost every reduced platform has."""
    return path_count(Search(kinds).structure)


def canonical(pattern: Pattern) -> tuple[Pattern, list[int]]:
    """Return a pattern up to the order of its constraints, and that order."""
    alike = itertools.groupby(
        sorted(range(len(pattern.kinds)), key=lambda i: pattern.kinds[i]),
        key=lambda i: pattern.kinds[i],
    )
    groups = pattern.same_points, pattern.same_u, pattern.same_v
    permuted = [itertools.permutations(block) for _, block in alike]
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
    return Pattern(kinds, *renamed(order), pattern.right_angles), order


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
            return cls(pattern, _generic_count(pattern.kinds))
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
        """Look for a platform with all solutions real, until so much time was spent."""
        search = Search(self.pattern.kinds, steps=4000, special=self.pattern, solutions=self.count)
        begin, before = time.process_time(), self.seconds
        while self.worth < (self.count, _COMFORT) and self.seconds < seconds:
            known = self.best if self.real < self.count else None
            found = search.near(known and known.platform, self.attempts).attempt(self.attempts)
            if found is not None and found.count == self.count:
                found = search.comfortable(found, 0, comfort=_COMFORT, most=_IMPROVEMENTS)
            if found is not None and (found.count, found.margin(self.pattern)) > self.worth:
                self.best = found
            self.attempts += 1
            self.seconds = before + time.process_time() - begin


def _sizes(*, turned: bool, carried: bool) -> list[tuple[float, float, float]]:
    """Return what is tried, reach, cosine and gap: first what needs the fewest digits."""
    every = itertools.product(
        _REACHES if turned else _REACHES[:1],
        _COSINES if turned else _COSINES[:1],
        _GAPS if carried else _GAPS[:1],
    )
    return sorted(every, key=lambda one: one[0] / (one[1] ** 2 * one[2] ** 2))


def constructed(splitting: Splitting, known: Solved, order: list[int]) -> Solved | None:
    """Return the best platform near one of the pattern, whose constraints have another order."""
    R, T = pose_from_study(known.points[known.real, :4], known.points[known.real, 4:])
    R, T = R.real, T.real
    U = -np.einsum("nji,nj->ni", R, T)
    spread = max(float(np.linalg.norm(x - x.mean(axis=0), axis=1).max()) for x in (T, U))
    platform = known.platform.permuted(np.argsort(order).tolist())
    best: Solved | None = None
    turned, carried = bool(splitting.turned), bool(splitting.carried)
    for reach, cosine, gap in _sizes(turned=turned, carried=carried):
        far = float(f"{reach * max(spread, 0.05) / cosine**2:.1g}")
        lifted = splitting.lifted(platform, R, T, gap=gap, reach=far, cosine=cosine)
        found = quickly_solved(lifted)
        if found is not None and (best is None or found.count > best.count):
            best = found
        if best is not None and best.count == known.count * splitting.factor:
            break
    return best


def _hope(splitting: Splitting, count: int) -> float:
    """Return how many real solutions a way to split may give."""
    return float(count * splitting.factor * _UNSPLIT**splitting.left)


def construct(journal: Path, seconds: float, minutes: float, most: int, below: float) -> None:
    """Go through the families once, those of which a smaller share is known to be real."""
    end = time.monotonic() + 60 * minutes
    known = Known(journal)
    patterns = journal.with_suffix(".patterns")
    before = {entry["pattern"]: entry for entry in read_journal(patterns)}
    remaining: dict[Pattern, Remaining] = {}

    def rest(splitting: Splitting) -> Remaining:
        pattern, _ = canonical(splitting.pattern)
        if pattern not in remaining and str(pattern) in before:
            remaining[pattern] = Remaining.read(pattern, before[str(pattern)])
        elif pattern not in remaining:
            remaining[pattern] = Remaining.of(pattern)
            add_entry(patterns, remaining[pattern].entry)
        return remaining[pattern]

    def best_ways(kinds: tuple[Kind, ...]) -> list[Splitting]:
        """Return the most promising ways, counting solutions of as few patterns as possible."""
        ways = {canonical(one.pattern)[0]: one for one in splittings(kinds) if one.factor > 1}
        bounds = {one: _hope(one, _generic_count(one.pattern.kinds)) for one in ways.values()}
        found: list[tuple[float, int, Splitting]] = []
        for way in sorted(bounds, key=lambda one: (-bounds[one], len(one.turned))):
            if len(found) == _WAYS and bounds[way] <= found[-1][0]:
                break
            found.append((_hope(way, rest(way).count), -len(way.turned), way))
            found = sorted(found, key=lambda one: one[:2], reverse=True)[:_WAYS]
        return [way for _, _, way in found]

    for family in by_dependents():
        kinds, total = kinds_of(family), solutions(family)
        if known.counts.get(family.id, 0) >= below * total or total > most:
            continue
        for way in best_ways(kinds):
            now = known.counts.get(family.id, 0)
            if time.monotonic() > end:
                return
            if now >= below * total or rest(way).count * way.factor <= now:
                continue
            if rest(way).seconds < seconds:
                rest(way).search(seconds)
                add_entry(patterns, rest(way).entry)
            found = rest(way).best
            platform = found and constructed(way, found, canonical(way.pattern)[1])
            if platform is not None and platform.count > now:
                entry = result(family, platform)
                add_entry(journal, entry)
                known.add(family.id, platform.count, entry)
            sys.stderr.write(
                f"{family.id}: {now} -> {platform.count if platform else 0} of {total},"
                f" at most {rest(way).count * way.factor} in this way\n"
            )


def main() -> int:
    """Construct."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("journal", type=Path)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--most", type=int, default=10_000)
    parser.add_argument("--below", type=float, default=1.0)
    one = parser.parse_args()
    construct(one.journal, one.seconds, one.minutes, one.most, one.below)
    return 0


if __name__ == "__main__":
    sys.exit(main())
