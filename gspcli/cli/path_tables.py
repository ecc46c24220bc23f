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
    from gspcli.motion.paths.timing import Timing

_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def path_table(found: PlannedPath, frame: PoseFrame) -> Table:
    """Return the rows of a path, with what is proved of its parts above them."""
    from gspcli.geometry.arrangement import Arrangement

    columns = [
        Column("t", align="right", essential=True),
        *(
            Column(name, _titled(found, name), align="right", minor=1, size=_size(found, name))
            for name in found.motors
        ),
        *pose_columns(_POSE, Arrangement.of(found.instance).length),
        Column("condition", align="right"),
    ]
    if found.drives is None:
        columns.append(Column("clearance", align="right", minor=2))
    if found.gaps is not None:
        columns.append(Column("gap", align="right", minor=2))
    return Table(
        columns,
        found.rows(frame),
        title=found.instance.title,
        notes=frame_note(frame),
        summary=_summary(found),
    )


def _size(found: PlannedPath, motor: str) -> float:
    """Return a typical number of a motor."""
    from gspcli.geometry.arrangement import Arrangement

    if _unit(found, motor) == found.instance.units.angle.value:
        return 1 / found.instance.units.angle.in_radians
    return float(Arrangement.of(found.instance).length)


def _titled(found: PlannedPath, name: str) -> str:
    """Return the title of a column of a motor."""
    if not name.isdecimal():
        return name.replace(".", " ")
    return f"{name} {found.instance.constraints[int(name) - 1].kind.name}"


def _summary(found: PlannedPath) -> list[str]:
    """Return in words what is proved."""
    if not found.parts:
        return []
    from gspcli.ties import first_largest

    worst = found.parts[int(first_largest([part.condition for part in found.parts]))]
    unit = found.instance.units.length
    length = f"length {found.length:.4g} {unit}"
    if found.straight_length:
        length += f", {found.length / found.straight_length:.2f} times the straight line"
    ways = f"the {found.along} change" if found.along != "poses" else "position and angles change"
    lines = [
        f"from {found.start} to {found.goal}: proved, "
        f"{counted(found.straight, 'straight part')} ({ways} linearly)",
        length,
        f"largest condition number at a row: {worst.condition:.4g}, from row {worst.first + 1} to "
        f"{worst.last + 1}",
    ]
    if found.timing is not None:
        lines.append(_time(found, found.timing))
    clearance = min(part.clearance for part in found.parts)
    if clearance > 0:
        lines.append(f"clearance on the whole way: at least {clearance:.3g}, proved")
    gaps = [part.gap for part in found.parts if part.gap is not None]
    if gaps:
        lines.append(f"gap on the whole way: at least {min(gaps):.4g} {unit}, proved")
    return lines


def _unit(found: PlannedPath, motor: str) -> str:
    """Return the unit of what a motor moves."""
    if motor.isdecimal():
        is_length = found.instance.constraints[int(motor) - 1].kind.is_distance
    else:
        is_length = motor.startswith("slide")
    units = found.instance.units
    return str(units.length) if is_length else units.angle.value


def _time(found: PlannedPath, timing: Timing) -> str:
    """Return the time of a path, and which speeds and accelerations are below which limits."""
    units = found.instance.units
    angle, length = units.angle.value, str(units.length)
    lengths = {_unit(found, name) for name in found.motors}
    of = {"motors": " or ".join(sorted(lengths, key=length.__ne__)), "platform": length}
    of["turn"] = angle
    names = {"motors": "each motor", "platform": "the platform", "turn": "its turn"}
    limits = []
    for name in names:
        numbers = [
            f"{given[name]:.10g} {of[name]}/{second}"
            for given, second in ((timing.limits.speed, "s"), (timing.limits.acceleration, "s^2"))
            if name in given
        ]
        if numbers:
            limits.append(f"{names[name]} at most {listed(numbers, 'and')}")
    text = f"{timing.seconds:.4g} s: {', '.join(limits)}"
    stops = timing.corners - timing.rounded
    if timing.rounded:
        text += f"; {counted(timing.rounded, 'corner')} rounded"
    if stops:
        text += f"; stops at {counted(stops, 'corner')}"
    return text


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
    notes = [f"signs are those of {listed(found.names, 'and')}: a regular path keeps them"]
    if any("?" in str(row["signs"]) for row in rows):
        notes.append("?: the sign is not proved")
    return Table(columns, rows, title=found.instance.title, summary=[text], notes=notes)


def _status(row: dict[str, object]) -> str:
    if row["left"]:
        return "outside the limits"
    if row["alone"]:
        return "alone, proved: it fills its box of ranges"
    return "proved apart from other groups" if row["apart"] else "may join another group"
