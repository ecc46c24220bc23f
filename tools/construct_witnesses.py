"""Construct platforms with many real solutions for types with DPL and DLP.

    python tools/construct_witnesses.py JOURNAL [--seconds N] [--minutes N] [--most SOLUTIONS]

For each family whose solutions are not all known to be real: split its DPL and DLP
(`gspcli.reality.splitting`) in the way that leaves the most solutions, look for a platform of
what remains with all of them real, N seconds of processor time for each pattern, and go from there
to a platform of the family. The results go to the journal of `tools/build_witnesses.py`, whose part
`write` rounds and certifies them.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from build_witnesses import canonical_families, kinds_of, read_journal, recorded, solutions
from recording import ROOT

sys.path.insert(0, str(ROOT))

from gspcli.catalogue.kinds import DHP, DPH
from gspcli.continuation.start import path_count
from gspcli.defaults import SEED
from gspcli.geometry.quaternions import pose_from_study
from gspcli.reality.fold_distances import moved
from gspcli.reality.maximize import Search, Solved, multiplier, reduced
from gspcli.reality.platforms import Platforms, random_platforms
from gspcli.reality.recognition import reality
from gspcli.reality.splitting import Pattern, Splitting, splittings

#: Cosines or distances that are tried, and how far points that turn are away, in units of the
#: largest distance of a place from their middle over the square of that.
_GAPS, _REACHES = (0.2, 0.1, 0.05, 0.025, 0.012, 0.006, 0.003, 0.001), (2, 8)
#: Attempts in turn begin with random platforms, and with the best one shaken by these lengths.
_TURNS, _SHAKES = 4, (0.0, 0.01, 0.03, 0.06, 0.1)
#: A constraint that is not split has about this share of the real solutions of one that is.
_UNSPLIT = 0.6
#: Values of planes and angles of the random platforms that are counted.
_SPREAD = 0.3


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


def reordered(platform: Platforms, order: list[int]) -> Platforms:
    """Return a platform with its constraints in another order."""
    parts = (platform.y, platform.x, platform.u, platform.v, platform.values)
    return Platforms(tuple(platform.kinds[i] for i in order), *(part[order] for part in parts))


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
            return cls(pattern, path_count(Search(pattern.kinds).structure))
        counts = [0]
        for seed in range(2):
            rng = np.random.default_rng([SEED, seed])
            platform = pattern.of(reduced(random_platforms(pattern.kinds, 1, rng)))
            values = platform.values.copy()
            for i, kind in enumerate(pattern.kinds):
                if kind in (DPH, DHP) or not (kind.is_distance or pattern.same_u):
                    values[0, i] = _SPREAD * rng.normal()
            found = next(replace(platform, values=values).solutions(SEED))
            if found.account.verdict == "complete":
                counts.append(len(found.points))
        return cls(pattern, max(counts))

    @property
    def real(self) -> int:
        """The most real solutions known."""
        return 0 if self.best is None else self.best.count

    def search(self, seconds: float) -> None:
        """Look for a platform with all solutions real, until so much time was spent."""
        search = Search(self.pattern.kinds, steps=4000, special=self.pattern, solutions=self.count)
        begin, before = time.process_time(), self.seconds
        while self.real < self.count and self.seconds < seconds:
            start = None
            if self.attempts % _TURNS and self.best is not None:
                rng = np.random.default_rng([SEED, self.attempts])
                shake = self.pattern.projected(rng.normal(size=self.pattern.free.shape))
                start = moved(self.best.platform, rng.choice(_SHAKES) * shake.ravel())
            found = replace(search, start=start).attempt(self.attempts)
            if found is not None and found.count > self.real:
                self.best = found
            self.attempts += 1
            self.seconds = before + time.process_time() - begin


def constructed(splitting: Splitting, known: Solved, order: list[int]) -> Solved | None:
    """Return the best platform near one of the pattern, whose constraints have another order."""
    R, T = pose_from_study(known.points[known.real, :4], known.points[known.real, 4:])
    R, T = R.real, T.real
    U = -np.einsum("nji,nj->ni", R, T)
    spread = max(float(np.linalg.norm(x - x.mean(axis=0), axis=1).max()) for x in (T, U))
    platform = reordered(known.platform, list(np.argsort(order)))
    best: Solved | None = None
    for gap, reach in itertools.product(_GAPS, _REACHES if splitting.turned else (1,)):
        far = float(f"{reach * max(spread, 0.05) / gap**2:.1g}")
        found = _solved_anyhow(splitting.lifted(platform, R, T, gap=gap, reach=far))
        if found is not None and (best is None or found.count > best.count):
            best = found
        if best is not None and best.count == known.count * splitting.factor:
            break
    return best


def _hope(splitting: Splitting, count: int) -> float:
    """Return how many real solutions a way to split may give."""
    return float(count * splitting.factor * _UNSPLIT**splitting.left)


def _solved_anyhow(platform: Platforms) -> Solved | None:
    """Return a platform with however many solutions it has."""
    found = next(platform[None].solutions(SEED))
    if found.account.verdict != "complete" or not len(found.points):
        return None
    which = reality(found.points, found.condition)
    system = next(platform[None].systems())
    return Solved(platform, system, found.points, which.real) if which.decided else None


def construct(journal: Path, seconds: float, minutes: float, most: int) -> None:
    """Go through the families once."""
    end = time.monotonic() + 60 * minutes
    known = {name: found.real for name, found in recorded().items()}
    remaining: dict[Pattern, Remaining] = {}

    def rest(splitting: Splitting) -> Remaining:
        pattern, _ = canonical(splitting.pattern)
        if pattern not in remaining:
            remaining[pattern] = Remaining.of(pattern)
        return remaining[pattern]

    done: dict[str, int] = {}
    for entry in read_journal(journal):
        done[entry["family"]] = max(entry["real"], done.get(entry["family"], 0))
    for family in canonical_families():
        kinds, total = kinds_of(family), solutions(family)
        now = max(known.get(family.id, 0) // multiplier(kinds), done.get(family.id, 0))
        ways = [one for one in splittings(kinds) if one.factor > 1]
        if now >= total or total > most or not ways:
            continue
        if time.monotonic() > end:
            return
        best = max(ways, key=lambda one: (_hope(one, rest(one).count), -len(one.turned)))
        if rest(best).count * best.factor <= now:
            continue
        rest(best).search(seconds)
        found = rest(best).best
        platform = found and constructed(best, found, canonical(best.pattern)[1])
        if platform is not None and platform.count > now:
            one = platform.platform
            numbers = [part.tolist() for part in (one.y, one.x, one.u, one.v, one.values)]
            entry = {"family": family.id, "real": platform.count, "numbers": numbers}
            with journal.open("a", encoding="utf-8") as file:
                file.write(json.dumps(entry) + "\n")
        sys.stderr.write(
            f"{family.id}: {now} -> {platform.count if platform else 0} of {total},"
            f" at most {rest(best).count * best.factor} in this way\n"
        )


def main() -> int:
    """Construct."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("journal", type=Path)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--most", type=int, default=10_000)
    arguments = parser.parse_args()
    construct(arguments.journal, arguments.seconds, arguments.minutes, arguments.most)
    return 0


if __name__ == "__main__":
    sys.exit(main())
