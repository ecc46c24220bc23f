"""Poses as balls of complex numbers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np
from flint import acb, arb
from numpy.typing import NDArray

from gspcli.certification.numbers.balls import largest
from gspcli.geometry import study
from gspcli.records import dataclass


@dataclass(frozen=True)
class PoseBall:
    """Balls that contain a rotation, by rows, and a translation in units of the scale."""

    rotation: list[list[acb]]
    translation: list[acb]

    @property
    def entries(self) -> list[acb]:
        """The twelve numbers."""
        return [*chain(*self.rotation), *self.translation]

    def widened(self, radius: float, length: float) -> PoseBall:
        """Return balls of all poses that deviate by at most a radius from this one."""
        turned, moved = (acb(arb(0, x), arb(0, x)) for x in (radius, arb(radius) * length))
        return PoseBall(
            [[entry + turned for entry in row] for row in self.rotation],
            [entry + moved for entry in self.translation],
        )

    def deviation(self, other: PoseBall, length: float) -> tuple[arb, arb]:
        """Bound the largest difference of any of the numbers of two poses, below and above.

        Differences of translations are divided by a length, a power of two in units of the scale.
        """
        gaps = [x - y for x, y in zip(self.entries, other.entries, strict=True)]
        gaps[9:] = [gap / length for gap in gaps[9:]]
        return max(gap.abs_lower() for gap in gaps), largest(gaps)


def pose_of_point(point: Sequence[acb]) -> PoseBall | None:
    """Return the pose of a Study point, or None if N is not proved to differ from zero."""
    n, rotation, translation = study.motion(point)
    if n.contains(0):
        return None
    unit = 1 / n
    return PoseBall(
        [[entry * unit for entry in row] for row in rotation],
        [entry * unit for entry in translation],
    )


def pose_of_floats(R: NDArray[np.complex128], T: NDArray[np.complex128], scale: float) -> PoseBall:
    """Return a pose whose numbers are given, exactly: shapes (3, 3) and (3,), length units."""
    return PoseBall(
        [[acb(x) for x in row] for row in R.tolist()], [acb(x) / scale for x in T.tolist()]
    )
