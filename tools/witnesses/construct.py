"""Construct platforms with many real solutions for types with DPL and DLP.

This is done for each family whose solutions are not all known to be real, if no simpler family with
as many solutions leads to it (`lift.py`):

- Split its DPL and DLP (`tools.witnesses.splittings`) in one of the ways with the most solutions.
- Look for a platform of the pattern that remains with all solutions real, for some seconds of
  processor time (`patterns.py`).
- Go from there to a platform of the family.

The results for the patterns are kept beside the journal.
"""

from __future__ import annotations

import itertools
import time

import numpy as np

from gspcli.catalogue.kinds import Kind
from gspcli.geometry.quaternions import pose_from_study
from gspcli.reality.solved_platforms import Solved
from tools.witnesses.known import Known, by_dependents, kinds_of, quickly_solved, solutions
from tools.witnesses.patterns import Patterns, canonical, generic_count
from tools.witnesses.splittings import Splitting, splittings

#: Sizes that are tried. Reach is the distance of points that turn, in units of the radius of the
#: known positions divided by the square of the cosine. Then the cosines; then the gaps.
_REACHES, _COSINES = (0.5, 2.0, 8.0), (0.4, 0.2, 0.1, 0.05, 0.025)
_GAPS = (0.2, 0.1, 0.05, 0.025, 0.012, 0.006, 0.003, 0.001)
#: Each constraint that is not split multiplies the expected number of real solutions by about this.
_UNSPLIT = 0.6
#: The number of splittings that are tried for a family.
_WAYS = 3


def _sizes(*, turned: bool, carried: bool) -> list[tuple[float, float, float]]:
    """Return the reaches, cosines and gaps to try, those that need the fewest digits first."""
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
    """Return the estimated number of real solutions of a splitting."""
    return float(count * splitting.factor * _UNSPLIT**splitting.left)


def best_ways(kinds: tuple[Kind, ...], patterns: Patterns) -> list[Splitting]:
    """Return the most promising ways, counting solutions of as few patterns as possible."""
    ways = {canonical(one.pattern)[0]: one for one in splittings(kinds) if one.factor > 1}
    bounds = {one: _hope(one, generic_count(one.pattern.kinds)) for one in ways.values()}
    found: list[tuple[float, int, Splitting]] = []
    for way in sorted(bounds, key=lambda one: (-bounds[one], len(one.turned))):
        if len(found) == _WAYS and bounds[way] <= found[-1][0]:
            break
        found.append((_hope(way, patterns.rest(way).count), -len(way.turned), way))
        found = sorted(found, key=lambda one: one[:2], reverse=True)[:_WAYS]
    return [way for _, _, way in found]


def construct(known: Known, seconds: float, minutes: float, most: int, below: float) -> None:
    """Construct platforms for the families whose known share of real solutions is below a limit."""
    end = time.monotonic() + 60 * minutes
    patterns = Patterns(known.journal.with_suffix(".patterns"))
    for family in by_dependents():
        if solutions(family) > most or not known.is_open(family, below):
            continue
        for way in best_ways(kinds_of(family), patterns):
            if time.monotonic() > end:
                return
            possible = patterns.rest(way).count * way.factor
            if known.is_open(family, below) and possible > known.counts.get(family.id, 0):
                best = patterns.search(way, seconds).best
                platform = best and constructed(way, best, canonical(way.pattern)[1])
                known.improve(family, platform, f", at most {possible} in this way")
