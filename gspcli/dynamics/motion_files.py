"""Rows of poses or values with times in files, perhaps with velocities and accelerations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gspcli.dynamics.actuation import Actuation
from gspcli.dynamics.mass_model import MassModel
from gspcli.dynamics.trajectories import ACCELERATION, VELOCITY, PoseRates, motion_of_platform
from gspcli.geometry.instance import Array, Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.readings import factors
from gspcli.motion import PoseFormat, PoseTable, ValueTable, read_poses, read_values
from gspcli.motion.files.number_tables import NumberTable
from gspcli.motion.files.pose_files import measured_columns, names_poses, poses_in
from gspcli.motion.files.value_files import note_times

#: Columns of values: their rates, and the derivatives of these.
RATES = tuple(f"v{k}" for k in range(1, 7))
SECOND_RATES = tuple(f"a{k}" for k in range(1, 7))


class TimedRows(NamedTuple):
    """Rows of poses or values, and how they move."""

    t: Array | None
    """The column t, shape (n,); None without one."""
    table: PoseTable | ValueTable
    rates: tuple[Array, Array] | None
    """`PoseRates` of poses; of values their first and second derivatives; None if not given."""


def read_rows(text: str, name: str, instance: Instance, form: PoseFormat) -> TimedRows:
    """Read rows of poses (`gspcli.motion.read_poses`) or of values (`gspcli.motion.read_values`).

    Poses may have the columns VELOCITY and ACCELERATION, values RATES and SECOND_RATES: both or
    none, per second, angles in the unit of the instance.

    Raises
    ------
    SpecError
        With all mistakes, each with line and column.
    """
    if text.lstrip()[:1] in ("{", "["):
        return TimedRows(None, read_poses(text, name, form), None)
    table = NumberTable(text, name, form.units.of(instance), form.ignore, form.columns)
    if names_poses(table):
        return _pose_rows(table, instance, form)
    values = read_values(text, name, instance, form)
    rates = _both(table, RATES, SECOND_RATES)
    if rates is not None and Machine.of(instance).moves:
        message = "found v1 ... a6, rates of rods, expected a column t: splines through the rows"
        table.note_heading(message)
    table.check()
    return TimedRows(values.t if "t" in table.heading else None, values, rates)


def _both(
    table: NumberTable, velocity: tuple[str, ...], acceleration: tuple[str, ...]
) -> tuple[Array, Array] | None:
    """Return velocities and accelerations, (n, 6), if the heading has both of them."""
    if not {*velocity, *acceleration} & set(table.heading):
        return None
    missing = [name for name in (*velocity, *acceleration) if name not in table.heading]
    if missing:
        table.note_heading(
            f"found velocities or accelerations without {' '.join(missing)}, expected all of "
            f"{' '.join(velocity)} {' '.join(acceleration)}, or none"
        )
        return None
    return table.numbers(velocity), table.numbers(acceleration)


def _pose_rows(table: NumberTable, instance: Instance, form: PoseFormat) -> TimedRows:
    poses = poses_in(table, form, measured_columns(table))
    rates = _both(table, VELOCITY, ACCELERATION)
    if poses is not None and poses.t is not None:
        note_times(table, poses.t)
    table.check()
    assert poses is not None
    if rates is not None:
        angles = np.repeat([instance.units.angle.in_radians, 1.0], 3)
        at_pivot = PoseRates(*(part * angles for part in rates))
        rates = motion_of_platform(form.pivot_frame, poses.R, at_pivot)
    return TimedRows(poses.t, poses, rates)


def motion_of_values(
    instance: Instance, R: Array, T: Array, rates: tuple[Array, Array]
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

    twists = solved(rates[0] * unit)
    accelerations = solved(rates[1] * unit - acting.at.rates(twists, np.zeros(6))[1])
    lengths = np.repeat([1.0, model.metre], 3)
    return PoseRates(twists / lengths, accelerations / lengths)
