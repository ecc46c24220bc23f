"""The platform at one row of a trajectory, and the platform for following along all rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.numbers import Number

Array = NDArray[np.float64]


def over_rows(instance: Instance, rows: Array) -> Instance:
    """Return the instance for following along rows; a value is zero if it is so at all rows."""
    values = rows[:, :6]
    return at_values(instance, values[np.abs(values).argmax(axis=0), np.arange(6)])


def at_values(instance: Instance, values: Array) -> Instance:
    """Return an instance with other values; a signed distance to a plane becomes a side."""
    constraints = []
    for constraint, value in zip(instance.constraints, values[:6].tolist(), strict=True):
        side = constraint.side
        if constraint.kind.has_sides:
            side = Side.NEGATIVE if value < 0 else Side.POSITIVE
            value = abs(value)
        constraints.append(replace(constraint, value=Number.of(value), side=side))
    return replace(instance, constraints=tuple(constraints))


def along_rows(instance: Instance, rows: Array, R: Array) -> Instance:
    """Return the instance for following along rows, with points for lines that stay parallel.

    Lines are replaced if only values of DLL change and the lines are parallel at every pose that
    satisfies the other constraints: a plate that slides on a table. Lines that only pass through
    parallel positions are not replaced: their distance jumps there.

    Parameters
    ----------
    instance
        The platform.
    rows
        The values, shape (r, 6).
    R
        The rotations at the first row, shape (n, 3, 3).
    """
    return over_rows(_with_points(at_values(instance, rows[0]), rows[:, :6], R), rows)


def _with_points(instance: Instance, values: Array, R: Array) -> Instance:
    lines = np.array([row.kind is DLL for row in instance.constraints])
    still = (np.ptp(values[:, ~lines], axis=0) == 0).all()
    if not (lines.any() and still and len(R)):
        return instance
    # Counting is imported only here: few platforms have such lines.
    from gspcli.certification.counting import with_points_for_lines
    from gspcli.certification.poses.multiple import nearly_parallel

    if not nearly_parallel(instance, R.astype(complex)).any(axis=1).all():
        return instance
    return with_points_for_lines(instance) or instance
