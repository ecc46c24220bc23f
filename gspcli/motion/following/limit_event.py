"""Events of a track: a limit is left or kept again, or a drive passes a dead point."""

from __future__ import annotations

from typing import Literal

from gspcli.records import dataclass


@dataclass(frozen=True)
class LimitEvent:
    """A time at which a limit is violated for the first time or kept again.

    Attributes
    ----------
    kind
        ``range`` for a value, a crank or a slide (the same for all modes), ``cone`` for a joint,
        ``dead point`` for a crank or slide whose gain changes its sign.
    leaves
        Whether the limit is violated from here on; at the first row, whether it is violated at the
        start.
    constraint
        The index of the constraint.
    body
        The body of the joint of the cone.
    mode
        The mode whose leg leaves the cone.
    low, high
        An interval that contains t. Values are linear between rows, so they leave a range at one t.
    proved
        Whether it is proved that the limit is kept before and violated after, or the reverse. An
        unproved event of a certified track means that a cone may be violated between: the leg is
        near the edge of the cone, or the mode is nearly singular. Without certification cones are
        checked at rows.
    drive
        The name of the crank or slide; empty for values and cones.
    """

    kind: Literal["range", "cone", "dead point"]
    leaves: bool
    constraint: int
    body: Literal["", "platform", "base"]
    mode: int | None
    low: float
    high: float
    proved: bool
    drive: str = ""
