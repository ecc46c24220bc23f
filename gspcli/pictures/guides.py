"""Dashed ways to feet that lie outside the drawn part of a line or plane."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Primitive
from gspcli.pictures.scene import DrawnPrimitive, Stroke, StrokeStyle

Array = NDArray[np.float64]

#: Feet outside by less than this fraction of the drawn part are inside.
_INSIDE = 1e-6


def guides(element: DrawnPrimitive, feet: Array) -> Iterator[Stroke]:
    """Yield the way from what is drawn of a primitive to a foot on it at each pose.

    Parameters
    ----------
    element
        The primitive.
    feet
        One point of it at each pose, in the frame of its body, shape (n, 3). Where the foot is
        inside, both ends of the stroke are the foot; if it always is, there is no stroke.
    """
    if element.primitive is Primitive.POINT:
        return
    centre = element.centre
    if element.primitive is Primitive.LINE:
        halves = (element.outline[1] - element.outline[0])[None] / 2
    else:
        corners = element.outline
        halves = np.stack((corners[1] - corners[0], corners[3] - corners[0])) / 2
    squares = (halves * halves).sum(axis=1)
    along = (feet - centre) @ halves.T / squares
    inside = np.clip(along, -1, 1)
    if (np.abs(along - inside) <= _INSIDE).all():
        return
    nearest = np.where(np.abs(along - inside) <= _INSIDE, along, inside)
    yield Stroke(StrokeStyle.GUIDE, np.stack((centre + nearest @ halves, feet), axis=1))
