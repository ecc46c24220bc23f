"""Readings of a machine, and the values between its primitives.

Files, tables and encoders give readings; values are distances and angles. A value is its reading
times ``1 + scale``, plus ``offset``; a calibration finds both for each constraint. Solving, proving
and measuring use values only: readings are converted on input, and values on output.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.instance import Instance, Side

Array = NDArray[np.float64]


def offsets(instance: Instance, *, signed: bool = True) -> Array:
    """Return the numbers that are added to readings to give values, shape (6,).

    Parameters
    ----------
    instance
        The platform.
    signed
        Whether distances to planes are signed; if not, they are on the side of their constraint.
    """
    return np.array(
        [
            0.0
            if row.offset is None
            else row.offset.value * (-1 if row.side is Side.NEGATIVE and not signed else 1)
            for row in instance.constraints
        ]
    )


def factors(instance: Instance) -> Array:
    """Return the factors of readings and of their rates: one plus the scales, shape (6,)."""
    return np.array(
        [1.0 if row.scale is None else 1 + row.scale.value for row in instance.constraints]
    )


def values_of(instance: Instance, readings: Array, *, signed: bool = True) -> Array:
    """Return the values of readings, shape (..., 6); see `offsets`."""
    if not is_corrected(instance):
        return readings
    return readings * factors(instance) + offsets(instance, signed=signed)


def readings_of(instance: Instance, values: Array, *, signed: bool = True) -> Array:
    """Return the readings at values, shape (..., 6); see `offsets`."""
    if not is_corrected(instance):
        return values
    return (values - offsets(instance, signed=signed)) / factors(instance)


def without_corrections(instance: Instance) -> Instance:
    """Return the same platform with its values as readings."""
    if not is_corrected(instance):
        return instance
    rows = tuple(replace(row, offset=None, scale=None) for row in instance.constraints)
    return replace(instance, constraints=rows)


def is_corrected(instance: Instance) -> bool:
    """Return whether some constraint states an offset or a scale."""
    return any(row.offset is not None or row.scale is not None for row in instance.constraints)
