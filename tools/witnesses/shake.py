"""Change the platforms with many real solutions a little at random, and keep what is better.

The search (`search.py`) needs all solutions of a platform; of one near a limit, such as those of
`construct.py`, some are not found. Here only the real ones are counted that first attempts at all
paths find: a change that loses none of them is made, and the next one begins there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gspcli.catalogue.counts import named_family
from gspcli.reality.fold_distances import moved
from gspcli.reality.patterns import Pattern
from gspcli.reality.platforms import Array, Platforms
from gspcli.reality.solved_platforms import Solved
from tools.witnesses.known import Known, kinds_of, quickly_solved

#: Decimal exponents between which changes are; every second one changes some constraints only.
_EXPONENTS, _SOME = (-3.5, -0.5), 0.35
#: Numbers above the first, of points far away, change by this part of their size.
_FAR, _PART = 10.0, 0.01


def change(platform: Platforms, rng: np.random.Generator) -> Array:
    """Return a random change of the numbers of a platform, shape (78,)."""
    pattern = Pattern(platform.kinds)
    step = 10 ** rng.uniform(*_EXPONENTS) * pattern.projected(rng.normal(size=pattern.free.shape))
    if rng.random() < 1 / 2:
        step *= rng.random((len(step), 1)) < _SOME
    values = platform.values[:, None]
    numbers = np.abs(
        np.concatenate((platform.y, platform.x, platform.u, platform.v, values), axis=1)
    )
    return np.asarray((step * np.where(numbers > _FAR, _PART * numbers, 1.0)).ravel())


def shaken(platform: Platforms, tries: int, rng: np.random.Generator) -> Iterator[Solved]:
    """Yield platforms that were come to by changes, each with more real solutions."""
    start = quickly_solved(platform)
    best, count = platform, 0 if start is None else start.count
    for _ in range(tries):
        found = quickly_solved(moved(best, change(best, rng)))
        if found is None or found.count < count:
            continue
        best = found.platform
        if found.count > count:
            count = found.count
            yield found


def shake(known: Known, names: Sequence[str], tries: int, seed: int) -> None:
    """Change the best platforms of some families this many times."""
    for family in map(named_family, names):
        rng = np.random.default_rng(seed)
        for found in shaken(known.platform(kinds_of(family)), tries, rng):
            known.improve(family, found)
