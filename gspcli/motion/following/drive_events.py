"""Where cranks and slides leave their ranges along a track, and pass dead points."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.drives import Drives, is_driven
from gspcli.geometry.limits import out_of_motor_range
from gspcli.motion.following.limit_event import LimitEvent
from gspcli.motion.following.tracks import Track

Array = NDArray[np.float64]

#: The sign of a smaller transmission is not known.
_SIGN_KNOWN = 1e-9


def drive_events(track: Track) -> list[LimitEvent]:
    """Return the events of cranks and slides; none if there are no such drives or they do not move.

    Drives move linearly between rows, so they leave a range at one t. A mode passes a dead point
    between two rows if the gain of a drive has different signs there; gains between rows are not
    computed.
    """
    if not is_driven(track.instance) or not track.coordinates:
        return []
    drives = Drives.of(track.instance)
    q = drive_rows(track, drives)
    return [*_ranges(track, drives, q), *_dead_points(track, drives, q)]


def drive_rows(track: Track, drives: Drives) -> Array:
    """Return the numbers of the drives in each row, lengths and radians, shape (r, m)."""
    q = np.zeros((len(track.t), drives.count))
    for k in range(drives.count):
        if not drives.moved[k]:
            q[:, k] = track.values[:, drives.users(k)[0]] * drives.units[k]
    for c, one in enumerate(track.coordinates):
        k = drives.names.index(one.name)
        q[:, k] = track.places[:, c] * drives.units[k]
    return q


def _ranges(track: Track, drives: Drives, q: Array) -> list[LimitEvent]:
    found = []
    for k in np.flatnonzero(drives.moved & np.isfinite(drives.high)):
        times, outside = _pieces(drives, int(k), track.t, q)
        changes = np.flatnonzero(outside != np.concatenate(([False], outside[:-1])))
        user, name = drives.users(int(k))[0], drives.names[k]
        found += [
            LimitEvent("range", leaves, user, "", None, time, time, True, name)
            for time, leaves in zip(times[changes].tolist(), outside[changes].tolist(), strict=True)
        ]
    return found


def _pieces(drives: Drives, k: int, t: Array, q: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the first row and the pieces between rows on which a drive meets no end of its range.

    Returns the beginnings of these pieces, and which pieces are out of range.
    """
    times, places = [t[0]], [q[0, k]]
    for row in range(len(t) - 1):
        first, change = q[row, k], q[row + 1, k] - q[row, k]
        cuts = [0.0, 1.0]
        if change:
            ends = ((end - first) / change for end in (drives.low[k], drives.high[k]))
            cuts = [0.0, *sorted(part for part in ends if 0 < part < 1), 1.0]
        for begin, stop in pairwise(cuts):
            times.append(t[row] + begin * (t[row + 1] - t[row]))
            places.append(first + (begin + stop) / 2 * change)
    rows = np.tile(q[0], (len(places), 1))
    rows[:, k] = places
    return np.array(times), out_of_motor_range(drives, rows)[:, k]


def _dead_points(track: Track, drives: Drives, q: Array) -> list[LimitEvent]:
    there = ~np.isnan(track.T[..., 0])
    gains = np.full((*track.T.shape[:2], len(drives.index)), np.nan)
    numbers = np.broadcast_to(q, (len(track.modes), *q.shape))
    gains[there] = drives.gains(track.R[there], track.T[there], numbers[there])
    found = []
    for m, mode in enumerate(track.modes.tolist()):
        for k in np.flatnonzero(drives.driven).tolist():
            known = np.abs(gains[m, :, k]) > _SIGN_KNOWN * drives.arms[k]
            rows = np.flatnonzero(known)
            signs = np.sign(gains[m, rows, k])
            for i in np.flatnonzero(signs[1:] != signs[:-1]):
                low, high = track.t[rows[[i, i + 1]]].tolist()
                name = drives.names[drives.index[k]]
                event = LimitEvent(
                    "dead point", True, k, "", mode, low, high, track.certified, name
                )
                found.append(event)
    return found
