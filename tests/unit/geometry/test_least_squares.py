"""Descents of sums of squares from many starts."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.geometry.least_squares import descend


def added(step, x):
    return (x + step,)


def rosenbrock(x):
    """Residuals 10 (y - x^2) and 1 - x; zero at (1, 1)."""
    residuals = np.stack((10 * (x[:, 1] - x[:, 0] ** 2), 1 - x[:, 0]), axis=-1)
    slopes = np.zeros((len(x), 2, 2))
    slopes[:, 0, 0], slopes[:, 0, 1], slopes[:, 1, 0] = -20 * x[:, 0], 10, -1
    return residuals, slopes


def test_every_start_comes_to_the_solution() -> None:
    starts = np.array([[-1.2, 1.0], [3.0, -4.0], [1.0, 1.0]])
    ends = descend(rosenbrock, added, (starts,))
    assert np.abs(ends.point[0] - 1).max() < 1e-9
    assert ends.ended.all()
    assert ends.squares.max() < 1e-20


def test_a_minimum_that_is_no_solution_ends() -> None:
    """The mean of three numbers, whose sum of squares is 2."""
    numbers = np.array([1.0, 2.0, 3.0])

    def equations(x):
        return x - numbers, np.ones((len(x), 3, 1))

    ends = descend(equations, added, (np.array([[50.0]]),))
    assert ends.point[0][0, 0] == pytest.approx(2, abs=1e-12)
    assert ends.squares[0] == pytest.approx(2)
    assert ends.ended.all()


def test_steps_have_the_least_norm_where_equations_are_too_few() -> None:
    """On a circle about the start's ray only the radius is told, and a column of zeros."""

    def equations(x):
        size = np.linalg.norm(x[:, :2], axis=1)
        slopes = np.pad(x[:, :2] / size[:, None], ((0, 0), (0, 1)))
        return (size - 2)[:, None], slopes[:, None]

    ends = descend(equations, added, (np.array([[3.0, 4.0, 7.0]]),))
    assert ends.point[0][0] == pytest.approx([1.2, 1.6, 7.0], abs=1e-12)


def test_all_end_when_one_is_good_enough() -> None:
    starts = np.array([[1.0, 1.0 + 1e-9], [-1.2, 1.0]])
    ends = descend(rosenbrock, added, (starts,), enough=1e-12)
    assert (ends.point[0] == starts).all()


def test_a_start_without_a_value_spoils_no_other() -> None:
    ends = descend(rosenbrock, added, (np.array([[np.nan, 0.0], [-1.2, 1.0]]),))
    assert ends.point[0][1] == pytest.approx([1, 1], abs=1e-9)
    assert ends.ended.tolist() == [False, True]
