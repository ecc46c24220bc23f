"""Combinations of six quadrics that are nearly dependent, in which all are of order one.

Two similar plates with the same order of joints make the six legs of a hexapod dependent. Rounded
to eps, a combination of the quadrics is of size eps. The poses depend on the same combination of
the values over eps: values that are measured at a pose differ there by eps, others by one over eps.
Divided by eps, this equation is like the others.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gspcli.continuation.quadrics import FloatArray

#: Quadrics are nearly dependent if a combination is smaller than this part of the largest. They are
#: dependent, up to rounding, below the other one.
_NEARLY, _DEPENDENT = 1e-2, 1e-13
#: How far values of a start are from others: this part of what the equations are, or of what the
#: values are in a combination.
_SPREAD, _OF_VALUES = 0.5, 0.25
#: Places of the squares of e, and of ``e.f``.
_SQUARES, _PRODUCTS = [0, 4, 7, 9], [10, 15, 20, 25]


class Balance(NamedTuple):
    """Combinations of six quadrics, each of which has a value times N on the other side.

    Attributes
    ----------
    constants
        The multiple of N in each quadric, shape (6,).
    combinations
        What makes quadrics without them orthonormal, shape (6, 6).
    directions, sizes
        Orthonormal combinations of the quadrics, in columns, and their sizes as parts of the
        largest, shapes (6, 6) and (6,).
    """

    constants: FloatArray
    combinations: FloatArray
    directions: FloatArray
    sizes: FloatArray

    @classmethod
    def of(cls, quadrics: FloatArray) -> Balance | None:
        """Return that of quadrics (6, 27); None if they are not nearly dependent, or dependent."""
        constants = quadrics[:, _SQUARES].mean(axis=1)
        directions, sizes, _ = np.linalg.svd(_apart(quadrics, constants), full_matrices=False)
        parts = sizes / sizes[0]
        if not _DEPENDENT < parts[-1] < _NEARLY:
            return None
        return cls(constants, directions.T / sizes[:, None], directions, parts)

    def quadrics(self, given: FloatArray) -> FloatArray:
        """Return the combinations of the quadrics (6, 27)."""
        found: FloatArray = self.combinations @ _apart(given, self.constants)
        return found

    def spread(self, values: FloatArray) -> FloatArray:
        """Return by how much values differ from others that are like them.

        Parameters
        ----------
        values
            Of the quadrics, shape (6,).

        Returns
        -------
        FloatArray
            A matrix: its products with vectors of order one are such differences, shape (6, 6).
        """
        own = np.abs((values - self.constants) @ self.directions)
        sizes = np.maximum(_SPREAD * self.sizes, np.minimum(_OF_VALUES * own, _SPREAD))
        found: FloatArray = self.directions * sizes
        return found


def _apart(quadrics: FloatArray, constants: FloatArray) -> FloatArray:
    """Return quadrics (6, 27) without multiples of N and of e.f."""
    found = quadrics.copy()
    found[:, _SQUARES] -= constants[:, None]
    found[:, _PRODUCTS] -= quadrics[:, _PRODUCTS[:1]]
    return found
