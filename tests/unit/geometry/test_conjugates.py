from __future__ import annotations

import numpy as np
import pytest

from gspcli.geometry.quaternions import find_real_points, made_real, normalized


def nearest(points: np.ndarray) -> list[bool]:
    """The definition: compare the conjugate of every point with all points."""
    z = normalized(points)
    real = []
    for i, conjugate in enumerate(z.conj()):
        products = z.conj() @ conjugate
        phases = products / np.where(products == 0, 1, np.abs(products))
        distances = np.linalg.norm(conjugate - phases[:, None] * z, axis=1)
        real.append(bool(distances[i] <= distances.min()))
    return real


def random_set(rng: np.random.Generator, real: int, pairs: int, size: int) -> np.ndarray:
    """Real points and pairs of conjugates, slightly wrong, of any phase and length, shuffled."""
    x = rng.normal(size=(real, size))
    z = rng.normal(size=(pairs, size)) + 1j * rng.normal(size=(pairs, size))
    points = np.concatenate((x, z, z.conj()))
    points = points + 1e-13 * (rng.normal(size=points.shape) + 1j * rng.normal(size=points.shape))
    phases = np.exp(2j * np.pi * rng.random(len(points))) * rng.uniform(0.1, 10, len(points))
    return rng.permutation(points * phases[:, None])


def test_conjugate_pairs():
    points = np.array([[1, 1j], [1, -1j], [1, 2 + 1e-9j], [1j, 3j]])
    representatives, real = find_real_points(points)
    assert real.tolist() == [False, False, True, True]
    np.testing.assert_allclose(abs(representatives[3]), np.array([1, 3]) / np.sqrt(10))


@pytest.mark.parametrize("size", [4, 8])
@pytest.mark.parametrize("seed", range(10))
def test_random_sets_against_the_definition(size, seed):
    rng = np.random.default_rng(seed)
    points = random_set(rng, int(rng.integers(10)), int(rng.integers(10)), size)
    representatives, real = find_real_points(points)
    assert real.tolist() == nearest(points)
    assert not representatives[real].imag.any()
    np.testing.assert_allclose(np.linalg.norm(representatives, axis=1), 1, rtol=1e-14)
    overlaps = np.abs((normalized(points).conj() * representatives).sum(axis=1))
    np.testing.assert_allclose(overlaps, 1, rtol=1e-12)


def test_a_near_pair_is_not_real_and_near_real_points_are():
    rng = np.random.default_rng(3)
    x, step = rng.normal(size=8), rng.normal(size=8)
    pair = np.array([x + 1e-9j * step, x - 1e-9j * step])
    others = random_set(rng, 2, 2, 8)
    assert not find_real_points(np.concatenate((pair, others)))[1][:2].any()
    twins = np.array([x, x + 1e-9 * step]).astype(complex)
    assert find_real_points(np.concatenate((twins, others)))[1][:2].all()


def test_thousands_of_points():
    points = random_set(np.random.default_rng(5), 1000, 1500, 8)
    assert find_real_points(points)[1].sum() == 1000


def test_no_points():
    representatives, real = find_real_points(np.zeros((0, 8), complex))
    assert representatives.shape == (0, 8)
    assert real.shape == (0,)


def test_made_real():
    np.testing.assert_allclose(made_real(np.array([1j, 3j])), np.array([1, 3]) / np.sqrt(10))
