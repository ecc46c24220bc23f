"""The tables of `gsp workspace` that say how far each axis travels."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

from gspcli.cli.grids import PARAMETERS, span_of
from gspcli.cli.output import Column, Output, Table, emit
from gspcli.cli.pose_options import frame_note
from gspcli.cli.progress_bars import progress
from gspcli.cli.reachable_home import Home
from gspcli.errors import GspError
from gspcli.geometry.drive_numbers import driven_points, is_driven, shares_drives
from gspcli.wording import listed, shown

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gspcli.geometry.instance import Instance
    from gspcli.motion import Travel

_MOST_HELD = 1000


def _offsets(held: tuple[str, ...]) -> list[dict[str, float]]:
    """Return by how much parameters are moved from home, all combinations."""
    import numpy as np

    from gspcli.motion.files.number_tables import wrong_number

    choices: dict[str, list[float]] = {}
    for text in held:
        name, equals, value = text.replace(" ", "").partition("=")
        if equals and name in PARAMETERS and not wrong_number(value):
            values = [float(value)]
        else:
            name, low, high, count = span_of("shift", text)
            if count is None or count < 1:
                message = (
                    f"--shift: found {shown(text)}, expected NAME=VALUE or NAME=LOW:HIGH:COUNT"
                )
                raise GspError(message)
            if count > _MOST_HELD:
                message = f"--shift: found {count} values, expected at most {_MOST_HELD}"
                raise GspError(message)
            values = np.linspace(low, high, count).tolist()
        choices.setdefault(name, []).extend(values)
    found = [dict(zip(choices, row, strict=True)) for row in product(*choices.values())]
    if len(found) > _MOST_HELD:
        message = f"--shift: found {len(found)} combinations, expected at most {_MOST_HELD}"
        raise GspError(message)
    return found


def show_travels(
    instance: Instance,
    home: Home,
    sequence: str,
    held: tuple[str, ...],
    output: Output,
    *,
    connected: bool,
    knees: ArrayLike | None = None,
    gap: float | None = None,
) -> None:
    """Show how far each axis travels from home.

    Parameters
    ----------
    instance, home, sequence
        The platform, where it starts and the order of the turns.
    held
        What is moved first, as ``--shift`` has it.
    output
        Where to.
    connected
        Whether singular poses end a travel, too.
    knees
        The knees of cranks and slides, as `gspcli.motion.workspace.travels.travels` has them.
    gap
        How far legs and bodies must be apart; None if that is not checked.
    """
    offsets = _offsets(held)
    names = list(offsets[0])
    rows: list[dict[str, Any]] = []
    for offset in progress(offsets, total=len(offsets), label="travels"):
        rows += _offset_rows(
            instance, home, sequence, offset, connected=connected, knees=knees, gap=gap
        )
    units = instance.units
    columns = [
        *(Column(f"held_{name}", f"{name} held", "right", True) for name in names),
        Column("axis", essential=True),
        # Lengths and angles differ in size: with the decimals that suit the larger, the smaller
        # would be lost.
        *(Column(key, align="right", essential=True) for key in ("down", "up", "total")),
        Column("down_stops", "stops down", fold=", "),
        Column("up_stops", "stops up", fold=", "),
    ]
    if output.format == "csv":
        columns[-2:-2] = [Column("down_end"), Column("up_end")]
    apart = "" if gap is None else f", legs are {gap:g} {units.length} apart"
    what = f"all limits are kept{apart}" + (" and no pose is singular" if connected else "")
    notes = [
        f"from home: {home.text}",
        f"x, y, z in {units.length}, rx, ry, rz in {units.angle.value}; proved: up to there {what}",
    ]
    notes += frame_note(home.frame)
    notes += _free_values(instance)
    if shares_drives(instance):
        notes.append("rods share drives: what the platform reaches when it turns is not computed")
    if any(row["down"] is None for row in rows):
        notes.append("without numbers: the pose from which an axis would travel leaves the limits")
    prefix = "held_"
    travel = [
        {
            "held": {name: row[prefix + name] for name in names},
            **{key: value for key, value in row.items() if not key.startswith(prefix)},
        }
        for row in rows
    ]
    document = {
        **home.document(instance, sequence, connected=connected, gap=gap),
        "travel": travel,
        "volume": None,
    }
    emit(output, Table(columns, rows, title=instance.title, notes=notes), document=document)


def _free_values(instance: Instance) -> list[str]:
    """Return which values neither a motor nor a range holds, of a machine with motors."""
    free = [
        str(k)
        for k, row in enumerate(instance.constraints, 1)
        if row.limits is None and not driven_points(row)
    ]
    if not free or not is_driven(instance):
        return []
    return [f"values that may change on the way, without a range: {listed(free, 'and')}"]


def _offset_rows(
    instance: Instance,
    home: Home,
    sequence: str,
    offset: dict[str, float],
    *,
    connected: bool,
    knees: ArrayLike | None,
    gap: float | None,
) -> list[dict[str, Any]]:
    """Return a row for each axis that is free, without numbers if the moved pose is refused."""
    from gspcli.errors import ArgumentError
    from gspcli.motion.workspace.travels import moved, travels

    R, T = moved(
        home.R,
        home.T,
        offset,
        pivot=home.pivot,
        sequence=sequence,
        in_radians=instance.units.angle.in_radians,
    )
    # Rods that share a carriage stay parallel when the platform moves, not when it turns.
    known = PARAMETERS[:3] if shares_drives(instance) else PARAMETERS
    axes = [name for name in known if name not in offset]
    try:
        found: list[Travel | None] = list(
            travels(
                instance, R, T, axes=axes, pivot=home.pivot, sequence=sequence,
                connected=connected, knees=knees, gap=gap,
            )
        )  # fmt: skip
    except ArgumentError:
        if not offset:
            raise
        found = [None] * len(axes)
    held = {f"held_{name}": value for name, value in offset.items()}
    return [held | _travel_row(axis, travel) for axis, travel in zip(axes, found, strict=True)]


def _travel_row(axis: str, travel: Travel | None) -> dict[str, Any]:
    row: dict[str, Any] = {"axis": axis}
    if travel is None:
        keys = ("down", "up", "total", "down_end", "up_end", "down_stops", "up_stops")
        return row | dict.fromkeys(keys)
    down, up = (value + 0.0 for value in travel.reached)
    ends = [value if abs(value) < float("inf") else None for value in travel.ends]
    stops = [_grouped(names) for names in travel.stops]
    return row | {
        "down": down, "up": up, "total": up - down, "down_end": ends[0], "up_end": ends[1],
        "down_stops": stops[0], "up_stops": stops[1],
    }  # fmt: skip


def _grouped(names: tuple[str, ...]) -> str:
    """Return limits in words, those of one sort together: range 1 2, range crank B1 B2."""
    found: dict[str, list[str]] = {}
    for name in names:
        sort, _, which = name.partition(" of ")
        if which.startswith(("crank ", "slide ")):
            motor, which = which.split(" ", 1)
            sort = f"{sort} {motor}"
        found.setdefault(sort, []).append(which)
    return ", ".join(" ".join((sort, *which)).strip() for sort, which in found.items())
