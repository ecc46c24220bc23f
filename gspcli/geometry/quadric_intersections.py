"""Intersections of n quadrics in projective n-space, n = 0, 1, 2, 3, in any position.

A quadric is a symmetric matrix Q of order n + 1, its equation ``z^T Q z = 0``. By Bezout's
theorem n quadrics meet in 2^n points counted with multiplicity, or in infinitely many. The
points come from Macaulay's matrix: the products of the quadrics with all monomials of degree
n - 1. These are forms of degree n + 1, the smallest degree in which the kernel tells both the
points and how the coordinates multiply; the joint eigenvalues of those multiplications are the
points. See D. Cox, J. Little, D. O'Shea, *Using Algebraic Geometry*, chapters 2 and 3.

`all_roots` takes one system and expects everything: multiple points and infinitely many. Systems
in general position are solved quicker by `gspcli.geometry.intersections`.
"""

from __future__ import annotations

from functools import cache
from itertools import combinations_with_replacement
from math import factorial, prod

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.quaternions import Field, normalized
from gspcli.records import dataclass

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.int64]

#: Isolated points of norm 1 that are nearer than this are one.
_SEPARATION = 1e-4
_EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class _Layout:
    """Where things stand in Macaulay's matrix of n quadrics: columns are monomials."""

    #: Column of each coefficient of a quadric times each multiplier: (multipliers, triangle).
    columns: Index
    #: For each coordinate z_i the columns of ``z_i m``, m of degree n: shape (n + 1, ...).
    products: Index
    #: Square roots of the multinomial coefficients of the columns and of the m above. With
    #: these weights unitary changes of coordinates act unitarily (Bombieri's norm).
    weights: Array
    product_weights: Array
    #: Upper triangle of a symmetric matrix, and the factor 1 or 2 of its elements.
    triangle: tuple[Index, Index]
    factor: Array


def _exponents(variables: int, degree: int) -> list[tuple[int, ...]]:
    indices = combinations_with_replacement(range(variables), degree)
    return [tuple(chosen.count(i) for i in range(variables)) for chosen in indices]


def _weight(exponents: tuple[int, ...]) -> float:
    return float(np.sqrt(factorial(sum(exponents)) / prod(map(factorial, exponents))))


@cache
def _layout(n: int) -> _Layout:
    monomials = _exponents(n + 1, n + 1)
    column = {m: i for i, m in enumerate(monomials)}
    multipliers = _exponents(n + 1, n - 1)
    below = _exponents(n + 1, n)
    triangle = np.triu_indices(n + 1)
    pairs = list(zip(*(index.tolist() for index in triangle), strict=True))

    def shifted(m: tuple[int, ...], *indices: int) -> tuple[int, ...]:
        return tuple(e + indices.count(i) for i, e in enumerate(m))

    return _Layout(
        columns=np.array([[column[shifted(m, i, j)] for i, j in pairs] for m in multipliers]),
        products=np.array([[column[shifted(m, i)] for m in below] for i in range(n + 1)]),
        weights=np.array([_weight(m) for m in monomials]),
        product_weights=np.array([_weight(m) for m in below]),
        triangle=(triangle[0], triangle[1]),
        factor=np.where(triangle[0] == triangle[1], 1.0, 2.0),
    )


def _newton_step(
    forms: Field, z: Field, accuracy: Array | float = _EPS
) -> tuple[Field, Array, Array]:
    """Return p points of norm 1 after a Newton step, its length, and the error that is left.

    The last row of the Jacobian matrix, ``conj(z)``, keeps corrections orthogonal to the point.
    The forms have norm 1, so that the step leaves at most the norm of the inverse Jacobian
    matrix times the square of its length, besides errors of the forms.
    """
    halves = np.einsum("...kij,...pj->...pki", forms, z)
    values = np.einsum("...pki,...pi->...pk", halves, z)
    matrix = np.concatenate((2 * halves, z.conj()[..., None, :]), axis=-2)
    inverse = np.linalg.inv(matrix)
    step = np.einsum("...ik,...k->...i", inverse[..., :-1], values)
    length = np.sqrt((step.real**2 + step.imag**2).sum(axis=-1))
    amplification = np.sqrt((inverse.real**2 + inverse.imag**2).sum(axis=(-2, -1)))
    return normalized(z - step), length, amplification * (length**2 + 4 * accuracy)


@dataclass(frozen=True, eq=False)
class RootSet:
    """The intersection of n quadrics in n-space.

    Attributes
    ----------
    points
        The isolated points, shape (k, n + 1), norm 1.
    multiplicity
        Of each, shape (k,).
    errors
        Estimated distance of each from the exact point, shape (k,).
    samples
        Points on positive-dimensional components, shape (m, n + 1); none if the intersection
        is finite.
    lost
        How many of the 2^n points, with multiplicity, could not be made out.
    """

    points: Complex
    multiplicity: Index
    errors: Array
    samples: Complex
    lost: int


#: Macaulay's matrix loses rank exactly when the intersection is infinite. A singular value
#: below the first number is taken for zero, one above the second for not zero.
_RANK = (1e-13, 1e-10)
#: Largest value of normalized quadrics at a point that counts as a point of theirs.
_ON = 1e-12
#: Largest estimated error of a multiple point.
_CLUSTER_ACCURACY = 1e-10
#: Radii at which eigenvalues are taken together as one multiple point, tried in turn.
_RADII = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 5e-2)


def all_roots(forms: Field, accuracy: float = _EPS) -> RootSet:
    """Return the whole intersection of n quadrics, multiple points and components included.

    Points that the accuracy of the forms cannot tell apart are one multiple point.

    Parameters
    ----------
    forms
        Symmetric matrices, none of them zero, shape (n, n + 1, n + 1); n = 0 to 3.
    accuracy
        The relative error of the forms.
    """
    n = len(forms)
    if n == 0:
        one = np.ones((1, 1), complex)
        return RootSet(one, np.ones(1, int), np.zeros(1), one[:0], 0)
    forms = forms / np.linalg.norm(forms, axis=(-2, -1), keepdims=True)
    rng = np.random.default_rng(1120)
    turn = np.linalg.qr(rng.normal(size=(n + 1, n + 1)) + 1j * rng.normal(size=(n + 1, n + 1)))[0]
    turned = turn.T @ forms @ turn
    kernel, gap = _kernel(turned)
    if gap > _RANK[1]:
        points, multiplicity, errors = _isolated(turned, kernel, rng, accuracy)
        lost = 2**n - int(multiplicity.sum())
        return RootSet(points @ turn.T, multiplicity, errors, np.zeros((0, n + 1), complex), lost)
    if gap > _RANK[0]:
        nothing = np.zeros((0, n + 1), complex)
        return RootSet(nothing, np.zeros(0, int), np.zeros(0), nothing, 2**n)
    points, errors, samples = _with_components(turned, rng, accuracy)
    multiplicity = np.ones(len(points), int)
    lost = 2**n - len(points) - len(samples)
    return RootSet(points @ turn.T, multiplicity, errors, samples @ turn.T, lost)


def _kernel(forms: Field) -> tuple[Field, float]:
    """Return a basis of the kernel of Macaulay's matrix, and the smallest singular value above.

    The basis has shape (columns, 2^n) and belongs to unweighted monomials.
    """
    n = len(forms)
    layout = _layout(n)
    coefficients = forms[:, layout.triangle[0], layout.triangle[1]] * layout.factor
    multipliers, columns = len(layout.columns), len(layout.weights)
    products: Field = np.zeros((n, multipliers, columns), complex)
    rows = np.arange(multipliers)[:, None]
    products[:, rows, layout.columns] = coefficients[:, None, :]
    matrix: Field = (products / layout.weights).reshape(-1, columns)
    matrix /= np.linalg.norm(matrix, axis=1, keepdims=True)
    _, values, right = np.linalg.svd(matrix)
    rank = columns - 2**n
    kernel: Field = right[rank:].conj().T / layout.weights[:, None]
    return kernel, float(values[rank - 1] / values[0])


def _isolated(
    forms: Field, kernel: Complex, rng: np.random.Generator, accuracy: float
) -> tuple[Complex, Index, Array]:
    """Return points, multiplicities and errors of a finite intersection."""
    n = len(forms)
    layout = _layout(n)
    below = kernel[layout.products] * layout.product_weights[:, None]
    base = below[0]
    multiplications = np.array([np.linalg.lstsq(base, part)[0] for part in below[1:]])
    weights = rng.normal(size=n) + 1j * rng.normal(size=n)
    mixed = np.einsum("k,kij->ij", weights, multiplications)
    eigenvalues, vectors = np.linalg.eig(mixed)
    found: list[tuple[Complex, int, float]] = []
    left = list(range(2**n))
    for radius in _RADII:
        for cluster in _clusters(eigenvalues, left, radius):
            if len(cluster) == 1:
                v = vectors[:, cluster[0]]
                affine = np.einsum("i,kij,j->k", v.conj(), multiplications, v)
                root = _simple(forms, affine, _gap(eigenvalues, cluster), accuracy)
            else:
                root = _multiple(forms, mixed, multiplications, eigenvalues, cluster, accuracy)
            if root is not None:
                found.append((root[0], len(cluster), root[1]))
                left = [i for i in left if i not in cluster]
    points = np.array([z for z, _, _ in found], complex).reshape(-1, n + 1)
    counts = np.array([m for _, m, _ in found], int)
    return points, counts, np.array([error for _, _, error in found], float)


def _gap(eigenvalues: Complex, cluster: list[int]) -> float:
    """Return the distance from a cluster to the other eigenvalues (at most 1)."""
    others = np.delete(eigenvalues, cluster)
    distances = np.abs(eigenvalues[cluster][:, None] - others)
    return min(1.0, float(distances.min())) if others.size else 1.0


def _clusters(eigenvalues: Complex, indices: list[int], radius: float) -> list[list[int]]:
    """Return the components of the graph of eigenvalues nearer than a relative radius."""
    clusters: list[list[int]] = []
    for i in indices:
        scale = radius * (1 + abs(eigenvalues[i]))
        near = [c for c in clusters if any(abs(eigenvalues[i] - eigenvalues[j]) < scale for j in c)]
        clusters = [c for c in clusters if c not in near] + [[i, *(j for c in near for j in c)]]
    return clusters


def _simple(
    forms: Field, affine: Complex, gap: float, accuracy: float
) -> tuple[Complex, float] | None:
    """Return a point polished by Newton's method and its error, or None if it is not simple."""
    start = normalized(np.concatenate(([1.0], affine)))
    z, error = start[None], np.inf
    try:
        for _ in range(8):
            z, step, errors = _newton_step(forms, z, accuracy)
            error = float(errors[0])
            if step[0] < 1e-15:
                break
    except np.linalg.LinAlgError:
        return None
    # Eigenvalues and points differ in scale by the norm of (1, affine), squared at most.
    room = gap / (1 + float(np.linalg.norm(affine)) ** 2)
    moved = np.sqrt(max(0.0, 1 - abs(np.vdot(z[0], start)) ** 2))
    return (z[0], error) if error < 0.02 * room and moved < 0.3 * room else None


def _multiple(
    forms: Field,
    mixed: Complex,
    multiplications: Complex,
    eigenvalues: Complex,
    cluster: list[int],
    accuracy: float,
) -> tuple[Complex, float] | None:
    """Return a multiple point as the mean over its cluster, or None if it is not one point.

    The eigenvalues of a multiple point scatter widely, but their mean is as accurate as a
    simple one. It is taken with the spectral projector, an integral over a circle.
    """
    n = len(multiplications)
    centre = eigenvalues[cluster].mean()
    inner = float(np.abs(eigenvalues[cluster] - centre).max())
    others = np.delete(eigenvalues, cluster)
    outer = min(float(np.abs(others - centre).min()), 1.0) if others.size else 1.0
    if outer < 4 * inner:
        return None
    # A wide circle: the resolvent of a multiple point grows fast towards its centre.
    circle = outer / 2 * np.exp(2j * np.pi * np.arange(64) / 64)
    resolvent = np.linalg.inv((centre + circle)[:, None, None] * np.eye(2**n) - mixed)
    projector = np.einsum("c,cij->ij", circle, resolvent) / 64
    error = float(100 * _EPS * np.linalg.norm(projector))
    # A large projector belongs to a part of a larger cluster.
    if abs(np.trace(projector) - len(cluster)) > 1e-6 or error > _CLUSTER_ACCURACY:
        return None
    affine = np.einsum("ij,kji->k", projector, multiplications) / len(cluster)
    z = normalized(np.concatenate(([1.0], affine)))
    values = np.einsum("i,kij,j->k", z, forms, z)
    if np.abs(values).max() > max(_ON, 10 * accuracy):
        return None
    return z, error + accuracy


def _with_components(
    forms: Field, rng: np.random.Generator, accuracy: float
) -> tuple[Complex, Array, Complex]:
    """Return isolated simple points, their errors, and points on the components.

    The points of a slightly different system lie near both. Those that Newton's method
    carries to a simple point of the given system are isolated; the others are moved onto it
    by the shortest correction.
    """
    n = len(forms)
    noise = rng.normal(size=forms.shape) + 1j * rng.normal(size=forms.shape)
    noise += np.swapaxes(noise, -1, -2)
    near = forms + 1e-4 * noise / np.linalg.norm(noise, axis=(-2, -1), keepdims=True)
    starts, _, _ = _isolated(near, _kernel(near)[0], rng, _EPS)
    points: list[Complex] = []
    errors: list[float] = []
    samples: list[Complex] = []
    for start in starts:
        root = _simple(forms, start[1:] / start[0], 1.0, accuracy)
        if root is not None and root[1] < 1e-9:
            if all(abs(np.vdot(root[0], z)) < 1 - _SEPARATION**2 for z in points):
                points.append(root[0])
                errors.append(root[1])
            continue
        z = start
        for _ in range(30):
            halves = forms @ z
            matrix = np.concatenate((2 * halves, z.conj()[None]))
            right = np.concatenate((halves @ z, [0]))
            z = normalized(z - np.linalg.lstsq(matrix, right, rcond=1e-6)[0])
        if np.abs(np.einsum("i,kij,j->k", z, forms, z)).max() < max(_ON, 10 * accuracy):
            samples.append(z)
    return (
        np.array(points, complex).reshape(-1, n + 1),
        np.array(errors, float),
        np.array(samples, complex).reshape(-1, n + 1),
    )
