"""Comparing sets of poses: by matching, never by order."""

from __future__ import annotations

import numpy as np

from gspcli.geometry.quaternions import Field


def pose_set_distance(
    first: tuple[Field, Field], second: tuple[Field, Field], length: float
) -> float:
    """Return how far two sets of poses (R, T) are from being the same set.

    Each pose is matched with the nearest of the other set. The result is the largest distance of a
    pair. It is infinity if the sets differ in size or the matching is not one to one. The distance
    is the largest difference of an entry of R, or of T divided by a length, relative to the size of
    these entries where that is above one.

    Parameters
    ----------
    first, second
        Rotations (n, 3, 3) and translations (n, 3), real or complex.
    length
        What translations are divided by.
    """
    a, b = (
        np.concatenate((R.reshape(-1, 9), T.reshape(-1, 3) / length), axis=1)
        for R, T in (first, second)
    )
    if len(a) != len(b):
        return float("inf")
    if not len(a):
        return 0.0
    sizes = np.maximum(1.0, np.abs(a).max(axis=1))
    distances = np.abs(a[:, None] - b).max(axis=2) / sizes[:, None]
    nearest = distances.argmin(axis=1)
    if len(set(nearest.tolist())) < len(a):
        return float("inf")
    return float(distances.min(axis=1).max())
