"""What `gsp dynamics` says, as tables for people and programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gspcli.cli.output import Column, Table
from gspcli.cli.output.tables import pose_columns
from gspcli.cli.pose_options import frame_note
from gspcli.dynamics.arrays import plain
from gspcli.dynamics.drive_forces import FORCES
from gspcli.dynamics.forward import POSE
from gspcli.dynamics.trajectories import ACCELERATION, VELOCITY
from gspcli.dynamics.vibrations import FREQUENCIES
from gspcli.geometry.arrangement import Arrangement

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from gspcli.cli.dynamics_rows import AskedMotion
    from gspcli.dynamics import DriveForces, NaturalModes, SimulatedMotion
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance

    Array = NDArray[np.float64]

_TWIST = ("rx", "ry", "rz", "x", "y", "z")
_ENERGIES = ("kinetic", "potential", "work")


def force_rows(found: DriveForces, asked: AskedMotion) -> list[dict[str, Any]]:
    """Return a row for each pose; cells are empty where no forces are known."""
    keys = (asked.first_column, *FORCES, "power")
    parts = zip(asked.labels, plain(found.forces), plain(found.power), strict=True)
    rows = [dict(zip(keys, (label, *forces, power), strict=True)) for label, forces, power in parts]
    torques = {name: plain(column) for name, column in found.torque_columns.items()}
    return [row | {name: torques[name][k] for name in torques} for k, row in enumerate(rows)]


def force_table(
    found: DriveForces,
    asked: AskedMotion,
    rows: list[dict[str, Any]],
    more: list[Column],
    lines: list[str],
) -> Table:
    """Return the forces of each row, and the worst of them in a note."""
    instance = found.instance
    kinds = [row.kind.name for row in instance.constraints]
    columns = [Column(asked.first_column, align="right", essential=True)]
    torques = found.torque_columns
    columns += [
        Column(key, f"{key.removeprefix('torque.')} [{unit}]", "right", True, aligned=True)
        for key, unit in zip(torques, found.torque_units, strict=False)
    ]
    columns += [
        Column(key, f"{key} {kind} [{unit}]", "right", not torques, aligned=True, size=size)
        for key, kind, unit, size in zip(
            FORCES, kinds, found.units, _sizes(found.forces, found.units), strict=True
        )
    ]
    columns.append(Column("power", "power [W]", "right", size=_size(found.powers)))
    notes = [f"{asked.how}; positive: the drive pushes towards a greater value"]
    if torques:
        notes.append("F1 ... F6 act along the rods; before them: what the drives do")
    most = found.worst_torque
    if most is not None and found.drives is not None:
        unit, name = found.torque_units[most.drive], found.drives.names[most.drive]
        notes.append(f"worst: {most.force:.6g} {unit} by {name} {asked.place(most.row)}")
    worst = None if torques else found.worst
    if worst is not None:
        unit = found.units[worst.drive]
        notes.append(
            f"worst: {worst.force:.6g} {unit} by drive {worst.drive + 1} {asked.place(worst.row)}"
        )
    return Table(columns + more, rows, title=instance.title, notes=notes, summary=lines)


def mode_rows(found: NaturalModes, asked: AskedMotion) -> list[dict[str, Any]]:
    """Return a row of frequencies for each pose."""
    keys = (asked.first_column, *FREQUENCIES)
    parts = zip(asked.labels, plain(found.frequencies), strict=True)
    return [dict(zip(keys, (label, *numbers), strict=False)) for label, numbers in parts]


def mode_tables(
    found: NaturalModes,
    asked: AskedMotion,
    rows: list[dict[str, Any]],
    more: list[Column],
    lines: list[str],
) -> list[Table]:
    """Return the frequencies of each row, or of one pose the modes with their shapes."""
    instance = found.instance
    notes = ["natural frequencies in Hz" + _unstable(found)]
    if len(found.T) > 1 or found.singular.any():
        columns = [Column(asked.first_column, align="right", essential=True)]
        columns += [
            Column(key, f"{key} [Hz]", align="right", essential=True, aligned=True)
            for key in FREQUENCIES[: found.squares.shape[1]]
        ]
        return [Table(columns + more, rows, title=instance.title, notes=notes, summary=lines)]
    shapes = [
        {"mode": k + 1, "frequency": frequency, **dict(zip(_TWIST, shape, strict=True))}
        for k, (frequency, shape) in enumerate(
            zip(found.frequencies[0].tolist(), found.shapes[0].tolist(), strict=True)
        )
    ]
    columns = [
        Column("mode", align="right", essential=True),
        Column("frequency", "f [Hz]", align="right", essential=True, aligned=True),
        *(Column(key, _heading(key, instance), "right", aligned=True) for key in _TWIST),
    ]
    notes.append(
        "shapes: turns about the axes of the base, and the way of the platform's origin; the "
        "largest is one radian or the typical length"
    )
    return [Table(columns, shapes, title=instance.title, notes=notes, summary=lines)]


def _unstable(found: NaturalModes) -> str:
    low = found.squares[~found.singular]
    return "; negative: the pose is not stable that way" if (low < 0).any() else ""


def _heading(key: str, instance: Instance) -> str:
    return f"{key} [{'rad' if key.startswith('r') else instance.units.length}]"


def motion_table(found: SimulatedMotion, frame: PoseFrame) -> Table:
    """Return a row for each time, whose columns `gsp dynamics` reads, as expressed in a frame."""
    instance = found.instance
    columns = [Column("t", align="right", essential=True)]
    numbers = found.expressed(frame)
    columns += pose_columns(POSE, Arrangement.of(instance).length)
    for keys, minor in ((VELOCITY, 1), (ACCELERATION, 3)):
        for three in (keys[:3], keys[3:]):
            size = max(_size(numbers[key]) for key in three)
            columns += [Column(key, align="right", minor=minor, size=size) for key in three]
    size = max(_size(numbers[key]) for key in _ENERGIES)
    columns += [Column(key, f"{key} [J]", "right", minor=2, size=size) for key in _ENERGIES]
    table = {key: column.tolist() for key, column in numbers.items()}
    rows = [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]
    units = instance.units
    moving = "the platform's origin" if frame.is_identity else "the point x y z"
    notes = [
        f"lengths in {units.length}, angles in {units.angle.value}, seconds; w v: angular velocity "
        f"and velocity of {moving}; alpha a: their derivatives",
        f"the work of the drives is off the change of energies by {found.shown_error:.0e} of it",
    ]
    return Table(columns, rows, title=instance.title, notes=[*notes, *frame_note(frame)])


def _size(numbers: Array) -> float:
    """Return the largest modulus of numbers that are known, or zero."""
    return float(np.nan_to_num(np.abs(numbers)).max(initial=0.0))


def _sizes(numbers: Array, units: Sequence[str]) -> list[float]:
    """Return for each column, shape (n, k), the largest modulus of those of the same unit."""
    return [_size(numbers[:, [unit == other for other in units]]) for unit in units]
