"""What is taken of equal numbers, and of equal directions, must not depend on rounding errors."""

import numpy as np
import pytest

from gspcli.ties import (
    ascending,
    definite_basis,
    definite_pairs,
    definite_sign,
    definite_vectors,
    first_largest,
    first_smallest,
)

SHAKES = (0, 1e-16, 1e-14, 1e-12, 3e-11)


def shaken(array, size, seed):
    return array + size * np.random.default_rng(seed).normal(size=array.shape)


@pytest.mark.parametrize("size", SHAKES)
def test_the_first_of_equal_numbers_is_taken(size):
    given = np.array([[1.0, 3.0, 3.0, -3.0], [5.0, 2.0, 5.0, 5.0], [-1.0, -1.0, -1.0, -2.0]])
    for seed in range(20):
        numbers = shaken(given, size, seed)
        assert first_largest(numbers).tolist() == [1, 0, 0]
        assert first_smallest(numbers).tolist() == [3, 1, 3]


def test_numbers_that_differ_are_told_apart():
    assert first_largest([1.0, 1 + 1e-8]) == 1
    assert first_smallest([1.0, 1 - 1e-8]) == 1
    assert first_largest([-2.0, -1.0]) == 1


def test_infinite_numbers_are_compared():
    assert first_largest([1.0, np.inf, np.inf]) == 1
    assert first_largest([-np.inf, -np.inf]) == 0
    assert first_smallest([np.inf, 4.0, 4.0]) == 1


def test_a_sign_is_that_of_the_first_largest_entry():
    vector = np.array([0.1, -0.7, 0.7, 0.1])
    for size in SHAKES:
        for sign in (1, -1):
            assert definite_sign(shaken(sign * vector, size, 1))[1] > 0
    assert definite_sign(np.zeros(3)).tolist() == [0, 0, 0]


def test_a_complex_vector_is_turned_by_a_phase():
    vector = np.array([1 + 2j, 0.3, -1j])
    turned = [definite_sign(np.exp(1j * angle) * vector) for angle in (0, 1, 2, 4)]
    assert np.allclose(turned, turned[0], atol=1e-14)
    assert turned[0][0] == pytest.approx(5**0.5)


@pytest.mark.parametrize("part", [1.0, 1j])
@pytest.mark.parametrize("size", [1, 2, 3])
def test_a_basis_depends_on_the_space_alone(size, part):
    rng = np.random.default_rng(size)
    basis = np.linalg.qr(rng.normal(size=(6, size)) + part * rng.normal(size=(6, size)))[0]
    found = definite_basis(basis)
    assert np.allclose(found.conj().T @ found, np.eye(size), atol=1e-14)
    assert np.allclose(found @ found.conj().T, basis @ basis.conj().T, atol=1e-14)
    turn = np.linalg.qr(rng.normal(size=(size, size)))[0]
    assert np.allclose(definite_basis(basis @ turn), found, atol=1e-12)


def test_an_empty_basis_stays_empty():
    assert definite_basis(np.zeros((8, 0))).shape == (8, 0)


@pytest.mark.parametrize("size", SHAKES)
def test_vectors_of_equal_values_do_not_depend_on_rounding(size):
    rng = np.random.default_rng(3)
    axes = np.linalg.qr(rng.normal(size=(5, 5)))[0]
    matrix = axes @ np.diag([1.0, 1.0, 2.0, 3.0, 3.0]) @ axes.T
    first = definite_vectors(*np.linalg.eigh(matrix))
    other = shaken(matrix, size, 4)
    again = definite_vectors(*np.linalg.eigh((other + other.T) / 2))
    assert np.abs(again - first).max() < 1e3 * size + 1e-12


@pytest.mark.parametrize("size", SHAKES)
def test_pairs_of_equal_singular_values_do_not_depend_on_rounding(size):
    rng = np.random.default_rng(5)
    first, second = (np.linalg.qr(rng.normal(size=(6, 6)))[0] for _ in range(2))
    matrix = first @ np.diag([3.0, 3.0, 3.0, 2.0, 1.0, 1.0]) @ second
    matrices = np.stack([matrix, shaken(matrix, size, 6), rng.normal(size=(6, 6))])
    u, s, vt = np.linalg.svd(matrices)
    a, b = definite_pairs(u, s, vt)
    assert np.allclose(a * s[:, None] @ b, matrices, atol=1e-8)
    assert np.allclose(np.linalg.det(a) * np.linalg.det(b), np.linalg.det(u) * np.linalg.det(vt))
    assert np.abs(a[0][:, [0, 1, 2, 4, 5]] - a[1][:, [0, 1, 2, 4, 5]]).max() < 1e3 * size + 1e-12
    assert (a[2] == u[2]).all()


def test_of_numbers_equal_to_the_least_the_first_comes_first() -> None:
    """And those that are greater by more stay in their order, however near they are."""
    assert ascending([3.0, 1 + 1e-12, np.inf, 1.0, 1 + 1e-6]).tolist() == [1, 3, 4, 0, 2]
    assert ascending([2.0, 1 + 1e-6, 1.0], 1e-5).tolist() == [1, 2, 0]
    assert ascending([]).tolist() == []
