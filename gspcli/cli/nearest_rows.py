"""Rows of the nearest poses within the limits: `gsp measure --nearest`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.cli.drive_rows import times_of
from gspcli.cli.output import Column, Output, Table, emit
from gspcli.cli.pose_options import frame_note
from gspcli.cli.real_poses import one_mode
from gspcli.errors import IncompleteError
from gspcli.wording import counted

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseFormat, PoseTable
    from gspcli.motion.paths.nearest_poses import NearestPose

_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def emit_nearest(instance: Instance, table: PoseTable, form: PoseFormat, output: Output) -> None:
    """Write the nearest pose to each pose of a table, from home and then from row to row.

    Raises
    ------
    IncompleteError
        If no way to some row is proved; the platform stays at the row before.
    """
    from gspcli.motion.paths.nearest_poses import NearestPoses

    _, R, T = one_mode(instance, None)
    nearest = NearestPoses(instance, R[0], T[0], pivot=_pivot(form))
    found = list(nearest.along(table.R, table.T))
    times = times_of(table)
    columns = _columns(instance)
    rows = [_row(t, one, form, list(columns)) for t, one in zip(times, found, strict=True)]
    document = {"schema": "gsp.measure/1", **instance.to_json(), "poses": rows}
    emit(output, _table(instance, rows, form, columns), document=document)
    stays = [t for t, one in zip(times, found, strict=True) if not one.way]
    if stays:
        message = f"no way is proved to {counted(len(stays), 'row')}, first t = {stays[0]:.10g}"
        raise IncompleteError(f"{message}: the platform stays where it is")


def _pivot(form: PoseFormat) -> list[float] | None:
    """Return the point whose position the table gives, in the platform's frame; None: origin."""
    tool = form.frame.tool.shifted(form.pivot)
    return None if tool.T is None else tool.T.tolist()


def _columns(instance: Instance) -> dict[str, str]:
    """Return the keys and headings of what the motors are at."""
    from gspcli.geometry.drive_numbers import is_driven

    if is_driven(instance):
        from gspcli.geometry.drives import Drives

        return {name: name for name in Drives.of(instance).names}
    return {str(k): f"{k} {row.kind.name}" for k, row in enumerate(instance.constraints, 1)}


def _row(t: float, one: NearestPose, form: PoseFormat, names: list[str]) -> dict[str, Any]:
    from gspcli.geometry.quaternions import quaternion_from_rotation

    R, T = form.frame.from_platform(one.R, one.T)
    numbers = (*T.tolist(), *quaternion_from_rotation(R).tolist())
    return {
        "t": t,
        **dict(zip(names, one.values.tolist(), strict=True)),
        **dict(zip(_POSE, numbers, strict=True)),
        "shift": one.shift,
        "turn": one.turn,
        "limits": list(one.limits),
        "way": one.way or None,
    }


def _table(
    instance: Instance, rows: list[dict[str, Any]], form: PoseFormat, names: dict[str, str]
) -> Table:
    units = instance.units
    columns = [
        Column("t", align="right", essential=True),
        *(
            Column(key, heading, align="right", minor=1, aligned=True)
            for key, heading in names.items()
        ),
        *(Column(key, align="right", essential=True, aligned=True) for key in _POSE),
        Column("shift", f"shift [{units.length}]", align="right"),
        Column("turn", f"turn [{units.angle.value}]", align="right"),
        Column("limits", fold=", ", minor=-1),
        Column("way", minor=2),
    ]
    moved = sum(bool(row["limits"]) for row in rows)
    summary = f"{counted(moved, 'pose')} of {len(rows)} moved to the nearest one within the limits"
    notes = [
        "way: values, drives or poses change linearly from the row before, proved",
        *frame_note(form.frame),
    ]
    rows = [{**row, "limits": ", ".join(row["limits"])} for row in rows]
    return Table(columns, rows, title=instance.title, notes=notes, summary=[summary])
