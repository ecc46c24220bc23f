"""Where the platform can be once its orientation is known (Propositions 6.4, 6.5 and 6.7).

With the rotation fixed, each distance constraint keeps the translation T on a surface: DPH, DHP
and DLL on a plane or two parallel ones, DPP on a sphere, DPL and DLP on a circular cylinder,
and so does DLL when its lines are parallel. Three such surfaces meet in 2^m points, m of them
being quadrics once the differences of spheres have been replaced by planes.

Surfaces are forms in X = (1, T): a plane is a vector of length 4, a quadric a symmetric matrix of
order 4. Lengths should be of order one and the points near the origin.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.poses import Field, apply, cross, dot, normalised
from gspcli.geometry.quadrics import all_roots, generic_roots
from gspcli.geometry.residuals import Arrangement

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
        Forms of the planes for the distance zero, unit normals, shape (f, k, 4).
    distances
        Distances of the planes, shape (f, k) or (k,).
    signs
        The combinations of sides asked for, shape (s, k): ``form . X = sign distance``.
    quadrics
        The m quadrics, spheres first, shape (f, m, 4, 4).
    spheres
        How many of them are spheres.
    skewness
        Least squared sine, in absolute value, of line pairs that give planes, shape (f,).
    """

    planes: Field
    distances: Array
    signs: Array
    quadrics: Field
    spheres: int
    skewness: Array


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


@cache
def _signs(free: tuple[bool, ...], fixed: tuple[int, ...]) -> Array:
    choices = [(1, -1) if f else (s,) for f, s in zip(free, fixed, strict=True)]
    return np.array(list(product(*choices)), float)


def signs_of(arrangement: Arrangement, planes: list[int]) -> Array:
    """Return the sign combinations of some plane constraints, shape (s, k).

    A line-line distance has both signs, a distance to a plane those of its sides; a distance
    of zero has one.
    """
    sides = [int(arrangement.signs[i]) for i in planes]
    free = tuple(s == 0 and arrangement.values[i] != 0 for i, s in zip(planes, sides, strict=True))
    return _signs(free, tuple(s or 1 for s in sides))


def surfaces(
    arrangement: Arrangement,
    R: Field,
    distances: Array | None = None,
    parallel: Collection[int] = (),
) -> Surfaces:
    """Return the surfaces for rotations R, shape (f, 3, 3).

    Parameters
    ----------
    arrangement
        The geometry.
    R
        Real or complex rotations.
    distances
        The distances for each rotation, shape (f, d); those of the arrangement if None.
    parallel
        Line-line distances whose lines are parallel at these rotations.
    """
    indices = list(arrangement.distances)
    d = arrangement.values[indices] if distances is None else distances
    turned = np.swapaxes(R, -1, -2)
    p = arrangement.x[indices] - arrangement.y[indices] @ turned
    w = arrangement.u[indices] @ turned
    v = arrangement.v
    planes: list[tuple[int, Field]] = []
    spheres: list[int] = []
    cylinders: list[tuple[int, Field]] = []
    skewness = np.ones(len(R))
    for j, i in enumerate(indices):
        kind = arrangement.kinds[i]
        if kind is DPH:
            planes.append((j, np.broadcast_to(v[i], p[:, j].shape)))
        elif kind is DHP:
            planes.append((j, -w[:, j]))
        elif kind is DPP:
            spheres.append(j)
        elif i in parallel and arrangement.values[i] == 0:
            # One line on the other: two planes, not the cylinder of radius zero about them.
            across = np.linalg.svd(v[i : i + 1])[2][1:]
            planes += [(j, np.broadcast_to(a, p[:, j].shape)) for a in across]
        elif kind is DPL or i in parallel:
            cylinders.append((j, np.broadcast_to(v[i], p[:, j].shape)))
        elif kind is DLP:
            cylinders.append((j, w[:, j]))
        elif kind is DLL:
            normal = cross(w[:, j], np.broadcast_to(v[i], p[:, j].shape))
            square = dot(normal, normal)
            skewness = np.minimum(skewness, np.abs(square))
            length = np.sqrt(np.where(square == 0, 1.0, square))
            planes.append((j, normal / length[:, None]))
    chosen = [j for j, _ in planes]
    normals = [normal for _, normal in planes]
    forms = np.zeros((len(R), len(planes), 4), R.dtype)
    if planes:
        forms[..., 1:] = np.stack(normals, axis=1)
        forms[..., 0] = -dot(forms[..., 1:], p[:, chosen])
    curved = spheres + [j for j, _ in cylinders]
    quadrics = np.zeros((len(R), len(curved), 4, 4), R.dtype)
    if curved:
        block = quadrics[..., 1:, 1:]
        block += np.eye(3)
        if cylinders:
            axes = np.stack([axis for _, axis in cylinders], axis=1)
            block[:, len(spheres) :] -= axes[..., :, None] * axes[..., None, :]
        linear = -apply(block, p[:, curved])
        quadrics[..., 0, 1:] = quadrics[..., 1:, 0] = linear
        quadrics[..., 0, 0] = -dot(linear, p[:, curved]) - d[..., curved] ** 2
    return Surfaces(
        planes=forms,
        distances=d[..., chosen],
        signs=signs_of(arrangement, [indices[j] for j in chosen]),
        quadrics=quadrics,
        spheres=len(spheres),
        skewness=skewness,
    )


@cache
def _directions() -> Array:
    """Return fixed vectors without special position, shape (4, 4)."""
    return np.linalg.qr(np.random.default_rng(64).normal(size=(4, 4)))[0]


@np.errstate(all="ignore")
def generic_positions(given: Surfaces) -> tuple[Field, Array, NDArray[np.bool_]]:
    """Return the intersection points of surfaces in general position.

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
    linear[..., 0] -= given.signs * given.distances[..., None, :]
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
        points, errors, ok = generic_roots(quadrics)
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
            across[:, :, None] @ quadrics[:, None] @ basis[:, :, None]
        )
        X = _corrected(linear, quadrics, points @ across)
    except np.linalg.LinAlgError:
        # Exactly singular somewhere: planes are parallel or surfaces touch.
        shape = (f, s, 2 ** quadrics.shape[1])
        return np.full((*shape, 4), np.nan), np.full(shape, np.inf), np.zeros((f, s), bool)
    return X, (errors + _EPS) * size[..., None], ok & sound & (size < _KERNEL)


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
        The isolated points T, shape (k, 3).
    multiplicity
        Of each, shape (k,).
    samples
        Some points T of positive-dimensional components, shape (m, 3).
    infinite
        Whether there are such components at finite distance.
    lost
        How many points, with multiplicity, could not be made out.
    """

    points: Complex
    multiplicity: Index
    samples: Complex
    infinite: bool
    lost: int


#: Relative singular values below the first number count as zero, above the second as not.
_RANK = (1e-12, 1e-9)
#: Points with a smaller first coordinate (of norm one) are at infinity.
_INFINITY = 1e-12


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
    no_counts = np.zeros(0, int)
    try:
        reduced = _reduced(planes.astype(complex), quadrics.astype(complex), accuracy)
    except _UndecidedError:
        return Intersection(nothing, no_counts, nothing, False, 2 ** len(quadrics))
    if reduced is None:
        return Intersection(nothing, no_counts, nothing, False, 0)
    frame, forms = reduced
    free = frame.shape[1] - 1 - len(forms)
    if free:
        # More unknowns than equations: sections with random planes give samples.
        cut = np.random.default_rng(free).normal(size=(frame.shape[1], len(forms) + 1))
        cut[0] = np.eye(len(forms) + 1)[0]
        roots = all_roots(cut.T @ forms @ cut)
        points, _ = _finite(frame @ cut, roots.points, roots.errors)
        return Intersection(nothing, no_counts, points, True, 0)
    roots = all_roots(forms, accuracy)
    points, finite = _finite(frame, roots.points, roots.errors)
    samples, _ = _finite(frame, roots.samples, np.full(len(roots.samples), _EPS))
    return Intersection(points, roots.multiplicity[finite], samples, len(samples) > 0, roots.lost)


def _finite(frame: Complex, z: Complex, errors: Array) -> tuple[Complex, NDArray[np.bool_]]:
    """Return the points T of those z that are at finite distance, and which these are."""
    finite = np.abs(z[:, 0]) > np.maximum(_INFINITY, 100 * errors)
    X = z[finite] @ frame.T
    return X[:, 1:] / X[:, :1], finite


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
