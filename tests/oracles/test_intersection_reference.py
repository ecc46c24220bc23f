"""The native intersections against the same mathematics written plainly in NumPy.

Macaulay's matrix as a whole instead of by blocks, LAPACK's eigenvectors instead of our own.
"""

from __future__ import annotations

from itertools import combinations_with_replacement, product

import numpy as np
import pytest

from gspcli import _kernel


def reference(planes: np.ndarray, quadrics: np.ndarray) -> np.ndarray:
    """Return the points of k planes (k, 4) and n = 3 - k quadrics (n, 4, 4), norm 1."""
    n = len(quadrics)
    basis = np.linalg.svd(planes)[2][len(planes) :].conj().T if len(planes) else np.eye(4)
    basis = basis @ np.linalg.qr(np.random.default_rng(n).normal(size=(n + 1, n + 1)))[0]
    if not n:
        return basis.T
    forms = basis.T @ quadrics @ basis
    degree = n + 1

    def exponents(indices) -> tuple[int, ...]:
        return tuple(indices.count(i) for i in range(n + 1))

    monomials = [exponents(m) for m in combinations_with_replacement(range(n + 1), degree)]
    # A basis modulo the quadrics: everything at most linear in each coordinate but the first.
    kept = [m for m in monomials if max(m[1:]) <= 1]
    columns = [m for m in monomials if max(m[1:]) > 1] + kept
    rows = []
    for m in columns[: -len(kept)]:
        leader = next(i for i in range(1, n + 1) if m[i] > 1)
        row = np.zeros(len(columns), complex)
        for i, j in product(range(n + 1), repeat=2):
            image = list(m)
            image[leader] -= 2
            image[i] += 1
            image[j] += 1
            row[columns.index(tuple(image))] += forms[leader - 1, i, j]
        rows.append(row)
    matrix = np.array(rows)
    size = len(rows)
    reduced = np.vstack((-np.linalg.solve(matrix[:, :size], matrix[:, size:]), np.eye(len(kept))))
    images = [columns.index((m[0] - 1, m[1] + 1, *m[2:])) for m in kept]
    vectors = np.linalg.eig(reduced[images])[1]
    linear = [kept.index(exponents([0] * n + [i])) for i in range(n + 1)]
    points = vectors[linear].T @ basis.T
    return points / np.linalg.norm(points, axis=1, keepdims=True)


@pytest.mark.parametrize("k", [0, 1, 2, 3])
@pytest.mark.parametrize("field", ["real", "complex"])
def test_intersections_against_reference(k, field):
    rng = np.random.default_rng(k)
    planes = rng.normal(size=(25, k, 4)).astype(complex)
    quadrics = rng.normal(size=(25, 3 - k, 4, 4)).astype(complex)
    if field == "complex":
        planes += 1j * rng.normal(size=planes.shape)
        quadrics += 1j * rng.normal(size=quadrics.shape)
    quadrics += quadrics.swapaxes(-1, -2)
    points, _, ok = _kernel.intersect(
        planes[:, None], quadrics, np.full(25, 1e-16), np.full(25, field == "real")
    )
    assert ok.all()
    for p, q, found in zip(planes, quadrics, points[:, 0], strict=True):
        overlaps = np.abs(reference(p, q).conj() @ found.T)
        assert sorted(overlaps.argmax(axis=1)) == list(range(2 ** (3 - k)))
        np.testing.assert_allclose(overlaps.max(axis=1), 1, atol=1e-10)


def test_the_same_when_a_coefficient_is_wrong_is_noticed():
    rng = np.random.default_rng(5)
    quadrics = rng.normal(size=(3, 4, 4))
    quadrics += quadrics.swapaxes(-1, -2)
    wrong = quadrics.copy()
    wrong[1, 2, 3] = wrong[1, 3, 2] = quadrics[1, 2, 3] * (1 + 1e-6)
    points, _, _ = _kernel.intersect(
        np.zeros((1, 1, 0, 4)), wrong[None], np.full(1, 1e-16), np.ones(1, bool)
    )
    overlaps = np.abs(reference(np.zeros((0, 4)), quadrics).conj() @ points[0, 0].T)
    assert (overlaps.max(axis=1) < 1 - 1e-14).any()
