"""Numbers on the command line: finite, and not larger than what can be done with them."""

from __future__ import annotations

import math
from typing import Any

import click

from gspcli.wording import shortened

#: The largest number of things: more would fill every memory, or take years.
_MOST = 10**9
#: Processes or threads.
MOST_JOBS = 1000
_LARGEST_SEED = 2**63 - 1


class Whole(click.IntRange):
    """A whole number of at least some least one; the help says nothing of the largest."""

    def __init__(self, least: int, most: int = _MOST) -> None:
        super().__init__(least)
        self._most = most

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number, or fail."""
        number = super().convert(value, param, ctx)
        if number > self._most:
            self.fail(f"{shortened(str(value))} is not at most {self._most}.", param, ctx)
        return number


class Seed(Whole):
    """A seed of random numbers."""

    def __init__(self) -> None:
        super().__init__(0, _LARGEST_SEED)


class Positive(click.FloatRange):
    """A number above zero that is finite."""

    def __init__(self) -> None:
        super().__init__(0, min_open=True)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number, or fail."""
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{shortened(str(value))} is not a finite number.", param, ctx)
        return number
