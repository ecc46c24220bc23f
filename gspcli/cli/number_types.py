"""Types of numbers on the command line: finite, with an upper limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import click

from gspcli.defaults import SEED
from gspcli.wording import shortened

Function = TypeVar("Function", bound=Callable[..., Any])

#: The upper limit of counts: a larger one would exceed the memory, or take years.
_MOST = 10**9
#: Processes or threads.
MOST_JOBS = 1000
_LARGEST_SEED = 2**63 - 1


class Whole(click.IntRange):
    """A whole number with a lower limit. The help does not show the upper limit."""

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


class Finite(click.FloatRange):
    """A finite number: every option that is a number has this type, or one derived from it."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number, or fail."""
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{shortened(str(value))} is not a finite number.", param, ctx)
        return number


class Positive(Finite):
    """A number above zero that is finite."""

    def __init__(self) -> None:
        super().__init__(0, min_open=True)


def seed_option(more: str = "") -> Callable[[Function], Function]:
    """Return the option `--seed`; the command gets ``seed: int``.

    Parameters
    ----------
    more
        What its help says besides.
    """
    return click.option(
        "--seed",
        type=Seed(),
        default=SEED,
        show_default=True,
        metavar="N",
        help=f"Seed of random choices{more}.",
    )


def decimals_option(
    default: int | None, least: int, most: int, more: str
) -> Callable[[Function], Function]:
    """Return the option `--decimals`; the command gets ``decimals: int`` or None.

    Parameters
    ----------
    default, least, most
        How many without the option, and how few and many there may be.
    more
        What its help says besides.
    """
    return click.option(
        "--decimals",
        type=Whole(least, most),
        default=default,
        show_default=default is not None,
        metavar="N",
        help=f"Write numbers with N decimals{more}.",
    )


#: `--one-sided`; the command gets ``one_sided: bool``.
one_sided_option = click.option(
    "--one-sided", is_flag=True, help="Choose one side of each PH and HP distance, not both."
)
