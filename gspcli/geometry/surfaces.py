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

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.geometry.distance_forms import Measures
from gspcli.geometry.intersections import generic_points
from gspcli.geometry.quadric_intersections import all_roots
from gspcli.geometry.quaternions import Field, normalized
from gspcli.records import dataclass

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.int64]

_EPS = float(np.finfo(float).eps)


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


@dataclass(frozen=True, eq=False)
class Intersection:
    """Where three surfaces meet.

    Attributes
    ----------
    points
        The isolated finite points ``t / s``, shape (k, 3).
    multiplicity
        Of each, shape (k,).
    distant
        Forms X of simple points so far away that they may be at infinity, shape (l, 4).
    samples
        Some points of positive-dimensional components, shape (m, 3).
    infinite
        Whether there are such components at finite distance.
    lost
        How many points, with multiplicity, could not be made out.
    """

    points: Complex
    multiplicity: Index
    distant: Complex
    samples: Complex
    infinite: bool
    lost: int


#: Relative singular values below the first number count as zero, above the second as not.
_RANK = (1e-12, 1e-9)
#: A point is at infinity if its first coordinate (of norm one) is not larger than this.
_INFINITY = 1e-9
#: A coordinate of a point of norm one is not zero if it is larger than this and its error.
_CERTAIN = 1e-12


class _UndecidedError(Exception):
    """A rank that double precision cannot tell."""


def _rank(values: Array, accuracy: float) -> int:
    """Return how many singular values (of rows of norm one) are not zero."""
    zero, least = _RANK[0] + 10 * accuracy, _RANK[1] + 1e4 * accuracy
    if ((values > zero) & (values < least)).any():
        raise _UndecidedError
    return int((values >= least).sum())


def intersection(planes: Field, quadrics: Field, accuracy: float = _EPS) -> Intersection:
    """Return where surfaces meet, whatever their position.

    Parameters
    ----------
    planes
        Forms, shape (k, 4).
    quadrics
        Symmetric matrices, shape (m, 4, 4); k + m = 3.
    accuracy
        The relative error of both.
    """
    nothing = np.zeros((0, 3), complex)
    empty = Intersection(nothing, np.zeros(0, int), np.zeros((0, 4), complex), nothing, False, 0)
    try:
        reduced = _reduced(planes.astype(complex), quadrics.astype(complex), accuracy)
    except _UndecidedError:
        return replace(empty, lost=2 ** len(quadrics))
    if reduced is None:
        return empty
    frame, forms = reduced
    free = frame.shape[1] - 1 - len(forms)
    if free:
        # More unknowns than equations: sections with random planes give samples.
        cut = np.random.default_rng(free).normal(size=(frame.shape[1], len(forms) + 1))
        cut[0] = np.eye(len(forms) + 1)[0]
        roots = all_roots(cut.T @ forms @ cut)
        finite = certainly_not_zero(roots.points[:, 0], roots.errors)
        return replace(empty, samples=_affine(frame @ cut, roots.points[finite]), infinite=True)
    roots = all_roots(forms, accuracy)
    size, errors = np.abs(roots.points[:, 0]), roots.errors
    finite = certainly_not_zero(size, errors)
    simple = roots.multiplicity == 1
    # A multiple point may only be called infinite if its coordinate is as good as zero.
    lost = ~finite & ~simple & (size > _INFINITY)
    samples = roots.samples[certainly_not_zero(roots.samples[:, 0], np.full(1, _EPS))]
    return Intersection(
        points=_affine(frame, roots.points[finite]),
        multiplicity=roots.multiplicity[finite],
        distant=normalized(roots.points[~finite & simple] @ frame.T),
        samples=_affine(frame, samples),
        infinite=len(samples) > 0,
        lost=roots.lost + int(roots.multiplicity[lost].sum()),
    )


def certainly_not_zero(coordinate: Field, errors: Array) -> NDArray[np.bool_]:
    """Return which coordinates of points of norm one differ from zero beyond doubt.

    The others are examined in extended precision (`gspcli.solver.infinity`).
    """
    return np.asarray(np.abs(coordinate) > np.maximum(_CERTAIN, 100 * errors))


def _affine(frame: Complex, z: Complex) -> Complex:
    X = z @ frame.T
    affine: Complex = X[:, 1:] / X[:, :1]
    return affine


def _reduced(planes: Complex, quadrics: Complex, accuracy: float) -> tuple[Complex, Complex] | None:
    """Eliminate everything linear.

    Returns the frame, shape (4, n + 1) and affine (its first row is 1, 0 ...), of the
    subspace ``X = frame z`` in which what remains of the quadrics, shape (m, n + 1, n + 1), has
    linearly independent quadratic parts; m <= n. Returns None if the equations contradict
    each other, so that the surfaces meet at most at infinity.
    """
    frame = np.eye(4, dtype=complex)
    while True:
        subspace = _solved(planes, accuracy)
        if subspace is None:
            return None
        frame = frame @ subspace
        quadrics = subspace.T @ quadrics @ subspace
        # A quadric that contains the subspace says nothing more.
        norms = np.linalg.norm(quadrics, axis=(-2, -1))
        kept = np.argsort(-norms)[: _rank(norms, accuracy)]
        quadrics = quadrics[kept] / norms[kept, None, None]
        if not len(quadrics):
            return frame, quadrics
        parts = quadrics[:, 1:, 1:].reshape(len(quadrics), -1)
        left, values, _ = np.linalg.svd(parts)
        values = np.concatenate((values, np.zeros(len(quadrics))))[: len(quadrics)]
        rank = _rank(values, accuracy)
        if rank == len(quadrics):
            return frame, quadrics
        combined = np.einsum("ki,kab->iab", left.conj(), quadrics)
        quadrics = combined[:rank]
        planes = combined[rank:, 0] * np.array([1.0] + [2.0] * (combined.shape[-1] - 1))


def _solved(planes: Complex, accuracy: float) -> Complex | None:
    """Return the affine frame of the solutions of linear equations, None if there are none."""
    n = planes.shape[1] - 1
    norms = np.linalg.norm(planes, axis=1)
    # An equation 0 = 0 left over by an elimination says nothing; others are scaled to norm 1.
    kept = np.argsort(-norms)[: _rank(norms, accuracy)]
    planes = planes[kept] / norms[kept, None]
    normals, constants = planes[:, 1:], planes[:, 0]
    left, values, right = np.linalg.svd(normals)
    values = np.concatenate((values, np.zeros(len(planes))))[: len(planes)]
    rank = _rank(values, accuracy)
    sides = left.conj().T @ -constants
    if _rank(np.abs(sides[rank:]), accuracy):
        return None
    frame = np.zeros((n + 1, n + 1 - rank), complex)
    frame[0, 0] = 1
    frame[1:, 0] = right[:rank].conj().T @ (sides[:rank] / values[:rank])
    frame[1:, 1:] = right[rank:].conj().T
    return frame
