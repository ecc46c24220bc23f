"""Ends of paths where the two lines of a DLL distance are parallel.

The paper's equation of a line-line distance (Section 4, DLL) is multiplied by the squared sine of
the angle of the lines, so it holds wherever they are parallel, at every distance. Such an end is
a pose only if the distance of the parallel lines is the one that was asked for.

Where the lines are parallel the gradient of M^2 - d^2 (N^2 - C^2) vanishes (M = 0, and N - C or
N + C is a sum of two squares that vanish), so those ends are singular: a regular end is always a
pose, however small the angle of its lines.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.geometry.poses import Field, dot
from gspcli.geometry.residuals import Arrangement, placed

#: Unit directions that differ by less are parallel: what is left of double precision at an end
#: where several paths meet.
_PARALLEL = 1e-5
#: Distances, in lengths of the platform, that differ by less are equal at such an end ...
_EQUAL = 1e-5
#: ... and those that differ by more are not.
_DIFFERENT = 1e-3


def judge_parallel_lines(
    arrangement: Arrangement, R: Field, T: Field, singular: NDArray[np.bool_]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which poses are none because parallel lines have another distance, or may be none.

    Parameters
    ----------
    arrangement
        The platform.
    R, T
        Solutions of its equations, shapes (n, 3, 3) and (n, 3).
    singular
        At which of them the equations are singular, shape (n,).

    Returns
    -------
    spurious, undecided
        Shape (n,): proved by the distance of the lines to be no pose, and too near to tell.
    """
    spurious = np.zeros(len(R), dtype=np.bool_)
    undecided = np.zeros(len(R), dtype=np.bool_)
    lines = [i for i, kind in enumerate(arrangement.kinds) if kind is DLL]
    if not lines or not len(R):
        return spurious, undecided
    r, w = (field[:, lines] for field in placed(arrangement, R, T))
    v = arrangement.v[lines]
    apart = [np.sqrt((np.abs(w - sign * v) ** 2).sum(axis=-1)) for sign in (1, -1)]
    parallel = singular[:, None] & (np.minimum(*apart) < _PARALLEL)
    # The squares of complex distances are compared: their roots have no sign.
    across = r - dot(r, v)[..., None] * v
    square = arrangement.targets[lines] ** 2
    error = np.abs(dot(across, across) - square)
    size = arrangement.length * (arrangement.length + np.sqrt(square))
    spurious |= (parallel & (error > _DIFFERENT * size)).any(axis=1)
    undecided |= ~spurious & (parallel & (error > _EQUAL * size)).any(axis=1)
    return spurious, undecided
