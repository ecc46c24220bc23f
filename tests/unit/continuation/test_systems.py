"""Structures and target systems: validation, canonical order, balance, derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.catalogue.kinds import DPP
from gspcli.continuation.quadrics import (
    BASES,
    NORM,
    evaluate,
    gradients,
    monomials,
    pack,
    random_complex,
    random_quadrics,
    swap_letters,
    swap_points,
    swap_quadrics,
    unpack,
)
from gspcli.continuation.reduced_homotopy import Balance, ReducedHomotopy
from gspcli.continuation.systems import Coefficients, Structure, System
from gspcli.solver.study_systems import coefficients_of
from tests.support.study_forms import BODY_TRANSLATION, MOMENT, RHO, ROTATION, TRANSLATION


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


# The quadrics of R, T, U, T x R and T.T against quaternions, packing, the swap.


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


# Combinations of quadrics that are nearly dependent.


#: Coefficients of N, and one of e.f for each.
SQUARES, PRODUCTS = [0, 4, 7, 9], [10, 15, 20, 25]


def similar(digits, ratio=0.7, turn=0.3):
    """Return the quadrics of a hexapod with similar plates, rounded to some digits."""
    angles = np.radians([50, 70, 170, 190, 290, 310])
    x = np.stack((np.cos(angles), np.sin(angles), 0 * angles), axis=1)
    y = ratio * np.stack((np.cos(angles + turn), np.sin(angles + turn), 0 * angles), axis=1)
    none = np.zeros((6, 3))
    bodies = (DPP,) * 6, y.round(digits), x.round(digits), none, none
    return coefficients_of(*bodies, np.zeros((1, 6)))[1].g[0].real


@pytest.mark.parametrize("digits", [3, 5, 8, 11])
def test_combinations_of_nearly_dependent_quadrics_are_of_order_one(digits):
    quadrics = similar(digits)
    balance = Balance.of(quadrics)
    # One combination is as small as what was rounded.
    assert 10.0 ** -(digits + 3) < balance.sizes[-1] < 10.0 ** -(digits - 1)
    found = balance.quadrics(quadrics)
    np.testing.assert_allclose(found[:, SQUARES].sum(axis=1), 0, atol=10.0 ** (digits - 14))
    np.testing.assert_allclose(found[:, 10], 0, atol=0)
    np.testing.assert_allclose(found @ found.T, np.eye(6), atol=10.0 ** (digits - 14))


def test_values_of_poses_and_others_differ_by_what_they_are_over_the_rounding():
    quadrics = similar(5)
    balance = Balance.of(quadrics)
    small = balance.directions[:, -1]
    # Values that a pose has are the constants but for 1e-5.
    like = balance.constants + balance.directions[:, :5] @ np.ones(5)
    assert np.abs(small @ balance.spread(like)).max() == pytest.approx(0.5 * balance.sizes[-1])
    # Others are not like these.
    assert np.abs(small @ balance.spread(like + small)).max() == pytest.approx(0.25)


def test_equations_are_solved_after_they_are_combined():
    quadrics = similar(6)
    homotopy = ReducedHomotopy.of(quadrics)
    assert np.abs(homotopy.forms).max() < 1e3
    assert np.abs(homotopy.combinations).max() > 1e5
    # The values of N times the constants are on the right.
    values = homotopy.combinations @ (Balance.of(quadrics).constants - homotopy.constants)
    np.testing.assert_array_equal(values, 0)


@pytest.mark.parametrize("digits", [1, 16])
def test_quadrics_that_are_independent_or_dependent_are_left_as_they_are(digits):
    quadrics = similar(digits, ratio=0.5 + 0.5 * (digits == 16), turn=0.0)
    if digits == 1:
        quadrics[0] += np.random.default_rng(1).uniform(-1, 1, 27)
    assert Balance.of(quadrics) is None
    homotopy = ReducedHomotopy.of(quadrics)
    assert homotopy is None or not homotopy.constants.any()
