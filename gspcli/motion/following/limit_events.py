"""The times at which a motion leaves ranges of values and cones of joints, or keeps them again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.limits import joint_cones, out_of_cone, out_of_range
from gspcli.motion.following.cone_limits import ConeProofs, Stretch
from gspcli.motion.following.drive_events import drive_events
from gspcli.motion.following.followed_rows import RowFollower
from gspcli.motion.following.limit_event import LimitEvent
from gspcli.motion.following.tracks import Track

Array = NDArray[np.float64]

#: The part of a step between rows next to a fold that may be skipped: parts get too short there.
_BESIDE = 1e-7


def limit_events(track: Track) -> list[LimitEvent]:
    """Return the events at which a trajectory leaves limits or keeps them again, by t."""
    found = [*_ranges(track), *drive_events(track), *_cones(track)]
    return sorted(found, key=lambda event: (event.low, event.high, event.constraint))


def _ranges(track: Track) -> list[LimitEvent]:
    found = []
    for k, constraint in enumerate(track.instance.constraints):
        if constraint.limits is None:
            continue
        times, outside = _pieces(track.instance, k, track.t, track.values[:, k])
        changes = np.flatnonzero(outside != np.concatenate(([False], outside[:-1])))
        found += [
            LimitEvent("range", leaves, k, "", None, time, time, True)
            for time, leaves in zip(times[changes].tolist(), outside[changes].tolist(), strict=True)
        ]
    return found


def _pieces(instance: Instance, k: int, t: Array, values: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the beginnings of pieces of the motion of one value; which are out of range.

    The first piece is the first row; between rows a piece ends wherever the value meets an end of
    the range.
    """
    constraint = instance.constraints[k]
    assert constraint.limits is not None
    ends = np.array([limit.value for limit in constraint.limits])
    if constraint.kind.has_sides and constraint.side is not Side.POSITIVE:
        ends = np.concatenate((-ends, ends)) if constraint.side is Side.BOTH else -ends
    first, change = values[:-1, None], np.diff(values)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = (ends - first) / change
    # Cuts outside the rows are NaN and are sorted last.
    cuts = np.sort(np.where((parts > 0) & (parts < 1), parts, np.nan), axis=1)
    edge = np.zeros((len(cuts), 1))
    begins = np.hstack((edge, cuts))
    stops = np.nan_to_num(np.hstack((cuts, edge + 1)), nan=1.0)
    real = ~np.isnan(begins)
    middles = (first + (begins + stops) / 2 * change)[real]
    times = (t[:-1, None] + begins * np.diff(t)[:, None])[real]
    rows = np.zeros((len(middles) + 1, len(instance.constraints)))
    rows[:, k] = np.concatenate((values[:1], middles))
    return np.concatenate((t[:1], times)), out_of_range(instance, rows)[:, k]


def cones_proved(track: Track) -> bool:
    """Whether all statements about cones are proved, also between rows."""
    legs = [joint.constraint for joint in joint_cones(track.instance)]
    if not track.certified or len(track.t) < 2 or not (track.values[:, legs] >= 0).all():
        return False
    try:
        follower = RowFollower(track.followed, track.coordinates)
    except ArgumentError:
        return False
    return follower.knows(_rows(track))


def _rows(track: Track) -> Array:
    """Return values and numbers of drives at the rows, shape (r, 6 + d)."""
    return np.column_stack((track.values, track.places)) if track.coordinates else track.values


def _cones(track: Track) -> list[LimitEvent]:
    if not joint_cones(track.instance):
        return []
    return _between_rows(track) if cones_proved(track) else _at_rows(track)


def _between_rows(track: Track) -> list[LimitEvent]:
    """Return the events of cones, proved between rows, too."""
    rows = _rows(track)
    found = []
    # Modes that begin on the way are followed back from the last row.
    born = np.isnan(track.T[:, 0, 0])
    for step in (1, -1):
        proofs = ConeProofs(track.followed, track.coordinates, rows[::step])
        modes = np.flatnonzero(born == (step < 0)).tolist()
        every = proofs.stretches(track.R[modes, ::step], track.T[modes, ::step])
        for m, stretches in zip(modes, every, strict=True):
            found += _events(track, m, stretches if step > 0 else _turned(stretches, len(rows)))
    return found


def _turned(stretches: Sequence[Stretch], rows: int) -> list[Stretch]:
    """Return stretches of the reversed trajectory."""
    return [
        replace(one, begin=rows - 1 - one.end, end=rows - 1 - one.begin) for one in stretches[::-1]
    ]


def _events(track: Track, m: int, stretches: Sequence[Stretch]) -> list[LimitEvent]:
    """Return the events of the cones of the m-th mode."""
    mode, found = int(track.modes[m]), []
    times = [(_time(track, one.begin), _time(track, one.end)) for one in stretches]
    low, high = _lifetime(track, mode)
    for k, cone in enumerate(joint_cones(track.instance)):
        states = [one.states[k] for one in stretches]
        place = cone.constraint, cone.body, mode
        found += [
            LimitEvent("cone", leaves, *place, begin, end, proved)
            for leaves, begin, end, proved in _changes(times, states, low, high, _room(track))
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
