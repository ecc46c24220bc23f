"""What every method of solution returns: poses, motions, and an account of every path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gspcli.solver.self_motion import Motion

Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class PoseSet:
    """Poses in no particular order, in the frames of the arrangement.

    Attributes
    ----------
    quaternions
        Of the rotations, ``e.e = 1``, with the sign of `quaternion_from_rotation`, shape (n, 4),
        complex.
    R, T
        Distinct isolated poses, shapes (n, 3, 3) and (n, 3), complex.
    real
        Which of them are real; their imaginary parts are exactly zero. Shape (n,).
    multiplicity
        How many paths end at each, shape (n,).
    motions
        Positive-dimensional sets of poses that were found.
    paths
        The generic count for the sides asked for.
    at_infinity, on_curves, lost
        How many of the paths end at infinity, on positive-dimensional sets, or are not
        accounted for.
    spurious
        How many paths end where the equations hold and a constraint does not: the lines of a
        DLL are parallel, at another distance. With the multiplicities of the poses and the
        other three numbers they add up to the paths.
    """

    quaternions: Complex
    R: Complex
    T: Complex
    real: NDArray[np.bool_]
    multiplicity: NDArray[np.int64]
    motions: tuple[Motion, ...]
    paths: int
    at_infinity: int
    on_curves: int
    lost: int
    spurious: int = 0
