"""What points, lines and planes of a chain's joints measure while the chain moves.

A primitive is a point and a direction: of a point the direction is not used.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.tolerances import PARALLEL_SINE
from gspcli.machines.frames import place, turn
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: The kinds that are looked for, in this order. A chain that holds an angle of a line or plane
#: holds the angle of two lines, too: ALL stands for all four. DLL is the last: lines that are
#: parallel in one pose are held there by more than one constraint.
ORDER = ("DPP", "ALL", "DPL", "DLP", "DPH", "DHP", "DLL")


@dataclass(frozen=True, eq=False)
class Primitives:
    """Points or lines or planes of one body.

    Attributes
    ----------
    points
        A point of each, shape (n, 3).
    directions
        The unit direction or normal of each, shape (n, 3); zeros for points.
    """

    points: Array
    directions: Array

    @staticmethod
    def of(points: list[Array], directions: list[Array] | None = None) -> Primitives:
        """Return primitives from lists."""
        made = np.array(points, float).reshape(-1, 3)
        if directions is None:
            return Primitives(made, np.zeros_like(made))
        return Primitives(made, np.array(directions, float).reshape(-1, 3))

    def __len__(self) -> int:
        return len(self.points)

    def moved(self, X: Array) -> Primitives:
        """Return them in another frame."""
        return Primitives(place(X, self.points), turn(X, self.directions))

    def one(self, index: int) -> Primitives:
        """Return one of them, still with an axis of length 1."""
        return Primitives(self.points[[index]], self.directions[[index]])


def measured(kind: str, platform: Primitives, base: Primitives, X: Array) -> Array:
    """Return the distances or angles of primitives at a pose.

    Parameters
    ----------
    kind
        One of `ORDER`.
    platform, base
        Those of the platform, in its frame, and of the base, in its own: n and m.
    X
        The pose of the platform, shape (4, 4).

    Returns
    -------
    Array
        Shape (n, m). Angles are between 0 and pi; distances to planes are signed.
    """
    own = platform.moved(X)
    r = own.points[:, None] - base.points[None]
    u, v = own.directions[:, None], base.directions[None]
    if kind == "DPP":
        return np.asarray(np.linalg.norm(r, axis=-1))
    if kind == "DPL":
        return np.asarray(np.linalg.norm(np.cross(r, v), axis=-1))
    if kind == "DLP":
        return np.asarray(np.linalg.norm(np.cross(r, u), axis=-1))
    if kind == "DPH":
        return np.asarray((r * v).sum(axis=-1))
    if kind == "DHP":
        return np.asarray(-(r * u).sum(axis=-1))
    normal = np.cross(u, v)
    sine = np.linalg.norm(normal, axis=-1)
    if kind == "ALL":
        return np.asarray(np.arctan2(sine, (u * v).sum(axis=-1)))
    across = np.abs((r * normal).sum(axis=-1)) / np.where(sine > PARALLEL_SINE, sine, 1.0)
    apart = np.linalg.norm(np.cross(r, v), axis=-1)
    return np.asarray(np.where(sine > PARALLEL_SINE, across, apart))
