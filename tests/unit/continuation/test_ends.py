"""Telling ends apart, and finite ones from those at infinity."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.continuation.ends import clusters, distances, infinite, may_coincide, regular_error


def random_points(count: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    points = rng.standard_normal((count, 8)) + 1j * rng.standard_normal((count, 8))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def test_a_longer_correction_is_a_larger_error():
    error = regular_error(np.array([0.0, 1e-15, 1e-10]))
    assert (np.diff(error) > 0).all()
    assert error[0] > 0


@pytest.mark.parametrize(("n", "is_infinite"), [(0.0, True), (1e-12, True), (1e-6, False)])
def test_infinite_is_zero_within_the_error(n, is_infinite):
    # e.e = n with |e| about one half.
    e = np.array([0.5, 0.5j * np.sqrt(1 - 4 * n), 0, 0])
    point = np.concatenate([e, [np.sqrt(0.5), 0, 0, 0]])
    assert infinite(point, np.array(1e-9)) == is_infinite


def test_far_away_is_not_infinite():
    """N = |e|^2 is small because e is, not because it cancels."""
    point = np.array([1e-7, 0, 0, 0, 0, 1, 0, 0], dtype=complex)
    assert not infinite(point, np.array(1e-9))


def test_distances_do_not_depend_on_the_phase_and_keep_small_angles():
    point, across = random_points(2, 1)
    across = across - point * (point.conj() @ across)
    across /= np.linalg.norm(across)
    angles = np.array([0.0, 1e-12, 1e-5, 0.5])
    turned = np.exp(0.7j) * (np.outer(np.cos(angles), point) + np.outer(np.sin(angles), across))
    np.testing.assert_allclose(distances(turned, point), np.sin(angles), rtol=1e-3, atol=1e-15)


def test_same_points_are_neighbours():
    points = random_points(5, 2)
    points[3] = points[0] * np.exp(2j)
    order, near = may_coincide(points[None], np.full((1, 5), 1e-10))
    pairs = {frozenset(order[0, i : i + 2].tolist()) for i in np.flatnonzero(near[0])}
    assert frozenset((0, 3)) in pairs


def test_clusters_are_what_is_the_same_within_its_error():
    points = random_points(6, 3)
    points[4] = points[1] * 1j
    points[5] = points[1] + 1e-9
    groups = {tuple(group) for group in clusters(points, np.full(6, 1e-12))}
    assert groups == {(0,), (1, 4), (2,), (3,), (5,)}
    groups = {tuple(group) for group in clusters(points, np.full(6, 1e-7))}
    assert groups == {(0,), (1, 4, 5), (2,), (3,)}


def test_equal_keys_are_not_enough():
    """Two points with one invariant are compared themselves."""
    key = np.exp(1j * np.arange(8) ** 2) / np.sqrt(8)
    first, second = (np.linalg.qr(np.c_[key.conj(), p])[0][:, 1] for p in random_points(2, 4))
    groups = clusters(np.array([first, second]), np.full(2, 1e-9))
    assert sorted(map(len, groups)) == [1, 1]
