"""What paths and ways between nodes of a map cost: length times condition number."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drives import Drives, is_driven
from gspcli.geometry.instance import Instance
from gspcli.geometry.residuals import condition_numbers

Array = NDArray[np.float64]

#: Decimals of estimated costs: last digits must not choose a way.
_DECIMALS = 6
#: Moves that are smaller are rounding errors of equal poses, in lengths of the platform.
_STILL = 1e-12


def steps(instance: Instance, R: Array, T: Array) -> Array:
    """Return how far the points of the platform move from row to row, shape (r - 1,).

    Root mean squares, in the unit of length; 0 where the poses differ by rounding errors only.
    """
    places = _places(instance, R, T)
    moved = np.sqrt((np.diff(places, axis=0) ** 2).sum(axis=2).mean(axis=1))
    return np.where(moved > _STILL * Arrangement.of(instance).length, moved, 0.0)


def cost(instance: Instance, R: Array, T: Array, power: float = 1.0) -> float:
    """Return the integral of a power of the condition number by the length of a path, in lengths.

    Parameters
    ----------
    instance
        The platform.
    R, T
        Poses along the path, shapes (r, 3, 3) and (r, 3).
    power
        Of the condition number; with 0 the cost is the length.
    """
    a = Arrangement.of(instance)
    regular = 1 / condition_numbers(_driven(instance, R, T), R, T)
    if not regular.all():
        return np.inf
    # The harmonic mean between rows: 1 / condition is nearly linear.
    mean = 2 / (regular[1:] + regular[:-1])
    return float((steps(instance, R, T) * mean**power).sum() / a.length)


class WayCosts:
    """Estimated costs of ways between nodes, by the poses at their ends."""

    def __init__(self, instance: Instance) -> None:
        self.instance = instance
        self._arrangement = Arrangement.of(instance)
        self._places: list[Array] = []
        self._regular: list[float] = []

    def add(self, R: Array, T: Array) -> None:
        """Add nodes, shapes (n, 3, 3) and (n, 3)."""
        self._places += [*_places(self.instance, R, T)]
        conditions = condition_numbers(_driven(self.instance, R, T), R, T)
        self._regular += (1 / conditions).tolist()

    def between(self, i: int, j: int) -> float:
        """Return the cost of a way between two nodes."""
        moved = self._places[j] - self._places[i]
        length = float(np.sqrt((moved**2).sum(axis=1).mean())) / self._arrangement.length
        return round(2 * length / max(self._regular[i] + self._regular[j], 1e-12), _DECIMALS)


def _driven(instance: Instance, R: Array, T: Array) -> Arrangement:
    """Return the platform at poses: points of cranks and slides are where they reach them."""
    if not is_driven(instance):
        return Arrangement.of(instance)
    drives = Drives.of(instance)
    return drives.arrangement(drives.inverse(R, T))


def _places(instance: Instance, R: Array, T: Array) -> Array:
    """Return the points of the platform that count at poses, shape (n, m, 3)."""
    a = Arrangement.of(instance)
    own = a.y[a.distances] if len(a.distances) else a.y
    places: Array = own @ np.swapaxes(R, -1, -2) + T[:, None]
    return places
