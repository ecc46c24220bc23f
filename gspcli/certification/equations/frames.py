"""The coordinates of Study points that are passed to proofs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.records import dataclass


@dataclass(frozen=True, kw_only=True, eq=False)
class StudyFrames:
    """Coordinates of Study points: ``T_instance = length T + base - R platform``.

    Attributes
    ----------
    length
        The unit of length.
    platform, base
        The origins in the frames of the instance, shape (3,).
    """

    length: float
    platform: Sequence[float] | NDArray[np.float64]
    base: Sequence[float] | NDArray[np.float64]

    @classmethod
    def of(cls, arrangement: Arrangement) -> StudyFrames:
        """Return the frames of the points of ``arrangement.normalized``."""
        return cls(
            length=arrangement.length,
            platform=arrangement.platform_centre,
            base=arrangement.base_centre,
        )


#: The frames of the instance.
OWN = StudyFrames(length=1.0, platform=(0.0, 0.0, 0.0), base=(0.0, 0.0, 0.0))
