"""Which of many solutions are real, with an honest third answer near double ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.quaternions import normalized
from gspcli.records import dataclass

#: The error of a solution of norm 1 is about the condition number times this, ...
_EPS = float(np.finfo(float).eps)
#: ... and certainly less than so many times that: imaginary parts below are those of real ones, ...
_REAL = 100.0
#: ... and above this many times not.
_COMPLEX = 10_000.0
#: Points with a relatively smaller imaginary part look real.
_FLAT = 1e-6


def look_real(points: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Return which points of any norm look real, no more than that, shape (n, 8) -> (n,)."""
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
        Whether that is certain for all of them: all simple, none with an imaginary part or a
        distance to another real one of the size of its error. A numerical argument, no proof.
    """

    real: NDArray[np.bool_]
    decided: bool

    @property
    def count(self) -> int:
        """How many are real."""
        return int(self.real.sum())


def reality(points: NDArray[np.complex128], condition: NDArray[np.float64]) -> Reality:
    """Return which solutions are real.

    Real systems have conjugate solutions. A solution with an imaginary part of the size of
    its error is one with its conjugate, unless there is another as near.

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
