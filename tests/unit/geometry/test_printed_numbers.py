"""Condition numbers and residuals as files have them: rounding errors do not change them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gspcli.geometry.measurement import (
    printed_condition,
    printed_conditions,
    printed_residual,
    printed_residuals,
)


@pytest.mark.parametrize(
    ("condition", "printed"),
    [
        (1.0, 1.0),
        (36.98214567, 36.9821),
        (123456.789, 123457.0),
        (1.23456e7, 1.235e7),
        (1.23456e11, 1e11),
        (1.2e15, 1e15),
        (math.inf, math.inf),
    ],
)
def test_a_condition_number_has_the_digits_that_are_known(condition, printed) -> None:
    assert printed_condition(condition) == printed


@pytest.mark.parametrize("condition", [1.37, 44.4, 6.1234e4, 7.7e7, 3.21e10])
def test_rounding_errors_change_no_digit_of_a_condition_number(condition: float) -> None:
    error = 3e-15 * condition
    near = condition * (1 + error * np.linspace(-1, 1, 9))
    assert len(set(printed_conditions(near).tolist())) == 1


def test_arrays_keep_their_shape() -> None:
    numbers = np.array([[1.0, np.nan], [np.inf, 2.5]])
    found = printed_conditions(numbers)
    assert found.shape == (2, 2)
    assert np.isnan(found[0, 1])
    assert np.isinf(found[1, 0])
    assert printed_residuals(np.zeros((0,)), 1.0).shape == (0,)


@pytest.mark.parametrize("residual", [0.0, 1e-17, 3.3e-16, 8.9e-15])
def test_residuals_of_rounding_errors_are_written_alike(residual: float) -> None:
    assert printed_residual(residual, 1.0) == 2e-14
    assert printed_residual(residual * 250, 250.0) == 4e-12


@pytest.mark.parametrize(
    ("residual", "printed"), [(1.01e-9, 2e-9), (9.5e-4, 1e-3), (2.0, 2.0), (math.inf, math.inf)]
)
def test_a_residual_is_not_more_than_is_written(residual: float, printed: float) -> None:
    assert printed_residual(residual, 1.0) == printed


def test_without_a_length_a_residual_of_zero_is_zero() -> None:
    assert printed_residual(0.0, 0.0) == 0.0
