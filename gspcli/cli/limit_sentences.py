"""What `gsp track` says about ranges and cones along a trajectory."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING, Any

from gspcli.geometry.limits import joint_cones
from gspcli.wording import listed

if TYPE_CHECKING:
    from gspcli.motion import Track
    from gspcli.motion.following.limit_event import LimitEvent


def plain_limit(event: LimitEvent) -> dict[str, Any]:
    """Return an event as plain data."""
    drive = {"drive": event.drive} if event.drive else {}
    return {
        "kind": event.kind,
        "leaves": event.leaves,
        "constraint": event.constraint + 1,
        "body": event.body or None,
        "mode": event.mode,
        "t": [event.low, event.high],
        "proved": event.proved,
        **drive,
    }


def cones_notes(result: Track, events: list[LimitEvent]) -> list[str]:
    """Return which modes are proved to keep all cones, where there are any and anything is."""
    from gspcli.motion.following.limit_events import cones_proved

    if not joint_cones(result.instance) or not cones_proved(result):
        return []
    leaving = {event.mode for event in events if event.kind != "dead point"}
    modes = [mode for mode in result.modes.tolist() if mode not in leaving]
    if not modes:
        return ["no mode keeps all cones from beginning to end"] if leaving else []
    every = len(modes) == len(result.modes) > 1
    names = "all modes keep" if every else _named(modes)
    return [f"{names} all cones from beginning to end, between rows too: proved"]


def _named(modes: list[int]) -> str:
    if len(modes) == 1:
        return f"mode {modes[0]} keeps"
    return f"modes {listed(map(str, modes), 'and')} keep"


def limit_sentences(result: Track, events: list[LimitEvent]) -> list[str]:
    """Return in words where limits are left and kept again."""
    from gspcli.motion.following.limit_events import cones_proved

    found = []
    certain = cones_proved(result)
    for _, same in groupby(events, lambda event: (event.proved, event.mode, event.low, event.high)):
        together = list(same)
        cones = [one for one in together if one.kind == "cone"]
        if certain and cones and not cones[0].proved:
            found += [_sentence(result, one) for one in together if one.kind != "cone"]
            found.append(_undecided(cones))
        else:
            found += [_sentence(result, event) for event in together]
    return found


def _undecided(events: list[LimitEvent]) -> str:
    """Return that it is not known whether some cones of a mode are left."""
    event = events[0]
    legs = sorted({one.constraint + 1 for one in events})
    which = (
        f"leg {legs[0]} keeps" if len(legs) == 1 else f"legs {listed(map(str, legs), 'and')} keep"
    )
    cone = "its cone" if len(legs) == 1 else "their cones"
    when = f"between t = {event.low:.10g} and {event.high:.10g}"
    return f"mode {event.mode}: whether {which} {cone} {when} is undecided"


def _sentence(result: Track, event: LimitEvent) -> str:
    at_first = event.high == result.t[0]
    what = "is outside" if at_first else "leaves" if event.leaves else "comes back into"
    if event.drive:
        return _of_drive(result, event, what)
    if event.kind == "range":
        row = result.instance.constraints[event.constraint]
        low, high = map(row.reading_of, row.limits or ())
        when = f"at t = {event.low:.10g}"
        if not event.proved and event.low < event.high:
            what = "may leave"
            when = f"between t = {event.low:.10g} and {event.high:.10g}"
        subject = f"the value of constraint {event.constraint + 1} {what} its range"
        return f"{subject} from {low} to {high} {when}"
    when = f"between t = {event.low:.10g} and {event.high:.10g}"
    if event.proved or event.low == event.high:
        when = f"at t = {event.low:.9g}"
    proved = ", proved" if event.proved else ""
    subject = f"mode {event.mode}: leg {event.constraint + 1} {what} its cone"
    return f"{subject} at the {event.body} {when}{proved}"


def _of_drive(result: Track, event: LimitEvent, what: str) -> str:
    """Return what a crank or slide does."""
    if event.kind == "dead point":
        when = f"between t = {event.low:.10g} and {event.high:.10g}"
        subject = f"mode {event.mode}: rod {event.constraint + 1} passes a dead point"
        return f"{subject} of {event.drive} {when}"
    from gspcli.geometry.drives import Drives

    drives = Drives.of(result.instance)
    k = drives.names.index(event.drive)
    low, high = (f"{drives.readings(end)[k]:.10g}" for end in (drives.low, drives.high))
    when = f"at t = {event.low:.10g}"
    if not event.proved and event.low < event.high:
        what = "may leave"
        when = f"between t = {event.low:.10g} and {event.high:.10g}"
    return f"{event.drive} {what} its range from {low} to {high} {when}"
