"""The table of `gsp scan` over values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.cli.output import Column, Table
from gspcli.cli.pose_options import frame_note
from gspcli.wording import counted

if TYPE_CHECKING:
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance
    from gspcli.motion.singularities.crossings import Meeting
    from gspcli.motion.singularities.scan_results import ScanResult
    from gspcli.motion.singularities.value_scans import Scan


_OWN, _EXPRESSED = ("Tx", "Ty", "Tz"), ("x", "y", "z")
_TURN = ("qw", "qx", "qy", "qz")


def scan_table(result: ScanResult, form: str, frame: PoseFrame) -> Table:
    """Return the table of the nodes, or that of the folds with poses as expressed in a frame."""
    from gspcli.geometry.arrangement import Arrangement

    found, limits, instance = result.found, result.limits, result.found.instance
    rows = result.rows()
    if result.folds:
        position = _OWN if frame.is_identity else _EXPRESSED
        rows = rows if frame.is_identity else _expressed(rows, result, frame)
        columns = [Column("change", align="right", essential=True)]
        # Tables for people show positions, which distinguish mirror images.
        shown = (*position, *_TURN) if form == "csv" else position
        size = Arrangement.of(instance).length
        columns += [Column(key, align="right", minor=1, aligned=True, size=size) for key in shown]
    else:
        columns = [
            Column("modes", align="right", essential=True),
            Column("condition", align="right"),
        ]
        if found.clearances is not None:
            columns.append(Column("clearance", align="right"))
    notes = [_note(found)]
    if limits.curves:
        cusps = sum(len(curve.cusps) for curve in limits.curves)
        curves = counted(len(limits.curves), "curve")
        notes.append(f"discriminant: {curves}, {counted(cusps, 'cusp')}")
    notes += [_meeting(result.names, one, frame) for one in limits.meetings]
    if result.folds:
        notes += frame_note(frame)
    return Table(
        [
            *(Column(name, _heading(instance, name), "right", True) for name in result.names),
            *columns,
        ],
        rows,
        title=instance.title,
        notes=notes,
    )


def _expressed(
    rows: list[dict[str, Any]], result: ScanResult, frame: PoseFrame
) -> list[dict[str, Any]]:
    """Return the rows of folds with their poses as they are expressed."""
    from gspcli.geometry.quaternions import quaternion_from_rotation
    from gspcli.motion.singularities.crossings import in_order

    found = []
    crossings = in_order(result.limits.crossings)
    for row, one in zip(rows, crossings, strict=True):
        R, T = frame.from_platform(one.R, one.T)
        pose = [*T.tolist(), *quaternion_from_rotation(R).tolist()]
        left = {key: value for key, value in row.items() if key not in _OWN}
        found.append(left | dict(zip((*_EXPRESSED, *_TURN), pose, strict=True)))
    return found


def _heading(instance: Instance, name: str) -> str:
    return f"{name} {instance.constraints[int(name) - 1].kind.name}" if name.isdecimal() else name


def _note(found: Scan) -> str:
    numbers, counts = _tally(found)
    parts = [f"{modes} at {count}" for modes, count in zip(numbers, counts, strict=True)]
    return f"{found.modes.size} nodes; modes: {', '.join(parts)}"


def _meeting(names: list[str], one: Meeting, frame: PoseFrame) -> str:
    """Return what is known about modes that meet in no simple fold."""
    ends = (
        ", ".join(f"{name} = {x:.10g}" for name, x in zip(names, end, strict=True))
        for end in (one.low, one.high)
    )
    places = []
    for before, after, R, T in one.poses:
        there = ", ".join(f"{x:.6g}" for x in frame.from_platform(R, T)[1].round(9) + 0.0)
        places.append(f"{before} become {after} at ({there})")
    return (
        f"between {' and '.join(ends)}: {one.before} modes before and {one.after} after, proved; "
        f"several meet in no simple fold: {', '.join(places)}"
    )


def _tally(found: Scan) -> tuple[list[int], list[int]]:
    import numpy as np

    numbers, counts = np.unique(found.modes[found.modes >= 0], return_counts=True)
    return numbers.tolist(), counts.tolist()
