"""The numbers of real solutions of random platforms, with the table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli import __version__
from gspcli.catalogue.names import any_type
from gspcli.catalogue.types import GspType
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.reality.real_distribution import Sample, Tally
from gspcli.reality.real_distribution import sample as parts
from gspcli.records import EqualByContent, dataclass
from gspcli.wording import counted
from gspcli.workers import HERE, Workers

if TYPE_CHECKING:
    import pandas as pd


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
    for part in parts(wanted, workers):
        tally.add(part)
    return SampleResult(wanted, tally)
