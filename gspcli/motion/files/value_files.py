"""Values of constraints and coordinates of primitives in files: CSV with a heading."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import field

import numpy as np

from gspcli.catalogue.kinds import DLP, DPL, DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement, Array
from gspcli.geometry.checking import value_range, wrong_value
from gspcli.geometry.coordinates import Coordinate, choose, drive_corrections
from gspcli.geometry.coordinates import coordinates as all_coordinates
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.numbers import Number
from gspcli.geometry.readings import readings_of, values_of
from gspcli.motion.files.number_tables import NumberTable
from gspcli.motion.files.pose_files import ROUNDED, PoseFormat, names_poses, poses_in
from gspcli.motion.poses.inverse_kinematics import drive_values, measure, refusals
from gspcli.records import dataclass
from gspcli.wording import shortened

_MOVING = ("crank", "slide")


@dataclass(frozen=True, eq=False)
class ValueTable:
    """Rows of values."""

    #: Increasing, shape (n,): the column t, or the number of the row from 1.
    t: Array
    #: In the units and order of the instance, DPH and DHP signed, shape (n, 6).
    values: Array
    #: Readings of cranks and slides that move, by name, each of shape (n,).
    coordinates: Mapping[str, Array] = field(default_factory=dict)
    #: R (m, 3, 3) and T (m, 3) of a file of m poses, whose values these are; None for a file of
    #: values.
    poses: tuple[Array, Array] | None = None

    @property
    def start(self) -> tuple[Array, Array] | None:
        """The first pose of a file of poses; None for a file of values."""
        if self.poses is None or not len(self.poses[0]):
            return None
        return self.poses[0][0], self.poses[1][0]

    def drives(self, instance: Instance) -> Array:
        """Return the readings of all drives, shape (n, m)."""
        machine = Machine.of(instance)
        return machine.readings(machine.read(self.values, self.coordinates))

    def subdivided(self, steps: int) -> ValueTable:
        """Return the trajectory with each step between rows divided into this many steps."""
        if steps == 1:
            return self
        rows = np.arange(len(self.t))
        parts = np.linspace(0, len(rows) - 1, steps * (len(rows) - 1) + 1)
        columns = [np.interp(parts, rows, column) for column in self.values.T]
        moving = {name: np.interp(parts, rows, column) for name, column in self.coordinates.items()}
        return ValueTable(
            np.interp(parts, rows, self.t), np.stack(columns, axis=1), moving, self.poses
        )


def read_values(
    text: str, name: str, instance: Instance, form: PoseFormat, *, delta: bool = False
) -> ValueTable:
    """Read a trajectory of values; for a file of poses, return the values that they measure.

    The columns ``1`` to ``6`` are the values of the constraints; a constraint without a column
    keeps its value in the instance. Poses of an instance with cranks or slides are those that its
    drives reach, with the rods of the instance. Columns with names such as
    ``crank.B1`` or ``slide.B1`` are drives that move
    (`gspcli.geometry.coordinates`). A file with columns x, y, z has poses (`read_poses`); values
    and readings of cranks and slides beside them must be what the poses measure and ask for.
    Columns that are not known are mistakes.

    Parameters
    ----------
    text, name
        The content, and how messages name it.
    instance
        The geometry, units and values.
    form
        What a pose file does not say.
    delta
        Whether the numbers are added to the values of the instance.

    Raises
    ------
    SpecError
        With all mistakes, each with line and column.
    """
    table = NumberTable(text, name, form.units.of(instance), form.ignore, form.columns)
    moving = _moving(table, instance)
    numbers = [str(k) for k in range(1, len(instance.constraints) + 1)]
    coordinates: dict[str, Array] = {}
    of_file = None
    if names_poses(table):
        if delta:
            table.note_heading("found poses, expected values with --relative")
        poses = poses_in(table, form, (*moving, *numbers))
        t = None if poses is None else poses.t
        values = np.zeros((len(table), len(numbers)))
        if poses is not None and not table.mistakes:
            values, coordinates = _of_poses(instance, poses.R, poses.T, t)
            of_file = poses.R, poses.T
            compare_values(table, instance, values)
            _compare_drives(table, instance, moving, coordinates)
    else:
        note_legs(table, instance)
        found = [name for name in numbers if name in table.heading]
        if not found and not moving:
            table.choose(numbers)
        timed = ["t"] if "t" in table.heading else []
        times, given, places = table.groups(timed, found, moving)
        t = times[:, 0] if timed else None
        base = nominal_values(instance)
        values = np.tile(base, (len(table), 1))
        columns = [int(name) - 1 for name in found]
        values[:, columns] = given + (base[columns] if delta else 0)
        _check_meaning(table, instance, values, columns)
        if delta and len(moving):
            chosen = list(moving.values())
            added, scales = drive_corrections(instance, chosen)
            places -= added / scales
        coordinates = {
            one.name: column for one, column in zip(moving.values(), places.T, strict=True)
        }
        known = {"t", *numbers, *(one.name for one in all_coordinates(instance))}
        expected = "t, 1 ... 6, crank.NAME or slide.NAME"
        table.refuse_others({*known, *filter(_is_judged, table.heading)}, expected)
    if t is None:
        t = np.arange(1.0, len(values) + 1)
    note_times(table, t)
    table.check()
    return ValueTable(t, values, coordinates, of_file)


def note_times(table: NumberTable, t: Array) -> None:
    """Note times that do not increase."""
    for row in np.flatnonzero(np.diff(t) <= 0).tolist():
        message = f"found t = {t[row + 1]:g} after {t[row]:g}: t must increase"
        table.note_cell(row + 1, "t", message)


def compare_values(table: NumberTable, instance: Instance, measured: Array) -> None:
    """Note values beside poses that are not those that the poses measure."""
    names = [str(k) for k in range(1, measured.shape[1] + 1)]
    names = [name for name in names if name in table.heading]
    size = Arrangement.of(instance).length
    for name, column in zip(names, table.numbers(names).T, strict=True):
        k = int(name) - 1
        room = ROUNDED * (size if instance.constraints[k].kind.is_distance else 1.0)
        away = column - measured[:, k]
        _compare(table, name, column, away, room, "measures", measured[:, k])


def _compare_drives(
    table: NumberTable,
    instance: Instance,
    moving: Mapping[str, Coordinate],
    reached: Mapping[str, Array],
) -> None:
    """Note readings of cranks and slides beside poses that they do not reach."""
    size, radian = Arrangement.of(instance).length, instance.units.angle.in_radians
    for name, column in zip(moving, table.numbers(list(moving)).T, strict=True):
        there, turns = reached[moving[name].name], moving[name].vector == "crank"
        away = column - there
        if turns:
            whole = 2 * np.pi / radian
            away -= whole * np.round(away / whole)
        room = ROUNDED * (1 / radian if turns else size)
        _compare(table, name, column, away, room, "asks for", there)


def _compare(
    table: NumberTable, name: str, column: Array, away: Array, room: float, does: str, there: Array
) -> None:
    for row in np.flatnonzero(~(np.abs(away) <= room)).tolist():
        found = f"found {column[row]:.12g} beside a pose that {does} {there[row]:.6g}"
        table.note_cell(row, name, f"{found} (see --ignore)")


def _of_poses(
    instance: Instance, R: Array, T: Array, t: Array | None
) -> tuple[Array, dict[str, Array]]:
    """Return values and the readings of cranks and slides at poses.

    Raises
    ------
    ArgumentError
        If the machine cannot take a pose.
    """
    values = measure(instance, R, T)
    drives, q = drive_values(instance, R, T)
    if missing := refusals(drives, R, T, q):
        row = min(missing)
        where = f"pose {row + 1} of {len(T)}" if t is None else f"the pose at t = {t[row]:.10g}"
        raise ArgumentError(missing[row], where)
    values[:, drives.driven] = nominal_values(instance)[drives.driven]
    readings = drives.readings(q)
    moved = np.flatnonzero(drives.moved).tolist()
    return values, {drives.names[k]: readings[:, k] for k in moved}


def note_legs(table: NumberTable, instance: Instance) -> None:
    """Note columns whose heading says length of a leg, for a constraint that is no leg."""
    for number in table.legs:
        kind = instance.constraints[int(number) - 1].kind
        if kind != DPP:
            message = f"constraint {number} is {kind.name}, not the length of a leg: write {number}"
            table.note_column(table.written[table.heading.index(number)], message)


def _moving(table: NumberTable, instance: Instance) -> dict[str, Coordinate]:
    """Return the coordinates that columns are named after, by the names of the columns."""
    found: dict[str, Coordinate] = {}
    numbers = {str(k) for k in range(1, len(instance.constraints) + 1)}
    for written, name in zip(table.written, table.heading, strict=True):
        if re.fullmatch(r"[0-9]+", name) and name.lstrip("0") not in numbers:
            message = f"found {shortened(written)}, expected a constraint from 1 to 6"
            table.note_column(written, message)
        if not _is_judged(name) or "." not in name:
            continue
        try:
            (found[name],) = choose(instance, [name])
        except ArgumentError as error:
            table.note_column(written, str(error))
    try:
        choose(instance, list(found))
    except ArgumentError as error:
        table.note_heading(str(error))
    return found


def _is_judged(name: str) -> bool:
    """Return whether a column is that of a coordinate or a constraint, rightly or wrongly."""
    head, dot, _ = name.partition(".")
    return name.isdecimal() or bool(dot and head.lower() in _MOVING)


def nominal_values(instance: Instance) -> Array:
    """Return the readings of an instance with the sign of a negative side, shape (6,)."""
    arrangement = Arrangement.of(instance)
    values: Array = np.where(arrangement.sides < 0, -arrangement.values, arrangement.values)
    return readings_of(instance, values)


def _check_meaning(
    table: NumberTable, instance: Instance, values: Array, columns: list[int]
) -> None:
    """Note values outside the range of the kind of their constraint."""
    unit, meant = instance.units.angle, values_of(instance, values)
    for k in columns:
        kind = instance.constraints[k].kind
        if kind.has_sides:
            continue
        low, high = value_range(kind, unit)
        # The others are inside and need no exact number.
        doubtful = np.isfinite(values[:, k]) & ~((meant[:, k] > low) & (meant[:, k] < high))
        for row in np.flatnonzero(doubtful):
            value = float(meant[row, k])
            wrong = wrong_value(kind, Number.of(value), unit)
            if value == 0 and kind in (DPP, DPL, DLP):
                wrong = f"expected more: {kind.name} with value 0 is more than one equation"
            if wrong:
                message = f"found {values[row, k]:.12g} for constraint {k + 1}, {wrong}"
                table.note_cell(int(row), str(k + 1), message)
