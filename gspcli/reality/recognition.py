"""The real ones of many solutions; near double solutions the answer may be "undecided"."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.quaternions import normalized
from gspcli.records import dataclass

#: The error of a solution of norm 1 is about the condition number times this, ...
_EPS = float(np.finfo(float).eps)
#: ... and less than this many times that: smaller imaginary parts are those of real ones, ...
_REAL = 100.0
#: ... and above this many times not.
_COMPLEX = 10_000.0
#: Points with a smaller relative imaginary part are probably real.
_FLAT = 1e-6


def look_real(points: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Return which points of any norm are probably real, without proof, shape (n, 8) -> (n,)."""
    pivot = points[np.arange(len(points)), np.abs(points).argmax(axis=-1)]
    return np.asarray(np.abs((points / pivot[:, None]).imag).max(axis=-1) < _FLAT)


@dataclass(frozen=True, eq=False)
class Reality:
    """Which solutions of a system are real.

    Attributes
    ----------
    real
        Shape (n,).
    decided
        Whether this is clear for all of them: all are simple, and no imaginary part and no distance
        of real ones has the size of an error. This is a numerical argument and no proof.
    """

    real: NDArray[np.bool_]
    decided: bool

    @property
    def count(self) -> int:
        """The number of real ones."""
        return int(self.real.sum())


def reality(points: NDArray[np.complex128], condition: NDArray[np.float64]) -> Reality:
    """Return which solutions are real.

    Real systems have conjugate solutions. A solution with an imaginary part of the size of its
    error equals its conjugate, unless another solution is as near.

    Parameters
    ----------
    points
        All solutions of a system, scaled to N = 1, shape (n, 8).
    condition
        Their condition numbers, shape (n,).
    """
    z = normalized(points)
    error = _EPS * condition
    height = np.linalg.norm(z.imag, axis=-1)
    real = height < _REAL * error
    unclear = ~(real | (height > _COMPLEX * error))
    x = z[real].real
    overlap = np.abs(x @ x.T)
    np.fill_diagonal(overlap, 0.0)
    # The sine of the angle between two lines, squared.
    apart = 1.0 - overlap.max(axis=-1, initial=0.0) ** 2
    # The two of a conjugate pair that look real are within their errors of each other.
    double = apart < np.maximum(4 * _REAL * error[real], 1e-7) ** 2
    return Reality(real, not (unclear.any() or double.any()))
