"""Tracking of solution paths between two systems of one structure."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class PathStatus(IntEnum):
    """How a path ended."""

    REGULAR = 0
    """At a solution of the target with an invertible Jacobian matrix."""
    SINGULAR = 1
    """Stopped in front of the target, where the Jacobian matrix degenerates: endgame."""
    FAILED = 2
    """Stopped on the way: the step became too small, or the steps too many."""


@dataclass(frozen=True)
class TrackerOptions:
    """Settings of the path tracker. The presets are `DEFAULT`, `CAREFUL` and `PARANOID`."""

    max_steps: int = 500
    """Steps (accepted and rejected) after which a path is given up."""


DEFAULT = TrackerOptions()
