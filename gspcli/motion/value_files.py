"""Values of constraints in files: CSV with a heading of constraint numbers, and perhaps t."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLP, DPL, DPP
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.ranges import wrong_value
from gspcli.motion.measuring import measure
from gspcli.motion.number_tables import NumberTable
from gspcli.motion.pose_files import PoseFormat, read_poses

Array = NDArray[np.float64]

_POSITIONS = ({"x", "y", "z"}, {"tx", "ty", "tz"})


@dataclass(frozen=True, eq=False)
class ValueTable:
    """Rows of values.

    Attributes
    ----------
    t
        Increasing, shape (n,): the column t, or the number of the row from 1.
    values
        In the units and order of the instance, DPH and DHP signed, shape (n, 6).
    """

    t: Array
    values: Array

    def subdivided(self, steps: int) -> ValueTable:
        """Return the same trajectory with so many rows for each step between rows."""
        if steps == 1:
            return self
        rows = np.arange(len(self.t))
        parts = np.linspace(0, len(rows) - 1, steps * (len(rows) - 1) + 1)
        columns = [np.interp(parts, rows, column) for column in self.values.T]
        return ValueTable(np.interp(parts, rows, self.t), np.stack(columns, axis=1))


def read_values(
    text: str, name: str, instance: Instance, form: PoseFormat, *, delta: bool = False
) -> ValueTable:
    """Read a trajectory of values, or of poses, which are measured.

    The columns ``1`` to ``6`` are the values of the constraints; a constraint without a column
    keeps that of the instance. A file with columns x, y, z is one of poses (`read_poses`).

    Parameters
    ----------
    text, name
        The content, and how messages name it.
    instance
        The geometry, units and values.
    form
        What a pose file does not say.
    delta
        Whether the numbers are to be added to the values of the instance.

    Raises
    ------
    SpecError
        With all mistakes, each with line and column.
    """
    table = NumberTable(text, name)
    if any(names <= set(table.heading) for names in _POSITIONS):
        poses = read_poses(text, name, form)
        values, t = measure(instance, poses.R, poses.T), poses.t
        if delta:
            table.note_heading("found poses, expected values with --delta")
    else:
        count = len(instance.constraints)
        numbers = [str(k) for k in range(1, count + 1)]
        found = [name for name in numbers if name in table.heading]
        if not found:
            table.choose(numbers)
        t = table.numbers(["t"])[:, 0] if "t" in table.heading else None
        given = table.numbers(found)
        base = stated_values(instance)
        values = np.tile(base, (len(table), 1))
        columns = [int(name) - 1 for name in found]
        values[:, columns] = given + (base[columns] if delta else 0)
        _check_meaning(table, instance, values, columns)
    if t is None:
        t = np.arange(1.0, len(values) + 1)
    for row in np.flatnonzero(np.diff(t) <= 0):
        table.note_row(int(row) + 1, f"found t = {t[row + 1]:g} after {t[row]:g}: t must increase")
    table.check()
    return ValueTable(t, values)


def stated_values(instance: Instance) -> Array:
    """Return the values of an instance with the sign of a negative side, shape (6,)."""
    arrangement = Arrangement.of(instance)
    values: Array = np.where(arrangement.sides < 0, -arrangement.values, arrangement.values)
    return values


def _check_meaning(
    table: NumberTable, instance: Instance, values: Array, columns: list[int]
) -> None:
    """Note values that the kinds of their constraints cannot have."""
    unit = instance.units.angle
    for k in columns:
        kind = instance.constraints[k].kind
        if kind.has_sides:
            continue
        for row in np.flatnonzero(np.isfinite(values[:, k])):
            value = float(values[row, k])
            wrong = wrong_value(kind, Number.of(value), unit)
            if value == 0 and kind in (DPP, DPL, DLP):
                wrong = f"expected more: {kind.name} with value 0 is more than one equation"
            if wrong:
                table.note_row(int(row), f"found {value:.12g} for constraint {k + 1}, {wrong}")
