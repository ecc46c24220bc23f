"""The distribution of the number of real solutions of random platforms of a type."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterator
from dataclasses import field
from typing import TYPE_CHECKING, Any

import numpy as np

from gspcli import __version__
from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.names import any_type
from gspcli.catalogue.types import GspType
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.reality.platforms import Platforms, random_platforms, reality
from gspcli.records import EqualByContent, dataclass
from gspcli.wording import counted
from gspcli.workers import HERE, Workers

if TYPE_CHECKING:
    import pandas as pd


#: The approximate number of paths in one piece of work.
_PATHS = 16_384


@dataclasses.dataclass
class Tally:
    """The numbers of real solutions of some random platforms."""

    #: The number of platforms by their number of real solutions.
    real: Counter[int] = field(default_factory=Counter)
    #: The platforms without a known number, ``undecided`` or ``incomplete``, by the number of the
    #: piece and that of the platform in it.
    doubtful: dict[tuple[int, int], str] = field(default_factory=dict)

    @property
    def platforms(self) -> int:
        """The number of platforms that were drawn."""
        return self.real.total() + len(self.doubtful)

    @property
    def undecided(self) -> int:
        """The number of platforms with a solution that is too near a double one to be decided."""
        return list(self.doubtful.values()).count("undecided")

    @property
    def incomplete(self) -> int:
        """The number of platforms that were not solved completely."""
        return list(self.doubtful.values()).count("incomplete")

    @property
    def mean(self) -> float | None:
        """The mean of the known numbers of real solutions; None if none is known."""
        total = self.real.total()
        return sum(k * n for k, n in self.real.items()) / total if total else None

    def add(self, other: Tally) -> None:
        """Add the numbers of other platforms."""
        self.real += other.real
        self.doubtful |= other.doubtful


@dataclass(frozen=True)
class Sample:
    """The settings of a sample."""

    #: The type; the kinds of its angles make no difference.
    gsp_type: GspType
    #: The number of platforms.
    count: int
    #: Source of the random numbers.
    seed: int = SEED
    #: Whether DPH and DHP distances ask for the side of a hidden pose, or for both sides.
    one_sided: bool = False

    @property
    def expected(self) -> int:
        """The number of complex solutions of almost every platform."""
        counts = generic_counts(self.gsp_type)
        return counts.one_sided if self.one_sided else counts.two_sided

    @property
    def pieces(self) -> list[int]:
        """The numbers of platforms in each piece; they do not depend on the processes."""
        size = max(1, _PATHS // self.expected)
        full, rest = divmod(self.count, size)
        return [size] * full + [rest] * (rest > 0)

    def platforms(self, number: int) -> Platforms:
        """Return the platforms of one of the `pieces`, by its number."""
        rng = np.random.default_rng([self.seed, number])
        return random_platforms(self.gsp_type.kinds, self.pieces[number], rng)

    def tally(self, number: int) -> Tally:
        """Return the tally of one of the `pieces`, by its number."""
        platforms = self.platforms(number)
        systems = 1
        if not self.one_sided:
            systems = 2 ** sum(kind.has_sides for kind in self.gsp_type.kinds)
            platforms = platforms.on_all_sides()
        tally = Tally()
        solutions = platforms.solutions(self.seed)
        for k in range(self.pieces[number]):
            every = [next(solutions) for _ in range(systems)]
            if any(one.account.verdict != "complete" for one in every):
                tally.doubtful[number, k] = "incomplete"
                continue
            found = [reality(one.points, one.condition) for one in every]
            if all(one.decided for one in found):
                tally.real[sum(one.count for one in found)] += 1
            else:
                tally.doubtful[number, k] = "undecided"
        return tally


def tallies(wanted: Sample, workers: Workers = HERE) -> Iterator[Tally]:
    """Return the tallies of the pieces, as they become known.

    Parameters
    ----------
    wanted
        The settings. The distribution is that of `random_platforms`.
    workers
        The processes that solve them.
    """
    return workers.as_completed(wanted.tally, range(len(wanted.pieces)))


@dataclass(frozen=True, eq=False)
class SampleResult(EqualByContent):
    """The real solutions of random platforms.

    Attributes
    ----------
    wanted
        The settings.
    tally
        The numbers.
    """

    wanted: Sample
    tally: Tally

    def __repr__(self) -> str:
        mean = "" if self.tally.mean is None else f", {self.tally.mean:.4g} real on average"
        size = counted(self.tally.platforms, "platform")
        return f"<SampleResult of {self.wanted.gsp_type.id}: {size}{mean}>"

    def to_frame(self) -> pd.DataFrame:
        """Return the number of platforms for each number of real solutions; imports pandas."""
        import pandas as pd

        real = self.tally.real
        return pd.DataFrame({"real": sorted(real), "platforms": [real[k] for k in sorted(real)]})

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.sample/1``."""
        wanted, tally = self.wanted, self.tally
        return {
            "schema": "gsp.sample/1",
            "type": wanted.gsp_type.to_json(),
            "one_sided": wanted.one_sided,
            "expected": wanted.expected,
            "seed": wanted.seed,
            "version": __version__,
            "platforms": tally.platforms,
            "undecided": tally.undecided,
            "incomplete": tally.incomplete,
            "mean": tally.mean,
            "real": {str(real): tally.real[real] for real in sorted(tally.real)},
        }


def sample(
    gsp_type: GspType | str | int,
    count: int = 1000,
    *,
    seed: int = SEED,
    one_sided: bool = False,
    workers: Workers = HERE,
) -> SampleResult:
    """Count the real solutions of random platforms of a type.

    Parameters
    ----------
    gsp_type
        The type, its name or its number; the kinds of its angles make no difference.
    count
        The number of platforms.
    seed
        The seed of the random numbers.
    one_sided
        Whether one side of each DPH and DHP counts; otherwise both do.
    workers
        The processes that do the work.

    Raises
    ------
    ArgumentError
        If the number of platforms is not positive.
    TypeNameError
        If a text is the name of no type.
    """
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise ArgumentError(f"found {count!r}, expected a number of at least 1", "count")
    wanted, tally = Sample(any_type(gsp_type), count, seed, one_sided), Tally()
    for part in tallies(wanted, workers):
        tally.add(part)
    return SampleResult(wanted, tally)
