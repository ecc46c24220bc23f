"""Checks of sets of values of one platform; a mistake is named with its place."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.types import CONSTRAINTS
from gspcli.errors import ArgumentError
from gspcli.geometry.evaluation import LARGEST, SMALLEST
from gspcli.geometry.instance import AngleUnit, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.ranges import wrong_value

Array = NDArray[np.float64]


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
        message = (
            f"found something that is no array of numbers ({error}), expected shape (batch, 6)"
        )
        raise ArgumentError(message, "values") from None
    if rows.ndim != 2 or rows.shape[1] != CONSTRAINTS:
        message = f"found shape {rows.shape}, expected (batch, {CONSTRAINTS})"
        raise ArgumentError(message, "values")
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
