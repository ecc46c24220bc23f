"""What a proved track keeps between its rows: condition numbers, clearances and gaps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.readings import without_corrections
from gspcli.motion.following.tracks import Track
from gspcli.motion.paths.between_rows import PathRows, largest_conditions, least_clearances
from gspcli.motion.paths.gaps_between import least_gaps
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.value_ways import ValueWays
from gspcli.records import dataclass

#: What is judged between rows, and how.
BOUNDED = {"condition": largest_conditions, "clearance": least_clearances, "gap": least_gaps}


@dataclass(frozen=True)
class Between:
    """A way between two rows on which a requirement is not proved.

    Attributes
    ----------
    mode
        The number of the mode.
    row
        The row before it, from 0.
    bound
        What is proved there: at most this condition number, at least this clearance or gap.
    """

    mode: int
    row: int
    bound: float


def can_be_bounded(track: Track) -> bool:
    """Whether bounds between the rows of a track are known: its ways are proved, no point moves."""
    return track.certified and not track.coordinates and len(track.t) > 1


def worst_between(
    track: Track,
    quantity: str,
    wanted: float,
    ways: PoseWays | None = None,
    frame: PoseFrame | None = None,
) -> Between | None:
    """Return the way between two rows on which a quantity is worst; None if all are proved.

    Parameters
    ----------
    track
        A track for which `can_be_bounded` holds.
    quantity
        A key of `BOUNDED`.
    wanted
        The largest condition number, or the least clearance or gap.
    ways
        Straight ways in position and angles, if they lead from row to row; None for values.
    frame
        The frame of the poses of these ways; None for the platform's own.
    """
    worst: Between | None = None
    for k, mode in enumerate(track.modes.tolist()):
        there = np.flatnonzero(~np.isnan(track.T[k, :, 0]))
        if len(there) < 2:
            continue
        _, bounds = BOUNDED[quantity](_rows(track, k, there, ways, frame), wanted)
        bad = bounds if quantity == "condition" else -bounds
        row = int(bad.argmax())
        kept = bounds[row] <= wanted if quantity == "condition" else bounds[row] >= wanted
        if not kept and (worst is None or bad[row] > _badness(worst, quantity)):
            worst = Between(mode, int(there[row]), float(bounds[row]))
    return worst


def _badness(one: Between, quantity: str) -> float:
    return one.bound if quantity == "condition" else -one.bound


def _rows(
    track: Track, k: int, there: NDArray[np.int64], ways: PoseWays | None, frame: PoseFrame | None
) -> PathRows:
    """Return the rows of one mode."""
    R, T, values = track.R[k, there], track.T[k, there], track.values[there]
    if ways is not None:
        if frame is not None:
            R, T = frame.from_platform(R, T)
        return PathRows(ways, values, R, T, ways.continued(R, T))
    # Limits are judged apart: a way that leaves them has its condition numbers all the same.
    instance = without_corrections(track.followed)
    rows = tuple(replace(row, limits=None) for row in instance.constraints)
    free = ValueWays(replace(instance, constraints=rows), np.sign(values[0]))
    return PathRows(free, values, R, T, weights=PathRows.weights_of(track.instance))
