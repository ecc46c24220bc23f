"""Sets of boxes of a grid, of several levels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gspcli.motion.workspace.pose_boxes import Conditions, Keys

Levels = NDArray[np.int32]
#: Boxes of one level.
Layer: TypeAlias = "tuple[Keys, Conditions, int]"


class BoxSet(NamedTuple):
    """Boxes by their keys in the grid of their level, with the conditions of each."""

    keys: Keys
    conditions: Conditions
    levels: Levels

    @classmethod
    def of(cls, layers: Sequence[Layer]) -> BoxSet:
        """Return the boxes of all layers."""
        return cls(
            np.concatenate([np.zeros(0, np.uint64), *(keys for keys, _, _ in layers)]),
            np.concatenate([np.zeros(0, np.uint32), *(left for _, left, _ in layers)]),
            np.repeat(
                np.array([level for _, _, level in layers], np.int32),
                [len(keys) for keys, _, _ in layers],
            ),
        )

    def chosen(self, which: NDArray[np.bool_]) -> BoxSet:
        """Return some of the boxes."""
        return BoxSet(self.keys[which], self.conditions[which], self.levels[which])

    def and_also(self, other: BoxSet) -> BoxSet:
        """Return the boxes of both layers, one after the other."""
        return BoxSet(
            np.concatenate((self.keys, other.keys)),
            np.concatenate((self.conditions, other.conditions)),
            np.concatenate((self.levels, other.levels)),
        )
