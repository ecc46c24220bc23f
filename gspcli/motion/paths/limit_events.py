"""The times at which a motion leaves ranges and cones or keeps them again, and dead points.

Values and drives change linearly between rows, so they leave a range at one time. Cones are judged
on the proved segments of each mode (`gspcli.motion.paths.between`). A mode passes a dead point
between two rows if the gain of a drive has different signs there; gains between rows are not
computed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.limits import joint_cones, out_of_cone, out_of_motor_range, out_of_range
from gspcli.geometry.machine import Machine, is_driven
from gspcli.motion.following.followed_rows import RowFollower
from gspcli.motion.following.tracks import Track
from gspcli.motion.paths.between import MovingRows, ValueParts, cone_margins, signs
from gspcli.records import dataclass

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: The part of a step between rows next to a fold that may be skipped: parts get too short there.
_BESIDE = 1e-7
#: The sign of a smaller transmission is not known.
_SIGN_KNOWN = 1e-9


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


def limit_events(track: Track) -> list[LimitEvent]:
    """Return the events at which a trajectory leaves limits or keeps them again, by t.

    Those of cranks and slides only if they move.
    """
    found = _ranges(track)
    if track.coordinates and is_driven(track.instance):
        drives = Machine.of(track.instance)
        q = drive_rows(track, drives)
        found += [*_drive_ranges(track, drives, q), *_dead_points(track, drives, q)]
    found += _cones(track)
    return sorted(found, key=lambda event: (event.low, event.high, event.constraint))


def _ranges(track: Track) -> list[LimitEvent]:
    found, instance = [], track.instance
    for k, row in enumerate(instance.constraints):
        if row.limits is not None:
            ends = np.array([limit.value for limit in row.limits])
            if row.kind.has_sides and row.side is not Side.POSITIVE:
                ends = np.concatenate((-ends, ends)) if row.side is Side.BOTH else -ends
            found += [
                LimitEvent("range", leaves, k, "", None, time, time, True)
                for time, leaves in crossings(
                    track.t, track.values[:, k], ends, partial(_outside, instance, k)
                )
            ]
    return found


def _outside(instance: Instance, k: int, values: Array) -> Mask:
    """Return which values of one constraint are outside its range, shape (n,)."""
    rows = np.zeros((len(values), len(instance.constraints)))
    rows[:, k] = values
    return out_of_range(instance, rows)[:, k]


def drive_rows(track: Track, drives: Machine) -> Array:
    """Return the numbers of the drives in each row, lengths and radians, shape (r, m)."""
    q = np.zeros((len(track.t), drives.count))
    for k in range(drives.count):
        if not drives.moved[k]:
            q[:, k] = track.values[:, drives.users(k)[0]] * drives.units[k]
    for c, one in enumerate(track.coordinates):
        k = drives.names.index(one.name)
        q[:, k] = track.places[:, c] * drives.units[k]
    return q


def _drive_ranges(track: Track, drives: Machine, q: Array) -> list[LimitEvent]:
    def outside(k: int, numbers: Array) -> Mask:
        rows = np.tile(q[0], (len(numbers), 1))
        rows[:, k] = numbers
        return out_of_motor_range(drives, rows)[:, k]

    return [
        LimitEvent("range", leaves, drives.users(k)[0], "", None, time, time, True, drives.names[k])
        for k in np.flatnonzero(drives.moved & np.isfinite(drives.high)).tolist()
        for time, leaves in crossings(
            track.t, q[:, k], np.array([drives.low[k], drives.high[k]]), partial(outside, k)
        )
    ]


def crossings(
    t: Array, numbers: Array, ends: Array, outside: Callable[[Array], Mask]
) -> Iterator[tuple[float, bool]]:
    """Yield when a number that is linear between rows leaves a range (true) or is in it again.

    Parameters
    ----------
    t, numbers
        The rows, shapes (r,).
    ends
        The numbers at which the range begins or ends, shape (e,).
    outside
        Returns which numbers are outside.
    """
    first, change = numbers[:-1, None], np.diff(numbers)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = (ends - first) / change
    # Cuts outside the rows are NaN and are sorted last.
    cuts = np.sort(np.where((parts > 0) & (parts < 1), parts, np.nan), axis=1)
    edge = np.zeros((len(cuts), 1))
    begins = np.hstack((edge, cuts))
    stops = np.nan_to_num(np.hstack((cuts, edge + 1)), nan=1.0)
    real = ~np.isnan(begins)
    middles = (first + (begins + stops) / 2 * change)[real]
    times = np.concatenate((t[:1], (t[:-1, None] + begins * np.diff(t)[:, None])[real]))
    now = outside(np.concatenate((numbers[:1], middles)))
    changes = np.flatnonzero(now != np.concatenate(([False], now[:-1])))
    yield from zip(times[changes].tolist(), now[changes].tolist(), strict=True)


def _dead_points(track: Track, drives: Machine, q: Array) -> list[LimitEvent]:
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


def cones_proved(track: Track) -> bool:
    """Whether all statements about cones are proved, also between rows."""
    legs = [joint.constraint for joint in joint_cones(track.instance)]
    if not track.certified or len(track.t) < 2 or not (track.values[:, legs] >= 0).all():
        return False
    try:
        follower = RowFollower(track.followed, track.coordinates)
    except ArgumentError:
        return False
    return follower.knows(_followed(track))


def _followed(track: Track) -> Array:
    """Return values and numbers of drives at the rows, shape (r, 6 + d)."""
    return np.column_stack((track.values, track.places)) if track.coordinates else track.values


def _cones(track: Track) -> list[LimitEvent]:
    if not joint_cones(track.instance):
        return []
    return _between_rows(track) if cones_proved(track) else _at_rows(track)


def _between_rows(track: Track) -> list[LimitEvent]:
    """Return the events of cones, proved between rows, too."""
    instance, rows, cones, found = track.followed, _followed(track), joint_cones(track.instance), []
    drives = Machine.of(instance) if track.coordinates else None
    numbers = track.values if drives is None else drive_rows(track, drives)
    follower = RowFollower(instance, track.coordinates)
    measure, centre = cone_margins(instance, drives), Arrangement.of(instance).platform_centre
    for m, mode in enumerate(track.modes.tolist()):
        # Modes that begin on the way are followed back from the last row.
        step = -1 if np.isnan(track.T[m, 0, 0]) else 1
        R, T = track.R[m, ::step], track.T[m, ::step]
        moving = MovingRows(follower, rows[::step], R, T, numbers[::step], drives)
        end = int(np.isfinite(T[:, 0]).sum())
        parts = ValueParts(moving, np.arange(min(end, len(rows) - 1)), centre)
        begin, stop, sign = signs(measure, parts, len(cones))
        if step < 0:
            begin, stop, sign = len(rows) - 1 - stop[::-1], len(rows) - 1 - begin[::-1], sign[::-1]
        times = [
            (_time(track, a), _time(track, b))
            for a, b in zip(begin.tolist(), stop.tolist(), strict=True)
        ]
        low, high = _lifetime(track, mode)
        for cone, states in zip(cones, sign.T.tolist(), strict=True):
            found += [
                LimitEvent("cone", leaves, cone.constraint, cone.body, mode, since, until, proved)
                for leaves, since, until, proved in _changes(times, states, low, high, _room(track))
            ]
    return found


def _time(track: Track, row: float) -> float:
    """Return t at a row, counted from 0, with a fraction."""
    k = min(int(row), len(track.t) - 2)
    return float(track.t[k] + (row - k) * (track.t[k + 1] - track.t[k]))


def _room(track: Track) -> float:
    """Return the time next to a fold that may be skipped, in units of t."""
    return float(_BESIDE * np.diff(track.t).max(initial=0.0))


def _lifetime(track: Track, mode: int) -> tuple[float, float]:
    """Return the interval of t on which a mode is known."""
    low, high = float(track.t[0]), float(track.t[-1])
    for event in track.events:
        if event.mode == mode:
            low, high = (event.high, high) if event.begins else (low, event.low)
    return low, high


def _changes(
    times: Sequence[tuple[float, float]],
    states: Sequence[int],
    low: float,
    high: float,
    room: float,
) -> Iterator[tuple[bool, float, float, bool]]:
    """Yield the events of one cone: whether it is left, the interval of t, whether it is proved.

    Parameters
    ----------
    times, states
        The proved stretches, in order; there may be gaps.
    low, high
        The interval that the stretches should cover, up to `room`.
    """
    state, since, allowed = 1, low, room
    for (begin, end), now in zip(times, states, strict=True):
        if now == 0:
            continue
        if now != state:
            yield now < 0, since, begin, True
        elif begin - since > allowed:
            yield True, since, begin, False
        state, since, allowed = now, end, 0.0
    if high - since > room:
        yield True, since, high, False


def _at_rows(track: Track) -> list[LimitEvent]:
    """Return the events of cones by the poses at the rows; each event is between two rows."""
    cones = joint_cones(track.instance)
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
                    low, high = track.t[[row if before is None else before, row]].tolist()
                    found.append(
                        LimitEvent("cone", now, cone.constraint, cone.body, mode, low, high, False)
                    )
                    state = now
                before = row
    return found
