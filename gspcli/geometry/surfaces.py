"""Where the platform can be once its orientation is known (Propositions 6.4, 6.5 and 6.7).

With the rotation fixed, each distance constraint keeps the translation T on a surface: DPH, DHP
and DLL on a plane or two parallel ones, DPP on a sphere, DPL and DLP on a circular cylinder,
and so does DLL when its lines are parallel. Three such surfaces meet in 2^m points, m of them
being quadrics once the differences of spheres have been replaced by planes.

Coordinates are X = (s, t), homogeneous in a basis B of the f with ``e.f = 0``: the Study point of
X is (s e, B t), so that ``T = 2 vec(B t e*) / (s N)``. Surfaces are forms in X, and a plane is a
vector of length 4, a quadric a symmetric matrix of order 4. At a complex rotation N may be
small and R large. The forms are made of the quaternion, nowhere divided by N and without
cancellation, so that they stay accurate. Lengths should be of order one and the points near the
origin.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.geometry.distance_forms import Measures
from gspcli.geometry.intersections import generic_points
from gspcli.geometry.quaternions import Field
from gspcli.records import dataclass

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: A coordinate of a point of norm one is not zero if it is larger than this and its error.
_CERTAIN = 1e-12


@dataclass(frozen=True, eq=False)
class Surfaces:
    """The surfaces of one structure for many rotations; f counts the rotations.

    Attributes
    ----------
    planes
        The planes for each combination of sides: those of the k heights, then the planes of the
        circles in which the first sphere meets the others; shape (f, s, k + circles, 4).
    quadrics
        The quadrics, spheres first, shape (f, m, 4, 4).
    spheres
        How many of them are spheres.
    basis
        The basis of the f, shape (f, 4, 3).
    frame
        ``T = frame t / s``, shape (f, 3, 3).
    skewness
        Least squared sine, in absolute value, of line pairs that give planes, shape (f,).
    """

    planes: Complex
    quadrics: Complex
    spheres: int
    basis: Complex
    frame: Complex
    skewness: Array


def surfaces(given: Measures, e: Complex, distances: Array) -> Surfaces:
    """Return the surfaces at rotations. Those of real rotations are exactly real.

    Parameters
    ----------
    given
        What the distances measure.
    e
        Quaternions of norm 1, shape (f, 4).
    distances
        The distances for each rotation, shape (f, d).
    """
    planes, quadrics, basis, frame, skewness = _kernel.surfaces(
        given.forms,
        given.spheres,
        given.skew,
        given.signs,
        given.basis,
        np.ascontiguousarray(e),
        np.ascontiguousarray(distances[:, given.flat]),
        np.ascontiguousarray(distances[:, given.curved]),
    )
    return Surfaces(planes, quadrics, given.spheres, basis, frame, skewness)


def generic_positions(
    given: Surfaces, accuracy: Array, real: NDArray[np.bool_]
) -> tuple[Complex, Array, NDArray[np.bool_]]:
    """Return the intersection points of surfaces in general position.

    Parameters
    ----------
    given
        The surfaces.
    accuracy
        The relative error of their forms, shape (f,).
    real
        Which rotations are real, shape (f,): their points are exactly real or in exactly
        conjugate pairs.

    Returns
    -------
    points
        Forms X of norm 1, shape (f, s, 2^m, 4): rotations, sign combinations, points.
    errors
        Their estimated errors, shape (f, s, 2^m).
    ok
        Which of the systems have been solved, shape (f, s).
    """
    quadrics = given.quadrics
    if given.spheres > 1:
        quadrics = np.delete(quadrics, slice(1, given.spheres), axis=1)
    return generic_points(given.planes, quadrics, accuracy, real)


def certainly_not_zero(coordinate: Field, errors: Array) -> NDArray[np.bool_]:
    """Return which coordinates of points of norm one differ from zero beyond doubt."""
    return np.asarray(np.abs(coordinate) > np.maximum(_CERTAIN, 100 * errors))
