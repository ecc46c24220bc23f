"""Structures and target systems: validation, canonical order, balance, derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.continuation.monodromy import random_complex, random_quadrics
from gspcli.continuation.systems import Coefficients, Structure, TargetSystem


def random_coefficients(rng: np.random.Generator) -> Coefficients:
    return Coefficients(
        random_complex(rng, 6, 27), random_complex(rng, 6, 27), random_complex(rng, 6)
    )


@pytest.mark.parametrize("families", ["sssss", "ssssssx"[1:], "sssssS"])
def test_wrong_families(families):
    with pytest.raises(ValueError, match="six letters"):
        Structure(families)


def test_canonical_order():
    structure = Structure("lpsaqp", (True, True, False, False, False, False))
    assert structure.canonical() == Structure("appqls", (False, False, True, False, True, False))
    assert structure.canonical().canonical() == structure.canonical()


def test_wrong_coefficients():
    with pytest.raises(ValueError, match="g must have shape"):
        TargetSystem(Structure("ssssss"), np.zeros((6, 26)))
    with pytest.raises(ValueError, match="not finite"):
        TargetSystem(Structure("ssssss"), np.full((6, 27), np.nan))
    with pytest.raises(ValueError, match="second factors"):
        TargetSystem(Structure("pppppp", (True,) * 6), np.zeros((6, 27)))


def test_jacobians_against_differences():
    rng = np.random.default_rng(4)
    coefficients = random_coefficients(rng)
    products = np.array([True, False, True, False, False, True])
    point, step = random_complex(rng, 1, 8), 1e-6
    moved = np.repeat(point, 8, axis=0)
    plus = coefficients.values(products, moved + step * np.eye(8))
    minus = coefficients.values(products, moved - step * np.eye(8))
    expected = (plus - minus).T / (2 * step)
    np.testing.assert_allclose(coefficients.jacobians(products, point)[0], expected, atol=1e-6)


@pytest.mark.parametrize("unit", [2.0**-20, 1.0, 2.0**20])
def test_balance_undoes_the_unit_of_length(unit):
    rng = np.random.default_rng(5)
    quadrics = random_quadrics("pqlsss", rng)
    powers = np.r_[np.ones(10), np.full(16, 1 / unit), 1 / unit**2]
    zero = np.zeros(6, dtype=complex)
    plain, scale = Coefficients(quadrics, 0 * quadrics, zero).balanced()
    other, other_scale = Coefficients(quadrics * powers, 0 * quadrics, zero).balanced()
    np.testing.assert_array_equal(plain.g, other.g)
    assert other_scale == scale * unit
