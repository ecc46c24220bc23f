"""Trajectories along which the lines of a DLL stay parallel: a plate that slides on a table."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.geometry.instance import Instance

Array = NDArray[np.float64]


def along_parallel_lines(instance: Instance, rows: Array, R: Array) -> Instance:
    """Return an instance with points for lines that are parallel at every pose of a trajectory.

    Lines are replaced if only values of DLL change and the lines are parallel at every pose that
    satisfies the other constraints. Lines that only pass through parallel positions are not
    replaced: their distance jumps there.

    Parameters
    ----------
    instance
        The platform, with the values of the first row, on one choice of sides.
    rows
        The values, shape (r, 6).
    R
        The rotations at the first row, shape (n, 3, 3).
    """
    lines = np.array([row.kind is DLL for row in instance.constraints])
    still = (np.ptp(rows[:, ~lines], axis=0) == 0).all()
    if not (lines.any() and still and len(R)):
        return instance
    # Counting is imported only here: few platforms have such lines.
    from gspcli.certification.counting import with_points_for_lines
    from gspcli.certification.poses.parallel_poses import nearly_parallel

    if not nearly_parallel(instance, R.astype(complex)).any(axis=1).all():
        return instance
    return with_points_for_lines(instance) or instance
