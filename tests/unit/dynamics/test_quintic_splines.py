"""Quintic splines against SciPy's, and exactly where they are exact."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.dynamics.quintic_splines import derivatives

COUNTS = [6, 7, 8, 9, 15, 16, 17, 24, 33, 100, 257]


def _times(count, rng):
    return np.cumsum(rng.uniform(0.3, 1.0, count)) / count


@pytest.mark.parametrize("count", COUNTS)
def test_they_are_those_of_scipy(count):
    interpolate = pytest.importorskip("scipy.interpolate")
    rng = np.random.default_rng(count)
    t, rows = _times(count, rng), rng.normal(size=(count, 3))
    expected = interpolate.make_interp_spline(t, rows, k=5)
    for order, found in enumerate(derivatives(t, rows), 1):
        other = expected(t, order)
        assert np.abs(found - other).max() < 1e-9 * np.abs(other).max()


@pytest.mark.parametrize("count", COUNTS)
def test_they_are_exact_for_polynomials_of_degree_five(count):
    t = _times(count, np.random.default_rng(1))
    polynomial = np.polynomial.Polynomial([1, -2, 3, 1, -4, 2])
    first, second = derivatives(t, polynomial(t)[:, None])
    assert np.allclose(first[:, 0], polynomial.deriv()(t), atol=1e-8)
    assert np.allclose(second[:, 0], polynomial.deriv(2)(t), atol=1e-5)
    assert not np.allclose(first[:, 0], polynomial.deriv()(t) + t**6, atol=1e-8)
