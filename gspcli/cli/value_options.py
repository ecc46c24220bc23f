"""The options `--set` and `--delta`: other values than those of SPEC."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance

Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True)
class Changes:
    """Changes of the values of an instance, as texts ``I=V``.

    Attributes
    ----------
    values
        New values.
    differences
        Numbers that are added to the values.
    """

    values: tuple[str, ...] = ()
    differences: tuple[str, ...] = ()

    def of(self, instance: Instance) -> Instance:
        """Return the instance with these changes.

        Raises
        ------
        SpecError
            With all mistakes in the texts.
        """
        if not self.values and not self.differences:
            return instance
        from gspcli.spec import set_values

        return set_values(set_values(instance, self.values), self.differences, delta=True)


def value_options(function: Function) -> Function:
    """Add the two options; the command gets ``changes: Changes``."""

    @click.option(
        "--set",
        "settings",
        metavar="I=V",
        multiple=True,
        help="Give constraint I (from 1) the value V; may be repeated.",
    )
    @click.option(
        "--delta",
        "differences",
        metavar="I=V",
        multiple=True,
        help="Add V to the value of constraint I; may be repeated.",
    )
    @functools.wraps(function)
    def command(*, settings: tuple[str, ...], differences: tuple[str, ...], **others: Any) -> Any:
        return function(changes=Changes(settings, differences), **others)

    return command  # type: ignore[return-value]
