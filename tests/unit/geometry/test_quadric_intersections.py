from __future__ import annotations

import numpy as np
import pytest

from gspcli.geometry.conjugates import find_real_points
from gspcli.geometry.intersections import generic_points
from gspcli.geometry.quadric_intersections import all_roots


def random_forms(rng: np.random.Generator, n: int, field: str, batch: int) -> np.ndarray:
    forms = rng.normal(size=(batch, n, n + 1, n + 1))
    if field == "complex":
        forms = forms + 1j * rng.normal(size=forms.shape)
    return forms + np.swapaxes(forms, -1, -2)


def quick_points(forms: np.ndarray) -> np.ndarray:
    """The points of n quadrics in n-space, as those in 3-space where all but n + 1 vanish."""
    n = len(forms)
    padded = np.zeros((1, n, 4, 4), complex)
    padded[0, :, : n + 1, : n + 1] = forms
    planes = np.eye(4)[None, None, n + 1 :]
    points, _, ok = generic_points(planes, padded, np.full(1, 1e-16), np.zeros(1, bool))
    assert ok.all()
    return points[0, 0, :, : n + 1]


def planes_product(a, b) -> np.ndarray:
    a, b = np.asarray(a, float), np.asarray(b, float)
    return (np.outer(a, b) + np.outer(b, a)) / 2


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("field", ["real", "complex"])
def test_both_methods_agree(n, field):
    for forms in random_forms(np.random.default_rng(7), n, field, 5):
        quick = quick_points(forms)
        roots = all_roots(forms)
        assert roots.lost == 0
        assert len(roots.samples) == 0
        assert (roots.multiplicity == 1).all()
        overlaps = np.abs(roots.points @ quick.conj().T)
        assert sorted(overlaps.argmax(axis=1)) == list(range(2**n))
        np.testing.assert_allclose(overlaps.max(axis=1), 1, atol=1e-12)


@pytest.mark.parametrize(
    ("offsets", "multiplicities"),
    [
        ((0, 1, 1), [2, 2, 2, 2]),
        ((0, 0, 1), [4, 4]),
        ((0, 0, 0), [8]),
    ],
)
def test_multiple_points(offsets, multiplicities):
    """Pairs of planes x_i = +-c_i in a turned frame; c_i = 0 is a double plane."""
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(4, 4)))[0]
    forms = np.zeros((3, 4, 4))
    for k, c in enumerate(offsets):
        forms[k, k, k] = 1
        forms[k, 3, 3] = -(c**2)
    roots = all_roots(turn @ forms @ turn.T)
    assert roots.lost == 0
    assert sorted(roots.multiplicity) == multiplicities
    signs = np.abs(roots.points @ turn)
    np.testing.assert_allclose(
        signs / signs[:, 3:], np.tile([*offsets, 1], (len(signs), 1)), atol=1e-10
    )


def test_tangent_conics():
    """The circle x² + y² = 1 and the line pair (x - 1)(y - x) touch at (1, 0)."""
    circle = np.diag([1.0, 1.0, -1.0])
    lines = planes_product([1, 0, -1], [-1, 1, 0])
    roots = all_roots(np.array([circle, lines]))
    assert sorted(roots.multiplicity) == [1, 1, 2]
    representatives, real = find_real_points(roots.points)
    assert real.all()
    double = representatives[roots.multiplicity == 2][0].real
    np.testing.assert_allclose(double / double[2], [1, 0, 1], atol=1e-10)


def test_near_double_points_stay_apart():
    """Two points 1e-5 apart are two points."""
    forms = np.array([np.diag([1.0, -1e-10])])
    roots = all_roots(forms)
    assert roots.multiplicity.tolist() == [1, 1]
    ratios = np.sort((roots.points[:, 0] / roots.points[:, 1]).real)
    np.testing.assert_allclose(ratios, [-1e-5, 1e-5], rtol=1e-6)


def test_a_common_line_is_a_component():
    """Three quadrics through the line x = y = 0 meet in it and, in general, in four points."""
    rng = np.random.default_rng(2)
    x, y = np.eye(4)[:2]
    forms = np.array([planes_product(x, rng.normal(size=4)) for _ in range(3)])
    forms += np.array([planes_product(y, rng.normal(size=4)) for _ in range(3)])
    roots = all_roots(forms)
    assert len(roots.samples) > 0
    assert np.abs(roots.samples[:, :2]).max() < 1e-9
    assert len(roots.points) == 4
    values = np.einsum("pi,kij,pj->pk", roots.points, forms, roots.points)
    assert np.abs(values).max() < 1e-12


def test_equal_conics_are_infinite():
    circle = np.diag([1.0, 1.0, -1.0])
    roots = all_roots(np.array([circle, 2 * circle]))
    assert len(roots.points) == 0
    assert len(roots.samples) > 0
