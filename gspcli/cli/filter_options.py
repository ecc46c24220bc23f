"""The options of `gsp solve` that omit real poses outside stated limits or on the wrong side."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import click

from gspcli.errors import ArgumentError, GspError
from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.cli.pose_options import PoseConventions
    from gspcli.motion.poses.mode_filters import Condition
    from gspcli.solver import SolveResult

Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True)
class FilterOptions:
    """The conditions that listed real poses meet.

    Attributes
    ----------
    where
        Conditions for coordinates.
    within_limits, above
        As in `gspcli.motion.poses.mode_filters.ModeFilter`.
    """

    where: tuple[Condition, ...] = ()
    within_limits: bool = False
    above: bool = False

    @property
    def options(self) -> dict[str, object]:
        """The options by their names, as they are given."""
        return {"where": self.where, "within-limits": self.within_limits, "above": self.above}

    def applied(
        self, result: SolveResult, conventions: PoseConventions
    ) -> tuple[SolveResult, dict[str, list[int]] | None]:
        """Return the result without the poses that are left out as home, and their numbers.

        Raises
        ------
        GspError
            If the platform has no limits, or no plane of its base.
        """
        if not (self.where or self.within_limits or self.above):
            return result, None
        from gspcli.motion.poses.mode_filters import ModeFilter

        form = conventions.form(result.instance)
        sequence = form.euler or "ZYX"
        asked = ModeFilter(self.where, self.within_limits, self.above, form.pivot_frame, sequence)
        try:
            left = asked.left_out(result)
        except ArgumentError as error:
            message = f"--{error.where.replace('_', '-')}: {error.message}"
            raise GspError(message) from None
        out = tuple(sorted(number - 1 for those in left.values() for number in those))
        return replace(result, left_out=out), left


def filter_options(function: Function) -> Function:
    """Add ``--where``, ``--within-limits`` and ``--above``; the command gets `FilterOptions`."""

    @click.option(
        "--where",
        metavar="CONDITION",
        multiple=True,
        help="List only real poses with this, such as 'z>0, rx<=45': x, y, z, and rx, ry, rz in "
        "the order of --euler or ZYX; may be repeated.",
    )
    @click.option(
        "--within-limits", is_flag=True, help="List only real poses within all ranges and cones."
    )
    @click.option(
        "--above",
        is_flag=True,
        help="List only real poses with the platform above its base: on the side of home, or of z.",
    )
    @functools.wraps(function)
    def command(*, where: tuple[str, ...], within_limits: bool, above: bool, **others: Any) -> Any:
        return function(filters=FilterOptions(_parsed(where), within_limits, above), **others)

    return command  # type: ignore[return-value]


def _parsed(texts: tuple[str, ...]) -> tuple[Condition, ...]:
    """Return the conditions of texts."""
    if not texts:
        return ()
    from gspcli.motion.poses.mode_filters import parse_conditions

    try:
        return tuple(one for text in texts for one in parse_conditions(text))
    except ArgumentError as error:
        message = f"--where: {error}"
        raise GspError(message) from None
