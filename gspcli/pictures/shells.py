"""What a picture shows of the shapes that an instance file states: thick legs and outlines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.geometry.instance import Instance
from gspcli.pictures.hulls import convex_hull

Array = NDArray[np.float64]

#: Of more points only those farthest in so many directions are drawn: a hull of all takes too long.
_CORNERS = 40


def drawn_diameters(instance: Instance) -> dict[int, float]:
    """Return the stated diameters of legs that are not zero, by the index of the constraint."""
    if instance.shapes is None:
        return {}
    legs = [k for k, row in enumerate(instance.constraints) if row.kind is DPP]
    stated = [one.value for one in instance.shapes.diameters]
    every = stated * len(legs) if len(stated) == 1 else stated
    return {k: diameter for k, diameter in zip(legs, every, strict=True) if diameter > 0}


def drawn_shells(instance: Instance) -> dict[str, tuple[Array, ...]]:
    """Return the faces of the stated outlines by the name of the body, in its frame."""
    found = {}
    for name in ("platform", "base"):
        stated = () if instance.shapes is None else getattr(instance.shapes, name)
        if stated:
            points = np.array([[x.value for x in point] for point in stated])
            faces = tuple(face for face in convex_hull(_corners(points)) if len(face) > 2)
            if faces:
                found[name] = faces
    return found


def _corners(points: Array) -> Array:
    """Return the points that are farthest in directions all around, if there are many."""
    if len(points) <= _CORNERS:
        return points
    # Directions on a spiral, evenly over the sphere.
    k = np.arange(_CORNERS)
    height, angle = 1 - (2 * k + 1) / _CORNERS, k * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - height**2)
    directions = np.stack((across * np.cos(angle), across * np.sin(angle), height), axis=1)
    return np.asarray(points[np.unique((points @ directions.T).argmax(axis=0))])
