"""The tables of `gsp path`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.cli.output import Column, Table
from gspcli.cli.output.tables import pose_columns
from gspcli.cli.pose_options import frame_note
from gspcli.wording import counted, listed

if TYPE_CHECKING:
    from gspcli.geometry.frames import PoseFrame
    from gspcli.motion.paths.mode_groups import ModeGroups
    from gspcli.motion.paths.planned_paths import PlannedPath

_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def path_table(found: PlannedPath, frame: PoseFrame) -> Table:
    """Return the rows of a path, with what is proved of its parts above them."""
    from gspcli.geometry.arrangement import Arrangement

    columns = [
        Column("t", align="right", essential=True),
        *(
            Column(str(k), f"{k} {row.kind.name}", align="right", minor=1)
            for k, row in enumerate(found.instance.constraints, 1)
        ),
        *pose_columns(_POSE, Arrangement.of(found.instance).length),
        Column("condition", align="right"),
        Column("clearance", align="right", minor=2),
    ]
    return Table(
        columns,
        found.rows(frame),
        title=found.instance.title,
        notes=frame_note(frame),
        summary=_summary(found),
    )


def _summary(found: PlannedPath) -> list[str]:
    """Return in words what is proved."""
    if not found.parts:
        return []
    from gspcli.ties import first_largest

    worst = found.parts[int(first_largest([part.condition for part in found.parts]))]
    unit = found.instance.units.length
    straight = f", {found.length / found.straight_length:.2f} times the straight line"
    ways = "the values change" if found.along == "values" else "position and angles change"
    lines = [
        f"from {found.start} to {found.goal}: proved, "
        f"{counted(len(found.parts), 'straight part')} ({ways} linearly)",
        f"length {found.length:.4g} {unit}" + (straight if found.straight_length else ""),
        f"largest condition number at a row: {worst.condition:.4g}, from row {worst.first + 1} to "
        f"{worst.last + 1}",
    ]
    clearance = min(part.clearance for part in found.parts)
    if clearance > 0:
        lines.append(f"clearance on the whole way: at least {clearance:.3g}, proved")
    return lines


def groups_table(found: ModeGroups) -> Table:
    """Return which modes belong together."""
    columns = [
        Column("mode", align="right", essential=True),
        Column("signs", essential=True),
        Column("group", align="right", essential=True),
        Column("others", "joined with", fold=", ", essential=True),
        Column("status", essential=True),
    ]
    rows = [
        {**row, "others": row["others"] or None, "status": _status(row)} for row in found.rows()
    ]
    groups = counted(len(found.groups), "group")
    if found.complete:
        text = f"{groups}: modes of one group are joined by proved paths, all others proved apart"
    else:
        pairs = listed([f"{a} and {b}" for a, b in found.undecided], "or")
        text = f"{groups}; groups {pairs} may belong together: no path was found"
    note = f"signs are those of {listed(found.names, 'and')}: a regular path keeps them"
    return Table(columns, rows, title=found.instance.title, summary=[text], notes=[note])


def _status(row: dict[str, object]) -> str:
    if row["left"]:
        return "outside the limits"
    if row["alone"]:
        return "alone, proved: it fills its box of ranges"
    return "proved apart from other groups" if row["apart"] else "may join another group"
