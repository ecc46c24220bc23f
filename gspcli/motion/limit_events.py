"""Where a motion leaves the ranges of values and the cones of joints, and where it comes back."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.limits import joint_cones, out_of_cone, out_of_range
from gspcli.motion.tracks import Track

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LimitEvent:
    """A limit that is left or kept again.

    Attributes
    ----------
    kind
        ``range`` of a value, the same for all modes, or ``cone`` of a joint.
    leaves
        Whether it is left; at the first row also that it is left from the beginning.
    constraint
        The index of the constraint.
    body
        Where the joint of the cone is.
    mode
        The mode whose leg leaves the cone.
    low, high
        Between which t. Values are linear between rows, so that they leave a range at one t; of
        cones it is seen only which rows keep them.
    """

    kind: Literal["range", "cone"]
    leaves: bool
    constraint: int
    body: Literal["", "platform", "base"]
    mode: int | None
    low: float
    high: float


def limit_events(track: Track) -> list[LimitEvent]:
    """Return where a trajectory leaves limits and keeps them again, by t."""
    found = [*_ranges(track), *_cones(track)]
    return sorted(found, key=lambda event: (event.low, event.high, event.constraint))


def _ranges(track: Track) -> list[LimitEvent]:
    found = []
    values, t = track.values[:, :6], track.t
    for k, constraint in enumerate(track.instance.constraints):
        if constraint.limits is None:
            continue
        times, outside = _crossings(track.instance, k, t, values[:, k])
        state = False
        for time, now in zip(times, outside, strict=True):
            if now != state:
                found.append(LimitEvent("range", now, k, "", None, time, time))
                state = now
    return found


def _crossings(
    instance: Instance, k: int, t: Array, values: Array
) -> tuple[list[float], list[bool]]:
    """Return where pieces of the motion of one value begin, and whether they are out of range."""
    constraint = instance.constraints[k]
    assert constraint.limits is not None
    ends = [limit.value for limit in constraint.limits]
    if constraint.kind.has_sides and constraint.side is not Side.POSITIVE:
        mirrored = [-end for end in ends]
        ends = mirrored + (ends if constraint.side is Side.BOTH else [])
    times, outside = [float(t[0])], [_is_out(instance, k, values[0])]
    for row in range(len(t) - 1):
        first, last = values[row], values[row + 1]
        parts = [(end - first) / (last - first) for end in ends] if last != first else []
        cuts = [0.0, *sorted(part for part in parts if 0 < part < 1), 1.0]
        for begin, end in pairwise(cuts):
            middle = first + (begin + end) / 2 * (last - first)
            times.append(float(t[row] + begin * (t[row + 1] - t[row])))
            outside.append(_is_out(instance, k, middle))
    return times, outside


def _is_out(instance: Instance, k: int, value: float) -> bool:
    row = np.zeros(len(instance.constraints))
    row[k] = value
    return bool(out_of_range(instance, row)[k])


def _cones(track: Track) -> list[LimitEvent]:
    cones = joint_cones(track.instance)
    if not cones:
        return []
    outside = np.zeros((*track.T.shape[:2], len(cones)), bool)
    for rows, instance in track.instances():
        with np.errstate(invalid="ignore"):
            outside[:, rows] = out_of_cone(instance, track.R[:, rows], track.T[:, rows])
    there = ~np.isnan(track.T[..., 0])
    found = []
    for m, mode in enumerate(track.modes.tolist()):
        rows_there = there[m].nonzero()[0]
        for k, cone in enumerate(cones):
            state, before = False, None
            for row in rows_there.tolist():
                now = bool(outside[m, row, k])
                if now != state:
                    low = float(track.t[row if before is None else before])
                    found.append(
                        LimitEvent(
                            "cone", now, cone.constraint, cone.body, mode, low, float(track.t[row])
                        )
                    )
                    state = now
                before = row
    return found
