"""The quadrics of R, T, U, T x R and T.T against quaternions, packing, the swap."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.continuation.quadrics import (
    BASES,
    BODY_TRANSLATION,
    MOMENT,
    NORM,
    RHO,
    ROTATION,
    TRANSLATION,
    evaluate,
    gradients,
    monomials,
    pack,
    swap_letters,
    swap_points,
    swap_quadrics,
    unpack,
)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.r_[a[0] * b[0] - a[1:] @ b[1:], vector]


def conjugate(a: np.ndarray) -> np.ndarray:
    return a * [1, -1, -1, -1]


@pytest.fixture
def point() -> np.ndarray:
    rng = np.random.default_rng(1)
    e, f = rng.standard_normal((2, 4))
    return np.r_[e, f - e * (e @ f) / (e @ e)]


def test_functions_of_the_motion(point):
    e, f = point[:4], point[4:]
    n = e @ e
    columns = [product(product(e, np.r_[0, v]), conjugate(e))[1:] / n for v in np.eye(3)]
    r, t = np.array(columns).T, 2 * product(f, conjugate(e))[1:] / n
    np.testing.assert_allclose(r.T @ r, np.eye(3), atol=1e-14)
    m = monomials(point) / n
    for forms, values in (
        (NORM, 1.0),
        (ROTATION, r),
        (TRANSLATION, t),
        (BODY_TRANSLATION, r.T @ t),
        (MOMENT, np.cross(t[:, None], r, axis=0)),
        (RHO, t @ t),
    ):
        np.testing.assert_allclose(forms @ m, values, atol=1e-13)


def test_dimensions_of_the_spaces():
    ranks = {letter: np.linalg.matrix_rank(basis) for letter, basis in BASES.items()}
    assert ranks == {"a": 10, "p": 13, "q": 13, "l": 19, "s": 17}


def test_pack_and_unpack():
    q = np.random.default_rng(2).standard_normal((3, 27))
    np.testing.assert_allclose(pack(*unpack(q)), q, atol=1e-15)


def test_gradients_against_differences(point):
    q = np.random.default_rng(3).standard_normal((5, 27))
    step = 1e-20
    shifted = point + 1j * step * np.eye(8)
    expected = evaluate(q, shifted).imag.T / step
    np.testing.assert_allclose(gradients(q, point[None])[0], expected, atol=1e-13)


def test_swap_is_the_inverse_motion(point):
    m, swapped = monomials(point), monomials(swap_points(point))
    np.testing.assert_allclose(ROTATION @ swapped, (ROTATION @ m).T, atol=1e-14)
    np.testing.assert_allclose(TRANSLATION @ swapped, -BODY_TRANSLATION @ m, atol=1e-14)
    for letter, basis in BASES.items():
        other = BASES[swap_letters(letter)]
        together = np.vstack([swap_quadrics(basis), other])
        assert np.linalg.matrix_rank(together) == len(other)
        np.testing.assert_allclose(swap_quadrics(basis) @ m, basis @ swapped, atol=1e-13)
