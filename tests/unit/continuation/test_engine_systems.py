"""Structures and target systems: validation, canonical order, balance, derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.continuation.quadrics import random_complex, random_quadrics
from gspcli.continuation.systems import Coefficients, Structure, System


def random_coefficients(rng: np.random.Generator) -> Coefficients:
    return Coefficients(
        random_complex(rng, 6, 27), random_complex(rng, 6, 27), random_complex(rng, 6)
    )


@pytest.mark.parametrize("spaces", ["sssss", "ssssssx"[1:], "sssssS"])
def test_wrong_spaces(spaces):
    with pytest.raises(ValueError, match="six letters"):
        Structure(spaces)


def test_canonical_order():
    structure = Structure("lpsaqp", (True, True, False, False, False, False))
    assert structure.canonical() == Structure("appqls", (False, False, True, False, True, False))
    assert structure.canonical().canonical() == structure.canonical()


def test_wrong_coefficients():
    with pytest.raises(ValueError, match="g must have shape"):
        System.of(Structure("ssssss"), np.zeros((6, 26)))
    with pytest.raises(ValueError, match="not finite"):
        System.of(Structure("ssssss"), np.full((6, 27), np.nan))
    with pytest.raises(ValueError, match="second factors"):
        System.of(Structure("pppppp", (True,) * 6), np.zeros((6, 27)))


def test_jacobians_against_differences():
    rng = np.random.default_rng(4)
    structure = Structure("ssssss", (True, False, True, False, False, True))
    system = System(structure, random_coefficients(rng))
    point, step = random_complex(rng, 1, 8), 1e-6
    moved = np.repeat(point, 8, axis=0)
    plus = system.values(moved + step * np.eye(8))
    minus = system.values(moved - step * np.eye(8))
    expected = (plus - minus).T / (2 * step)
    np.testing.assert_allclose(system.jacobians(point)[0], expected, atol=1e-6)


def test_bends_against_differences():
    rng = np.random.default_rng(9)
    structure = Structure("ssssss", (True, False, True, False, False, True))
    system = System(structure, random_coefficients(rng))
    point, step = random_complex(rng, 2, 3, 8)
    h = 1e-4
    there, here, back = (system.values(point + s * step) for s in (h, 0, -h))
    expected = (there - 2 * here + back) / (2 * h * h)
    np.testing.assert_allclose(system.bends(point, step), expected, rtol=1e-5)


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
