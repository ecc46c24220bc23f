"""Arrays that callers give, and those that results hold."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gspcli.errors import ArgumentError
from gspcli.geometry.checking import real_array
from gspcli.geometry.instance import Array
from gspcli.motion.poses.inverse_kinematics import checked_poses


def checked_rows(R: ArrayLike, T: ArrayLike) -> tuple[Array, Array]:
    """Return poses as new arrays of shapes (n, 3, 3) and (n, 3); one pose may stand alone.

    Raises
    ------
    ArgumentError
        If they have other shapes or numbers that are not finite, or there is none.
    """
    rotations, translations = checked_poses(R, T)
    if rotations.ndim == 2:
        rotations, translations = rotations[None], translations[None]
    if rotations.ndim != 3:
        found = f"found shapes {rotations.shape} and {translations.shape}"
        message = f"{found}, expected (n, 3, 3) and (n, 3)"
        raise ArgumentError(message, "R, T")
    if not len(rotations):
        message = "found no poses, expected at least one"
        raise ArgumentError(message, "R, T")
    return rotations.copy(), translations.copy()


def checked_array(given: ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    """Return a new array of a shape, with which what is given is broadcast.

    Raises
    ------
    ArgumentError
        If it cannot be, or has numbers that are not finite.
    """
    array = real_array(given, name)
    try:
        whole = np.broadcast_to(array, shape).copy()
    except ValueError:
        message = f"found shape {array.shape}, expected {shape}"
        raise ArgumentError(message, name) from None
    if not np.isfinite(whole).all():
        index = np.argwhere(~np.isfinite(whole))[0].tolist()
        message = f"found {whole[tuple(index)]}, expected a finite number"
        raise ArgumentError(message, f"{name}{index}")
    return whole


class RowError(ArgumentError):
    """A mistake of one row.

    Parameters
    ----------
    row
        The row, from 0.
    message
        What was found and what was expected.
    """

    def __init__(self, row: int, message: str) -> None:
        self.row = row
        super().__init__(message, f"row {row + 1}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.row, self.message)


def by_chunks(count: int, size: int, compute: Callable[[slice], tuple[Any, ...]]) -> list[Any]:
    """Return what is computed of rows, so many at a time that the cache of a core holds them.

    Parameters
    ----------
    count, size
        How many rows there are, and how many are computed together.
    compute
        Returns arrays with one entry for each of some rows.

    Raises
    ------
    RowError
        With the row of all of them.
    """
    parts = []
    for start in range(0, count, size):
        try:
            parts.append(compute(slice(start, start + size)))
        except RowError as error:
            raise RowError(error.row + start, error.message) from None
    return [np.concatenate(part) for part in zip(*parts, strict=True)]


def make_read_only(result: Any) -> None:
    """Make the arrays of a result read-only."""
    for field in dataclasses.fields(result):
        value = getattr(result, field.name)
        if isinstance(value, np.ndarray):
            value.setflags(write=False)


def plain(numbers: ArrayLike) -> Any:
    """Return numbers as nested lists for JSON, in which those that are not finite are null."""
    array = np.asarray(numbers)
    found = array.astype(object)
    found[~np.isfinite(array)] = None
    return found.tolist()
