"""Readings of a machine, and the values between its primitives.

Files, tables and encoders give readings; values are distances and angles. A value is its reading
times ``1 + scale``, plus ``offset``; a calibration finds both for each constraint. Solving, proving
and measuring use values only: readings are converted on input, and values on output.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from gspcli.catalogue.types import CONSTRAINTS
from gspcli.errors import ArgumentError
from gspcli.geometry.checking import wrong_value
from gspcli.geometry.instance import AngleUnit, Array, Instance, Side
from gspcli.geometry.numbers import LARGEST, SMALLEST, Number


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


def value_rows(values: Any) -> Array:
    """Return sets of values as an array of shape (batch, 6).

    Raises
    ------
    ArgumentError
        If they have another shape, or are not numbers.
    """
    try:
        rows = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentError(
            f"found something that is no array of numbers ({error}), expected shape (batch, 6)",
            "values",
        ) from None
    if rows.ndim != 2 or rows.shape[1] != CONSTRAINTS:
        raise ArgumentError(f"found shape {rows.shape}, expected (batch, {CONSTRAINTS})", "values")
    return rows


def problems_of(instance: Instance, rows: Array) -> dict[int, str]:
    """Return what is wrong with sets of values, by their indices.

    Parameters
    ----------
    instance
        Says which values are distances and which angles, and in which unit.
    rows
        Shape (batch, 6).
    """
    kinds = [row.kind for row in instance.constraints]
    half = 180.0 if instance.units.angle is AngleUnit.DEGREE else np.pi
    inward = [kind.platform is kind.base for kind in kinds]
    low = np.where(inward, 0.0, -half / 2)
    high = np.where(inward, half, half / 2)
    distance = np.array([kind.is_distance for kind in kinds])
    low, high = np.where(distance, 0.0, low), np.where(distance, LARGEST, high)
    with np.errstate(invalid="ignore"):
        right = (rows >= low) & (rows <= high)
        right &= (rows == 0) | (np.abs(rows) >= SMALLEST)
    problems: dict[int, str] = {}
    for k, i in np.argwhere(~right).tolist():
        if k in problems:
            continue
        try:
            number = Number.of(float(rows[k, i]))
            # The same rule as for one instance: a double may be the rounded end of the range.
            wrong = wrong_value(kinds[i], number, instance.units.angle)
            wrong = wrong and f"found {number}, {wrong}"
        except ArgumentError as error:
            wrong = error.message
        if wrong:
            problems[k] = f"values[{k}][{i}]: {wrong}"
    return problems
