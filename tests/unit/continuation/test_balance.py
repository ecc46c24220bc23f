"""Combinations of quadrics that are nearly dependent."""

import numpy as np
import pytest

from gspcli.catalogue.kinds import DPP
from gspcli.continuation.balance import Balance
from gspcli.continuation.reduced_homotopy import ReducedHomotopy
from gspcli.solver.study_systems import coefficients_of

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
