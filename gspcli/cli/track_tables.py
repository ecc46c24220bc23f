"""The table and the sentences of `gsp track`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.cli.limit_sentences import cones_notes
from gspcli.cli.output import Column, Table
from gspcli.cli.output.tables import pose_columns
from gspcli.cli.pose_options import frame_note
from gspcli.wording import counted

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.frames import PoseFrame
    from gspcli.motion import Event, Track
    from gspcli.motion.following.limit_event import LimitEvent

    Array = NDArray[np.float64]


def track_table(
    result: Track,
    rows: list[dict[str, Any]],
    limits: list[LimitEvent],
    more: list[Column],
    summary: list[str],
    frame: PoseFrame,
) -> Table:
    """Return the table of the rows, with what is proved of the track below it."""
    from gspcli.geometry.arrangement import Arrangement
    from gspcli.motion.following.tracks import POSE

    columns = [Column(key, align="right", essential=True) for key in ("t", "mode")]
    columns += pose_columns(POSE, Arrangement.of(result.instance).length)
    columns.append(Column("condition", align="right"))
    columns += [
        Column(key, key.replace("_", " "), align="right", essential=True)
        for key in ("clearance", "pose_clearance")
        if rows and key in rows[0]
    ]
    columns += more
    names = [one.name for one in result.coordinates]
    columns += [Column(name, align="right", minor=1) for name in names]
    if names:
        at = {t: dict(zip(names, place, strict=True)) for t, place in _places(result)}
        rows = [{**row, **at[row["t"]]} for row in rows]
    instance = result.instance
    title = instance.title
    kept = len(result.modes) - len(result.events)
    how = "proved" if result.certified else "not proved"
    note = (
        f"{counted(len(result.modes), 'mode')}, {kept} of them from the first row to the last, "
        f"{how}"
    )
    if result.complete:
        note += "; every real pose at the last row is accounted for"
    notes = [note, *cones_notes(result, limits), *frame_note(frame)]
    return Table(columns, rows, title=title, notes=notes, summary=summary)


def _places(result: Track) -> Iterator[tuple[float, list[float]]]:
    """Yield t and the coordinates that move at each row."""
    return zip(result.t.tolist(), result.places.tolist(), strict=True)


def event_sentence(event: Event) -> str:
    """Return an event of a mode between rows, in words."""
    if event.kind == "undecided":
        what = "cannot be followed back before" if event.begins else "cannot be followed beyond"
        t = event.high if event.begins else event.low
        return f"mode {event.mode} {what} t = {t:.10g}: {event.reason} (undecided)"
    partner = "another" if event.partner is None else f"mode {event.partner}"
    if event.begins:
        return f"mode {event.mode} begins with {partner} in a fold at t = {event.low:.12g}, proved"
    return f"mode {event.mode} meets {partner} in a fold at t = {event.low:.12g} and ends, proved"
