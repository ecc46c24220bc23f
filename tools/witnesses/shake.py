"""Change the platforms with many real solutions a little at random, and keep what is better.

    python -m tools.witnesses.shake JOURNAL FAMILY... [--tries N] [--seed N]

The search of `python -m tools.witnesses` needs all solutions of a platform; of one near a limit,
such as those of `tools/witnesses/construct.py`, some are not found. Here only the real ones are
counted that first attempts at all paths find: a change that loses none of them is made, and the
next one begins there. The results go to the journal of `python -m tools.witnesses`, whose part
`write` rounds and certifies them.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from gspcli.catalogue.witnesses import named_family
from gspcli.defaults import SEED
from gspcli.reality.fold_distances import moved
from gspcli.reality.platforms import Array, Platforms
from gspcli.reality.solved_platforms import Solved, quickly_solved
from gspcli.reality.splitting import Pattern
from tools.witnesses.known import Known, add_entry, kinds_of, result, solutions

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


def main() -> int:
    """Shake."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("journal", type=Path)
    parser.add_argument("families", nargs="+", metavar="FAMILY")
    parser.add_argument("--tries", type=int, default=300)
    parser.add_argument("--seed", type=int, default=SEED)
    one = parser.parse_args()
    for name in one.families:
        family, known = named_family(name), Known(one.journal)
        most = known.counts[family.id]
        rng = np.random.default_rng(one.seed)
        for found in shaken(known.platform(kinds_of(family)), one.tries, rng):
            if found.count > most:
                sys.stderr.write(f"{family.id}: {most} -> {found.count} of {solutions(family)}\n")
                most = found.count
                add_entry(one.journal, result(family, found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
