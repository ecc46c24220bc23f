"""Offsets of values: between what a machine reads and what is between its primitives.

Readings are what files, tables and encoders say; values are distances and angles. They differ by
the `offset` of a constraint, which a calibration finds. All that solves, proves and measures knows
values only: readings become values where they enter, and values readings where they are told.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.instance import Instance, Side

Array = NDArray[np.float64]


def offsets(instance: Instance, *, signed: bool = True) -> Array:
    """Return what is added to readings to make them values, shape (6,).

    Parameters
    ----------
    instance
        The platform.
    signed
        Whether distances to planes are signed, or have the side of their constraint.
    """
    return np.array(
        [
            0.0
            if row.offset is None
            else row.offset.value * (-1 if row.side is Side.NEGATIVE and not signed else 1)
            for row in instance.constraints
        ]
    )


def values_of(instance: Instance, readings: Array, *, signed: bool = True) -> Array:
    """Return the values that readings mean, shape (..., 6); see `offsets`."""
    return readings + offsets(instance, signed=signed) if _has_offsets(instance) else readings


def readings_of(instance: Instance, values: Array) -> Array:
    """Return the readings at values, shape (..., 6); those of DPH and DHP are signed."""
    return values - offsets(instance) if _has_offsets(instance) else values


def without_offsets(instance: Instance) -> Instance:
    """Return the same platform with its values as readings."""
    if not _has_offsets(instance):
        return instance
    rows = tuple(replace(row, offset=None) for row in instance.constraints)
    return replace(instance, constraints=rows)


def _has_offsets(instance: Instance) -> bool:
    return any(row.offset is not None for row in instance.constraints)
