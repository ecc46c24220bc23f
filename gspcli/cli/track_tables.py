"""The table, the document and the sentences of `gsp track`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.cli.limit_sentences import cones_notes, plain_limit
from gspcli.cli.output import Column, Table
from gspcli.wording import counted

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from gspcli.motion import Event, Track
    from gspcli.motion.following.limit_events import LimitEvent

    Array = NDArray[np.float64]


_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def track_rows(result: Track, more: Mapping[str, Array]) -> list[dict[str, Any]]:
    """Return a row for each pose, with more numbers, each of shape (m, r)."""
    import numpy as np

    keys = ("t", "mode", *_POSE, "condition", *more)
    numbers = np.dstack((result.T, result.quaternions, result.conditions, *more.values()))
    there = ~np.isnan(result.T[..., 0])
    modes = result.modes.tolist()
    return [
        dict(zip(keys, (t, mode, *pose), strict=True))
        for t, poses, known in zip(
            result.t.tolist(), numbers.swapaxes(0, 1).tolist(), there.T.tolist(), strict=True
        )
        for mode, pose, here in zip(modes, poses, known, strict=True)
        if here
    ]


def track_table(
    result: Track,
    rows: list[dict[str, Any]],
    limits: list[LimitEvent],
    more: list[Column],
    summary: list[str],
) -> Table:
    """Return the table of the rows, with what is proved of the track below it."""
    columns = [
        Column(key, align="right", essential=True, aligned=key in _POSE)
        for key in ("t", "mode", *_POSE)
    ]
    columns.append(Column("condition", align="right"))
    columns += [
        Column(key, key.replace("_", " "), align="right", essential=True)
        for key in ("clearance", "pose_clearance")
        if rows and key in rows[0]
    ]
    columns += more
    names = [one.name for one in result.coordinates]
    columns += [Column(name, align="right", minor=1) for name in names]
    at = {t: dict(zip(names, place, strict=True)) for t, place in _places(result)}
    rows = [{**row, **at[row["t"]]} for row in rows]
    instance = result.instance
    title = instance.title
    kept = len(result.modes) - len(result.events)
    how = "proved" if result.certified else "not proved"
    note = (
        f"{counted(len(result.modes), 'mode')}, {kept} of them from the first row to the last; "
        f"{counted(result.segments, 'part')}, {how}"
    )
    if result.complete:
        note += "; every real pose at the last row is accounted for"
    notes = [note, *cones_notes(result, limits)]
    return Table(columns, rows, title=title, notes=notes, summary=summary)


def _places(result: Track) -> Iterator[tuple[float, list[float]]]:
    """Yield t and the coordinates that move at each row."""
    return zip(result.t.tolist(), result.places.tolist(), strict=True)


def track_document(
    result: Track, rows: list[dict[str, Any]], limits: list[LimitEvent]
) -> dict[str, Any]:
    """Return a track for JSON."""
    instance = result.instance
    return {
        "schema": "gsp.track/1",
        **instance.to_json(),
        "certified": result.certified,
        "complete": result.complete,
        "modes": result.modes.tolist(),
        "new": result.new,
        "coordinates": {
            one.name: result.places[:, k].tolist() for k, one in enumerate(result.coordinates)
        },
        "parts": result.segments,
        "poses": rows,
        "events": [_plain(event) for event in result.events],
        "limits": [plain_limit(event) for event in limits],
    }


def _plain(event: Event) -> dict[str, Any]:
    return {
        "kind": event.kind,
        "reason": event.reason,
        "begins": event.begins,
        "mode": event.mode,
        "partner": event.partner,
        "row": event.row + 1,
        "t": [event.low, event.high],
        "R": _finite(event.R),
        "T": _finite(event.T),
        "partner_R": None if event.partner_R is None else event.partner_R.tolist(),
        "partner_T": None if event.partner_T is None else event.partner_T.tolist(),
    }


def _finite(part: Array) -> Any:
    """Return a part of a pose; None at infinity, where there is none."""
    import numpy as np

    return part.tolist() if np.isfinite(part).all() else None


def event_sentence(event: Event) -> str:
    """Return what happens to a mode between rows, in words."""
    if event.kind == "undecided":
        what = "cannot be followed back before" if event.begins else "cannot be followed beyond"
        t = event.high if event.begins else event.low
        return f"mode {event.mode} {what} t = {t:.10g}: {event.reason} (undecided)"
    partner = "another" if event.partner is None else f"mode {event.partner}"
    if event.begins:
        return f"mode {event.mode} begins with {partner} in a fold at t = {event.low:.12g}, proved"
    return f"mode {event.mode} meets {partner} in a fold at t = {event.low:.12g} and ends, proved"
