"""The poses of platforms with three angles as Study points, if they are in general position.

First the rotations, then for each the translations, natively for many sets of values at a time
(native/closed_form.hpp; paper, Section 6).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.constraint_polynomials import measures

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class StudyPoints(NamedTuple):
    """Poses for sets of values, b in number.

    Attributes
    ----------
    points
        Study points of any norm, shape (b, s, n, 8) for s combinations of sides; exactly real for
        real poses, zero where a set is not in general position.
    general
        Which sets are in general position, shape (b,): by Bezout's theorem they have no other
        poses.
    signs
        The sign of each constraint for each combination, shape (s, 6).
    """

    points: Complex
    general: NDArray[np.bool_]
    signs: Array


def study_points(given: Arrangement, distances: Array, values: Array) -> StudyPoints:
    """Return all poses of one geometry for sets of values.

    Parameters
    ----------
    given
        The geometry with lengths of order one, and frames at the centres of the points.
    distances
        In the unit of `given`, shape (b, 3); a distance of zero is zero in `given`, too.
    values
        The sets of values, shape (b, 6); only the angles are used.
    """
    shapes, angles = measures(given), given.angles
    points, general = _kernel.closed_forms(
        given.u[angles],
        given.v[angles],
        given.cosines(values),
        shapes.forms,
        shapes.spheres,
        shapes.skew,
        shapes.signs,
        shapes.basis,
        distances[:, shapes.flat],
        distances[:, shapes.curved],
    )
    signs = np.ones((len(shapes.signs), len(given.kinds)))
    signs[:, given.distances[shapes.flat]] = shapes.signs
    return StudyPoints(points, general, signs)
