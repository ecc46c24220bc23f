"""Where paths end: what strategies yield, and the ledger proves."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.equations.local_frames import StudyFrames
from gspcli.continuation.quadrics import ComplexArray

if TYPE_CHECKING:
    from gspcli.certification.poses.far_poses import FarPoses


class Ends(NamedTuple):
    """Points that may be poses, for each of b sets of values.

    Attributes
    ----------
    points, frames
        Study points of any norm for k choices of sides, shape (b, k, m, 8), and their frames; not
        a number where a path is lost.
    far
        Poses far away, to which no paths lead, if there is one choice of sides.
    has_directions
        Whether quaternions are right in all digits, up to a factor, where N nearly vanishes, too:
        where paths with fewer unknowns to one platform have arrived.
    planes
        For each end and constraint 1 or -1 for the complex plane through the line that the point
        is in, 0 for constraints without points and lines, shape (m, 6); None if there are none.
    """

    points: ComplexArray
    frames: StudyFrames
    far: FarPoses | None = None
    has_directions: bool = False
    planes: NDArray[np.int64] | None = None
