"""The platform at one row of a trajectory, and the platform for following along all rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

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
