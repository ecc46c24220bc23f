"""The option that says which real pose a command takes: a number, or home."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypeVar

import click

from gspcli.cli.number_types import Whole
from gspcli.cli.streams import say

if TYPE_CHECKING:
    from gspcli.geometry.home_mode import HomeMode

HOME: Literal["home"] = "home"
#: A number as `gsp solve` lists the real poses, from 1, or the home mode.
Mode: TypeAlias = "int | Literal['home']"

Function = TypeVar("Function", bound=Callable[..., Any])


class ModeNumber(Whole):
    """A whole number of at least 1, or the word home."""

    name = "mode"

    def __init__(self) -> None:
        super().__init__(1)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number or the word, or fail."""
        if value == HOME:
            return HOME
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter as error:
            message = f"{error.message.rstrip('.')}; expected a number of gsp solve, or {HOME}."
            self.fail(message, param, ctx)


def mode_option(what: str) -> Callable[[Function], Function]:
    """Add ``--mode K|home``; the help says what it is for."""
    meaning = f"A real pose by its number of `gsp solve`, or home: {what}"
    return click.option("--mode", type=ModeNumber(), metavar="K|home", help=meaning)


def chosen(mode: Mode | None, home: HomeMode | None, count: int) -> int:
    """Return the number of the mode asked for. If none is, it is home, and stderr says so.

    Parameters
    ----------
    mode
        As the option is given.
    home
        The home mode, if there is one.
    count
        How many real poses there are.
    """
    from gspcli.motion.poses.chosen_mode import chosen_mode

    number = mode if isinstance(mode, int) else None
    found = chosen_mode(number, home, count)
    if number is None and home is not None and count > 1:
        say(home.text)
    return found
