"""What a proved track keeps between its rows: condition numbers, clearances and gaps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.coordinates import coordinates, moved
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.machine import Machine, arms_of
from gspcli.geometry.readings import without_corrections
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.tracks import Track
from gspcli.motion.paths.between import (
    PathRows,
    largest_conditions,
    least_clearances,
    least_gaps,
    least_transmissions,
)
from gspcli.motion.paths.limit_events import drive_rows
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.value_ways import ValueWays
from gspcli.motion.singularities.clearances import range_weights
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Rods are the stated ones up to this part of their length.
_SAME = 1e-12

#: What is judged between rows: whether the least counts, not the largest.
_BOUNDS = {
    "condition": largest_conditions,
    "clearance": least_clearances,
    "gap": least_gaps,
    "transmission": least_transmissions,
}
BOUNDED = {"condition": False, "clearance": True, "gap": True, "transmission": True}


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


def can_be_bounded(track: Track, quantity: str = "") -> bool:
    """Whether bounds of a quantity between the rows of a track are known.

    Its ways are proved, and where drives move the rods are those stated. Arms
    of cranks that stay while the rods change have gaps at the rows only.
    """
    if not track.certified or len(track.t) < 2:
        return False
    if track.coordinates:
        return moves_by_drives(track)
    return quantity != "gap" or not arms_of(track.instance)


def moves_by_drives(track: Track) -> bool:
    """Whether cranks and slides move a track, and nothing else, with the stated rods."""
    instance = track.instance
    if not track.coordinates:
        return False
    drives = Machine.of(instance)
    rods = track.values[:, drives.driven] - drives.rods[drives.driven]
    return bool((np.abs(rods) <= _SAME * np.abs(drives.rods[drives.driven])).all())


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
        The largest condition number, or the least clearance, gap or transmission.
    ways
        Straight ways in position and angles, if they lead from row to row; None for values and
        drives.
    frame
        The frame of the poses of these ways; None for the platform's own.
    """
    worst: Between | None = None
    least = BOUNDED[quantity]
    for k, mode in enumerate(track.modes.tolist()):
        there = np.flatnonzero(~np.isnan(track.T[k, :, 0]))
        if len(there) < 2:
            continue
        at, bounds = _BOUNDS[quantity](_rows(track, k, there, ways, frame), wanted)
        sign = 1 if least else -1
        ends = np.minimum(sign * at[:-1], sign * at[1:])
        row = int(np.lexsort((ends, sign * bounds))[0])
        kept = sign * bounds[row] >= sign * wanted
        if not kept and (worst is None or sign * bounds[row] < sign * worst.bound):
            worst = Between(mode, int(there[row]), float(bounds[row]))
    return worst


def _rows(
    track: Track, k: int, there: NDArray[np.int64], ways: PoseWays | None, frame: PoseFrame | None
) -> PathRows:
    """Return the rows of one mode."""
    R, T, values = track.R[k, there], track.T[k, there], track.values[there]
    if ways is not None:
        if frame is not None:
            R, T = frame.from_platform(R, T)
        parameters = ways.continued(R, T)
        return PathRows(ways, values, R, T, parameters)
    if track.coordinates:
        return _of_drives(track, k, there)
    instance = without_corrections(track.followed)
    # Drives that no column moves stay where the file states their points.
    still = coordinates(instance)
    instance = moved(instance, still, np.zeros(len(still)))
    # Limits are judged apart: a way that leaves them has its condition numbers all the same.
    rows = tuple(replace(row, limits=None) for row in instance.constraints)
    free = ValueWays(replace(instance, constraints=rows), np.sign(values[0]))
    return PathRows(free, values, R, T, weights=range_weights(track.instance))


def _of_drives(track: Track, k: int, there: NDArray[np.int64]) -> PathRows:
    """Return the rows of one mode of a track of drives."""
    instance = without_corrections(track.instance)
    R, T = track.R[k, there], track.T[k, there]
    drives = Machine.of(instance)
    numbers = drive_rows(track, drives)[there]
    # Where no home is stated the working modes are those of the mode.
    gains = drives.gains(R[0], T[0], numbers[0])
    working_modes = np.where(drives.driven & (gains < 0), -1, 1)
    ways = PoseWays(instance, limits=False, working_modes=working_modes)
    geometry = MovingGeometry(track.followed, track.coordinates)
    return PathRows(ways, track.values[there], R, T, numbers=numbers, geometry=geometry)
