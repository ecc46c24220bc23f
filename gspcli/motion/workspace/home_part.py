"""The boxes of poses that are connected with home by poses that are not singular.

The determinant of the Jacobian matrix keeps its sign on such a set. Two boxes that share a side,
both with the proved sign of home, are connected; boxes that only touch may be connected.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.errors import ArgumentError
from gspcli.motion.workspace.box_sets import BoxSet
from gspcli.motion.workspace.pose_boxes import (
    NEGATIVE,
    PARAMETERS,
    REGULAR,
    Conditions,
    PoseBoxes,
    places,
)

Array = NDArray[np.float64]

#: Half the width of the box about the home pose that must keep the limits, relative to the whole.
_NEAR = 1e-9


class HomePart:
    """The home pose among boxes.

    Parameters
    ----------
    boxes
        The platform, its home pose and its limits.
    bounds
        The box that is divided, all six parameters, shape (6, 2).
    indices
        The indices of the parameters that vary.

    Raises
    ------
    ArgumentError
        If home is not proved to keep all limits and to be regular.
    """

    def __init__(self, boxes: PoseBoxes, bounds: Array, indices: list[int]) -> None:
        self.boxes, self.bounds, self.indices = boxes, bounds, indices
        half = _NEAR * (bounds[:, 1] - bounds[:, 0])
        if not half[indices].all():
            message = "home does not keep the limits"
            raise ArgumentError(message)
        near = np.stack((boxes.home - half, boxes.home + half), axis=1)
        one, left = np.zeros(1, np.uint64), np.array([boxes.conditions])
        found = boxes.judge(near, indices, 0, one, left, split=False)
        if not len(found.inside):
            if len(found.open):
                names = boxes.names(int(found.open_left[0]))
                message = f"home is at a limit or singular: {', '.join(names)}"
            else:
                message = "home does not keep the limits"
            raise ArgumentError(message)
        self._sign = found.inside_signs[0] & NEGATIVE

    def split(self, inner: BoxSet, open_: BoxSet) -> tuple[BoxSet, BoxSet]:
        """Return the inner boxes that are connected with home, and the other boxes that may be."""
        inner, open_ = (boxes.chosen(self._same_sign(boxes.conditions)) for boxes in (inner, open_))
        reached = self._connected(inner, touching=False)
        near = self._connected(inner.and_also(open_), touching=True)
        count = len(inner.keys)
        # Inner boxes that may be connected with home, but are not proved to be.
        maybe = inner.chosen(near[:count] & ~reached)
        return inner.chosen(reached), maybe.and_also(open_.chosen(near[count:]))

    def _connected(self, boxes: BoxSet, *, touching: bool) -> NDArray[np.bool_]:
        """Return which boxes are connected with one that contains home, by such boxes."""
        turning = {k: self.bounds[k, 1] - self.bounds[k, 0] for k in self.indices if k > 2}
        whole = np.array([turning.get(k, 0.0) > 2 * math.pi - 1e-9 for k in self.indices])
        middle = PARAMETERS.index(self.boxes.middle)
        poles = -1
        if turning.get(middle, 0.0) > math.pi - 1e-9:
            poles = self.indices.index(middle)
        count = len(self.indices)
        labels = _kernel.connected_boxes(boxes.keys, boxes.levels, count, touching, whole, poles)
        part: NDArray[np.bool_] = np.isin(labels, labels[self._at_home(boxes)])
        return part

    def _at_home(self, boxes: BoxSet) -> NDArray[np.bool_]:
        """Return which boxes contain the home pose, with its boundary."""
        low, high = self.bounds[self.indices].T
        part = (self.boxes.home[self.indices] - low) / (high - low) * 2.0 ** boxes.levels[:, None]
        place = places(boxes.keys, len(self.indices))
        # At a corner of a box rounding errors would decide, so there is a margin. It is safe: the
        # box about home keeps the limits.
        room = 1e-12 * np.maximum(1.0, part)
        return np.asarray(((part >= place - room) & (part <= place + 1 + room)).all(axis=1))

    def _same_sign(self, conditions: Conditions) -> NDArray[np.bool_]:
        """Return which boxes are not proved to have the opposite sign of the determinant."""
        proved = (conditions & REGULAR) == 0
        return np.asarray(~(proved & ((conditions & NEGATIVE) != self._sign)))
