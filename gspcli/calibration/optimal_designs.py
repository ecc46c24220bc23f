"""Which of many measurements tell most: one by one, then exchanged one for one.

They are chosen so that the determinant of the information about the parameters is the largest
(D-optimal), and then exchanged (Fedorov 1972) so that a mean square error is the least (I-optimal).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.ties import first_largest

Array = NDArray[np.float64]

#: So often each measurement is exchanged for a better one.
_EXCHANGES = 5


def d_optimal(slopes: Array, count: int, before: Array) -> NDArray[np.intp]:
    """Return the indices of poses, chosen one by one for the largest determinant of information.

    Parameters
    ----------
    slopes
        Whitened derivatives of what each of c poses tells, shape (c, q, f).
    count
        How many poses; one may be chosen more than once.
    before
        What is known before, an information matrix, shape (f, f).
    """
    eye = np.eye(slopes.shape[1])
    inverse, chosen = np.linalg.inv(before), []
    for _ in range(count):
        told = eye + slopes @ inverse @ np.swapaxes(slopes, 1, 2)
        best = int(first_largest(np.linalg.slogdet(told)[1]))
        chosen.append(best)
        # Woodbury's formula.
        moved = inverse @ slopes[best].T
        inverse = inverse - moved @ np.linalg.solve(eye + slopes[best] @ moved, moved.T)
    return np.array(chosen, np.intp)


def exchanged(
    slopes: Array, chosen: NDArray[np.intp], before: Array, errors: Array
) -> NDArray[np.intp]:
    """Return poses after exchanges, as long as they make the mean square error less.

    Parameters
    ----------
    slopes, before
        As for `d_optimal`.
    chosen
        Which poses to begin with, shape (n,).
    errors
        The mean square error as a form of the parameters' errors (`pose_errors`), shape (f, f).
    """
    eye, best = np.eye(slopes.shape[1]), chosen.tolist()
    for _ in range(_EXCHANGES):
        changed = False
        for k in range(len(best)):
            others = best[:k] + best[k + 1 :]
            known = before + np.einsum("kqa,kqb->ab", slopes[others], slopes[others])
            inverse = np.linalg.inv(known)
            told = eye + slopes @ inverse @ np.swapaxes(slopes, 1, 2)
            less = slopes @ (inverse @ errors @ inverse) @ np.swapaxes(slopes, 1, 2)
            gain = np.trace(np.linalg.solve(told, less), axis1=1, axis2=2)
            pose = int(first_largest(gain))
            if gain[pose] > gain[best[k]] * (1 + 1e-9):
                best[k], changed = pose, True
        if not changed:
            break
    return np.array(best, np.intp)
