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

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DPH, DPP, Kind
from gspcli.geometry.measures import Measures
from gspcli.geometry.poses import Field, dot, normalised
from gspcli.geometry.quadrics import all_roots, generic_roots

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.int64]

_EPS = float(np.finfo(float).eps)
#: Kernel bases that are worse conditioned than this are left to `intersection`.
_KERNEL = 1e4
#: And so are spheres that differ by less than this.
_DIFFERENCE = 1e-4


@dataclass(frozen=True, eq=False)
class Surfaces:
    """The surfaces of one structure for many rotations; f counts the rotations.

    Attributes
    ----------
    planes
        Forms of the planes for the distance zero, shape (f, k, 4).
    offsets
        What a distance adds to their first coefficient, shape (f, k).
    signs
        The combinations of sides asked for, shape (s, k): ``form . X = sign offset s``.
    quadrics
        The m quadrics, spheres first, shape (f, m, 4, 4).
    spheres
        How many of them are spheres.
    skewness
        Least squared sine, in absolute value, of line pairs that give planes, shape (f,).
    basis
        The basis of the f, shape (f, 4, 3).
    frame
        ``T = frame t / s``, shape (f, 3, 3).
    """

    planes: Field
    offsets: Field
    signs: Array
    quadrics: Field
    spheres: int
    skewness: Array
    basis: Field
    frame: Field


def surface_counts(kinds: Collection[Kind]) -> tuple[int, int, int]:
    """Return how many distances are planes, spheres and cylinders in general (Prop. 6.4)."""
    letters = [_letter(kind) for kind in kinds if kind.is_distance]
    return letters.count("P"), letters.count("S"), letters.count("C")


def _letter(kind: Kind) -> str:
    return "P" if kind in (DPH, DHP, DLL) else "S" if kind is DPP else "C"


def intersection_number(planes: int, spheres: int, cylinders: int) -> int:
    """Return in how many points three surfaces meet in general (Proposition 6.7)."""
    del planes
    return int(2 ** (min(spheres, 1) + cylinders))


def surfaces(given: Measures, e: Field, distances: Array) -> Surfaces:
    """Return the surfaces at rotations.

    Parameters
    ----------
    given
        What the distances measure.
    e
        Quaternions of norm 1, real or complex, shape (f, 4).
    distances
        The distances for each rotation, shape (f, d).
    """
    basis = _basis(e, given.basis)
    forms = (e @ given.stacked).reshape(len(e), given.stacked.shape[1] // 8, 8)
    linear = np.empty((*forms.shape[:2], 4), e.dtype)
    linear[..., 0] = (forms[..., :4] @ e[..., None])[..., 0]
    linear[..., 1:] = forms[..., 4:] @ basis
    norm = dot(e, e)
    k, m, c = len(given.heights), len(given.squares), len(given.axial)
    offsets = distances[:, given.flat] * norm[:, None]
    skewness = np.ones(len(e))
    if given.skew:
        normals = linear[:, k + m + c : -3, 0].reshape(len(e), len(given.skew), 3)
        square = dot(normals, normals)
        offsets[:, given.skew] *= np.sqrt(square) / norm[:, None]
        skewness = np.abs(square / norm[:, None] ** 2).min(axis=1)
    quadrics = np.empty((len(e), m, 4, 4), e.dtype)
    if m:
        squares = linear[:, k : k + m]
        quadrics[..., 1:, 1:] = 4 * (np.swapaxes(basis, -1, -2) @ basis)[:, None]
        quadrics[..., 0, 1:] = quadrics[..., 1:, 0] = squares[..., 1:] / 2
        quadrics[..., 0, 0] = squares[..., 0] - distances[:, given.curved] ** 2 * norm[:, None]
    if c:
        axial = linear[:, k + m : k + m + c]
        quadrics[:, m - c :] *= norm[:, None, None, None]
        quadrics[:, m - c :] -= axial[..., :, None] * axial[..., None, :]
    return Surfaces(
        planes=linear[:, :k],
        offsets=offsets,
        signs=given.signs,
        quadrics=quadrics,
        spheres=given.spheres,
        skewness=skewness,
        basis=basis,
        frame=linear[:, -3:, 1:] / norm[:, None, None],
    )


def _basis(e: Field, forms: Array | None) -> Field:
    """Return a basis of the f with ``e.f = 0`` for each quaternion, shape (f, 4, 3).

    With the forms of T (or U) its coordinates are those of T (or U). Else it is orthogonal in
    the Hermitian sense, so that it stays sound where N vanishes and T is infinite.
    """
    basis: Field
    if forms is not None:
        basis = np.swapaxes((e @ forms.transpose(1, 0, 2).reshape(4, 12)).reshape(-1, 3, 4), 1, 2)
        return basis / 4
    # A reflection that takes the first unit vector into a multiple of conj(e).
    mirror = e.conj().copy()  # conj() returns real arrays themselves
    size = np.abs(mirror[:, 0])
    mirror[:, 0] += np.where(size == 0, 1, mirror[:, 0] / np.where(size == 0, 1, size))
    scale = (mirror.real**2 + mirror.imag**2).sum(axis=1)[:, None, None]
    basis = np.eye(4)[:, 1:] - 2 / scale * mirror[:, :, None] * mirror[:, None, 1:].conj()
    return basis / 2


@cache
def _directions() -> Array:
    """Return fixed vectors without special position, shape (4, 4)."""
    return np.linalg.qr(np.random.default_rng(64).normal(size=(4, 4)))[0]


@np.errstate(all="ignore")
def generic_positions(given: Surfaces, accuracy: Array) -> tuple[Field, Array, NDArray[np.bool_]]:
    """Return the intersection points of surfaces in general position.

    Parameters
    ----------
    given
        The surfaces.
    accuracy
        The relative error of their forms, shape (f,).

    Returns
    -------
    points
        Forms X of norm 1, shape (f, s, 2^m, 4): rotations, sign combinations, points. Real
        rotations give points that are exactly real or in exactly conjugate pairs.
    errors
        Their estimated errors, shape (f, s, 2^m).
    ok
        Which of the systems have been solved, shape (f, s).
    """
    f, s = len(given.planes), len(given.signs)
    k = given.planes.shape[1]
    linear = np.repeat(given.planes[:, None], s, axis=1)
    linear[..., 0] -= given.signs * given.offsets[:, None]
    quadrics = given.quadrics
    if given.spheres > 1:
        # Spheres differ by the plane of their common circle.
        difference = quadrics[:, 1 : given.spheres, 0] - quadrics[:, :1, 0]
        difference[..., 1:] *= 2
        difference = difference[:, None].repeat(s, axis=1)
        linear = np.concatenate((linear, difference), axis=2)
        quadrics = np.concatenate((quadrics[:, :1], quadrics[:, given.spheres :]), axis=1)
        k = linear.shape[2]
    if k == 0:
        points, errors, ok = generic_roots(quadrics, accuracy[:, None])
        return points[:, None], errors[:, None], ok[:, None]
    # Spheres that nearly coincide leave a plane that is mostly rounding error.
    sound = (np.abs(linear).max(axis=-1) > _DIFFERENCE).all(axis=-1)
    linear = normalised(linear)
    bordered = np.empty((f, s, 4, 4), linear.dtype)
    bordered[..., :k, :] = linear
    bordered[..., k:, :] = _directions()[k:]
    try:
        inverse = np.linalg.inv(bordered)
        size = np.sqrt((np.abs(inverse) ** 2).sum(axis=(-2, -1)))
        basis = inverse[..., k:] / size[..., None, None]
        across = np.swapaxes(basis, -1, -2)
        points, errors, ok = generic_roots(
            across[:, :, None] @ quadrics[:, None] @ basis[:, :, None], accuracy[:, None, None]
        )
        X = _corrected(linear, quadrics, points @ across)
    except np.linalg.LinAlgError:
        # Exactly singular somewhere: planes are parallel or surfaces touch.
        shape = (f, s, 2 ** quadrics.shape[1])
        return np.full((*shape, 4), np.nan), np.full(shape, np.inf), np.zeros((f, s), bool)
    return X, (errors + accuracy[:, None, None]) * size[..., None], ok & sound & (size < _KERNEL)


def _corrected(linear: Field, quadrics: Field, X: Field) -> Field:
    """Return points after one Newton step on the planes and quadrics themselves, norm 1.

    The basis in which the points were found may be ill-conditioned; the step repairs that.
    """
    X = normalised(X)
    k = linear.shape[2]
    halves = np.einsum("fmij,fspj->fspmi", quadrics, X)
    matrix = np.empty((*X.shape, 4), X.dtype)
    matrix[..., :k, :] = linear[:, :, None]
    matrix[..., k:3, :] = 2 * halves
    matrix[..., 3, :] = X.conj()
    values = np.zeros((*X.shape, 1), X.dtype)
    values[..., :k, 0] = X @ np.swapaxes(linear, -1, -2)
    values[..., k:3, 0] = np.einsum("fspmi,fspi->fspm", halves, X)
    return normalised(X - np.linalg.solve(matrix, values)[..., 0])


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
        distant=normalised(roots.points[~finite & simple] @ frame.T),
        samples=_affine(frame, samples),
        infinite=len(samples) > 0,
        lost=roots.lost + int(roots.multiplicity[lost].sum()),
    )


def certainly_not_zero(coordinate: Field, errors: Array) -> NDArray[np.bool_]:
    """Return which coordinates of points of norm one differ from zero beyond doubt.

    The others are examined in extended precision (`gspcli.solve.infinity`).
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
