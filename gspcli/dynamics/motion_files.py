"""Rows of poses or values with times in files, perhaps with velocities and accelerations."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gspcli.dynamics.actuation import Actuation
from gspcli.dynamics.mass_model import MassModel
from gspcli.dynamics.trajectories import ACCELERATION, VELOCITY, PoseRates, motion_of_platform
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.readings import factors
from gspcli.motion import PoseFormat, read_poses, read_values
from gspcli.motion.files.number_tables import NumberTable
from gspcli.motion.files.pose_files import measured_columns, names_poses, poses_in
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Columns of values: their rates, and the derivatives of these.
RATES = tuple(f"v{k}" for k in range(1, 7))
SECOND_RATES = tuple(f"a{k}" for k in range(1, 7))


@dataclass(frozen=True, eq=False)
class PoseRows:
    """Rows of poses: times or None, poses, and how the platform moves there if that is given."""

    t: Array | None
    R: Array
    T: Array
    motion: PoseRates | None


@dataclass(frozen=True, eq=False)
class ValueRows:
    """Rows of values, shape (n, 6), in the units of the instance.

    Attributes
    ----------
    t
        Times, shape (n,), or None.
    values
        DPH and DHP signed.
    rates, second_rates
        Their derivatives by time, shape (n, 6), or None.
    coordinates
        The numbers of cranks and slides by their names, each of shape (n,).
    """

    t: Array | None
    values: Array
    rates: Array | None
    second_rates: Array | None
    coordinates: Mapping[str, Array]

    def drives(self, instance: Instance) -> Array:
        """Return the readings of all drives, shape (n, m)."""
        machine = Machine.of(instance)
        return machine.readings(machine.read(self.values, self.coordinates))


def read_rows(text: str, name: str, instance: Instance, form: PoseFormat) -> PoseRows | ValueRows:
    """Read rows of poses (`gspcli.motion.read_poses`) or of values (`gspcli.motion.read_values`).

    Poses may have the columns VELOCITY and ACCELERATION, values RATES and SECOND_RATES: both or
    none, per second, angles in the unit of the instance.

    Raises
    ------
    SpecError
        With all mistakes, each with line and column.
    """
    if text.lstrip()[:1] in ("{", "["):
        found = read_poses(text, name, form)
        return PoseRows(None, found.R, found.T, None)
    table = NumberTable(text, name, form.units.of(instance), form.ignore, form.columns)
    if names_poses(table):
        return _pose_rows(table, instance, form)
    values = read_values(text, name, instance, form)
    drives = Machine.of(instance)
    names = [name for name, moved in zip(drives.names, drives.moved, strict=True) if moved]
    other = [name for name in values.coordinates if name not in names]
    if other:
        expected = "only values and drives" if names else "only values"
        table.note_heading(f"found {other[0]}, a coordinate that moves, expected {expected}")
    rates, second = _both(table, RATES, SECOND_RATES)
    if rates is not None and names:
        message = "found v1 ... a6, rates of rods, expected a column t: splines through the rows"
        table.note_heading(message)
    table.check()
    times = values.t if "t" in table.heading else None
    return ValueRows(times, values.values, rates, second, values.coordinates)


def _both(
    table: NumberTable, velocity: tuple[str, ...], acceleration: tuple[str, ...]
) -> tuple[Array, Array] | tuple[None, None]:
    """Return velocities and accelerations, (n, 6), if the heading has both of them."""
    if not {*velocity, *acceleration} & set(table.heading):
        return None, None
    missing = [name for name in (*velocity, *acceleration) if name not in table.heading]
    if missing:
        table.note_heading(
            f"found velocities or accelerations without {' '.join(missing)}, expected all of "
            f"{' '.join(velocity)} {' '.join(acceleration)}, or none"
        )
        return None, None
    return table.numbers(velocity), table.numbers(acceleration)


def _pose_rows(table: NumberTable, instance: Instance, form: PoseFormat) -> PoseRows:
    poses = poses_in(table, form, measured_columns(table))
    velocity, acceleration = _both(table, VELOCITY, ACCELERATION)
    if poses is not None and poses.t is not None:
        for row in np.flatnonzero(np.diff(poses.t) <= 0):
            message = f"found t = {poses.t[row + 1]:g} after {poses.t[row]:g}: t must increase"
            table.note_cell(int(row) + 1, "t", message)
    table.check()
    assert poses is not None
    motion = None
    if velocity is not None and acceleration is not None:
        angles = np.repeat([instance.units.angle.in_radians, 1.0], 3)
        at_pivot = PoseRates(velocity * angles, acceleration * angles)
        motion = motion_of_platform(form.pivot_frame, poses.R, at_pivot)
    return PoseRows(poses.t, poses.R, poses.T, motion)


def motion_of_values(
    instance: Instance, R: Array, T: Array, rates: Array, second_rates: Array
) -> PoseRates:
    """Return how a platform moves at poses, (n, 3, 3) and (n, 3), where its readings move so.

    At singular poses, where that is not known, it is at rest.
    """
    model = MassModel.of(instance)
    T = T * model.metre
    acting = Actuation(model, R, T, model.machine.inverse(R, T))
    distances = np.array([row.kind.is_distance for row in instance.constraints])
    unit = np.where(distances, model.metre, instance.units.angle.in_radians) * factors(instance)
    singular, _ = acting.conditions()
    rows = np.where(singular[:, None, None], np.eye(6), acting.at.jacobian)

    def solved(right: Array) -> Array:
        return np.where(singular[:, None], 0.0, np.linalg.solve(rows, right[..., None])[..., 0])

    twists = solved(rates * unit)
    accelerations = solved(second_rates * unit - acting.at.rates(twists, np.zeros(6))[1])
    lengths = np.repeat([1.0, model.metre], 3)
    return PoseRates(twists / lengths, accelerations / lengths)
