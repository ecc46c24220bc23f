"""Rows of the drives at poses: `gsp measure --drives` and `--cranks`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from gspcli.cli.gap_columns import add_gaps
from gspcli.cli.output import Column, Output, Table, emit
from gspcli.cli.requirements import judged, refuse, verdict_entries, verdict_lines
from gspcli.errors import GspError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.drives import Drives
    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseTable
    from gspcli.motion.files.requirements import Requirement

    Array = NDArray[np.float64]


#: A message names at most this many poses that are out of reach.
_TOLD = 3


def times_of(table: PoseTable) -> list[float]:
    """Return t of the poses, which are counted from 1 if the file has none."""
    times: list[float] = list(range(1, len(table.R) + 1)) if table.t is None else table.t.tolist()
    return times


def emit_cranks(instance: Instance, table: PoseTable, output: Output) -> None:
    """Write the angles of the cranks at poses.

    Raises
    ------
    GspError
        If a pose is out of reach.
    """
    from gspcli.motion import crank_angles, drive_values

    cranks, _ = crank_angles(instance, table.R, table.T)
    drives, q = drive_values(instance, table.R, table.T)
    _refuse_unreached(drives, q, table)
    names = [one.name for one in cranks]
    angles = drives.readings(q)[:, [drives.names.index(name) for name in names]].tolist()
    times = times_of(table)
    document = {
        "schema": "gsp.measure/1",
        **instance.to_json(),
        "cranks": names,
        "poses": [{"t": t, "angles": row} for t, row in zip(times, angles, strict=True)],
    }
    rows = _rows(times, names, angles)
    note = f"angles in {instance.units.angle.value}, from where the points are stated"
    emit(output, _table(instance, rows, names, [], [note], []), document=document)


def emit_drives(
    instance: Instance, table: PoseTable, requirements: Sequence[Requirement], output: Output
) -> None:
    """Write the numbers of all drives at poses, and their transmissions.

    Raises
    ------
    GspError
        If a pose is out of reach.
    CheckFailed
        If a requirement is not met.
    """
    from gspcli.motion import drive_values

    drives, q = drive_values(instance, table.R, table.T)
    _refuse_unreached(drives, q, table)
    readings, times = drives.readings(q).tolist(), times_of(table)
    rows = _rows(times, drives.names, readings)
    shown = []
    if drives.driven.any():
        share = drives.transmission(drives.gains(table.R, table.T, q))[:, drives.driven]
        for row, least in zip(rows, share.min(axis=1).tolist(), strict=True):
            row["transmission"] = least
        shown = [Column("transmission", align="right", essential=True)]
    gaps, known = add_gaps(instance, table.R, table.T, rows)
    verdicts, more = judged(instance, requirements, table.R, table.T, rows, known)
    more = [*gaps, *more]
    more = [column for column in more if column.key != "transmission"]
    document = None
    if output.format == "json":
        document = {
            "schema": "gsp.measure/1",
            **instance.to_json(),
            "drives": list(drives.names),
            "poses": [
                {
                    "t": t,
                    "numbers": numbers,
                    **{k: row[k] for k in row if k not in ("t", *drives.names)},
                }
                for t, numbers, row in zip(times, readings, rows, strict=True)
            ],
        }
        if verdicts:
            document["requirements"] = verdict_entries(
                verdicts, lambda k: {"row": k + 1, "t": times[k]}
            )
    units = instance.units
    notes = [f"lengths in {units.length}, angles in {units.angle.value}; cranks and slides from "]
    notes[0] += "where their points are stated"
    if shown:
        notes.append(
            "transmission: the least part of a motor's motion along its rod, 0 at a dead point"
        )
    lines = verdict_lines(verdicts, lambda k: f"in row {k + 1} (t = {times[k]:.6g})")
    made = _table(instance, rows, list(drives.names), [*shown, *more], notes, lines)
    emit(output, made, document=document)
    refuse(verdicts)


def _refuse_unreached(drives: Drives, q: Array, table: PoseTable) -> None:
    """Raise if a rod does not reach a pose, or the rods of a carriage ask for two places."""
    import numpy as np

    missing = np.argwhere(np.isnan(q)).tolist()
    if not missing:
        return
    times = times_of(table)
    wanted = drives.wanted(table.R, table.T)
    lines = []
    for row, k in missing:
        users, name = drives.users(k), drives.names[k]
        numbers = wanted[row, users] / drives.units[k]
        where = f"the pose at t = {times[row]:.10g}"
        if np.isnan(numbers).any():
            rod = "leg" if len(users) == 1 else f"rod {users[int(np.isnan(numbers).argmax())] + 1}"
            lines.append(f"the {rod} of {name} does not reach {where}")
        else:
            rods = " and ".join(str(one + 1) for one in users)
            asked = " and ".join(f"{x:.6g}" for x in numbers)
            lines.append(f"rods {rods} ask for {asked} of {name} at {where}")
    more = [f"and at {len(lines) - _TOLD} more places"] if len(lines) > _TOLD + 1 else []
    raise GspError("\n".join(lines[:_TOLD] + more if more else lines))


def _rows(
    times: Sequence[float], names: Sequence[str], numbers: Sequence[Sequence[float]]
) -> list[dict[str, Any]]:
    return [
        {"t": t, **dict(zip(names, row, strict=True))}
        for t, row in zip(times, numbers, strict=True)
    ]


def _table(
    instance: Instance,
    rows: list[dict[str, Any]],
    names: Sequence[str],
    more: Sequence[Column],
    notes: list[str],
    summary: list[str],
) -> Table:
    columns = [
        Column(key, align="right", essential=True, aligned=key != "t") for key in ("t", *names)
    ]
    title = ": ".join(part for part in (instance.name, instance.type.id) if part)
    return Table([*columns, *more], rows, title=title, notes=notes, summary=summary)
