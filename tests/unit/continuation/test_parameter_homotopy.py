"""Following solutions from one system to another."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.continuation.parameter_homotopy import follow
from tests.support.systems import solve_system


def lines(points: np.ndarray) -> np.ndarray:
    return points / np.linalg.norm(points, axis=1, keepdims=True)


@pytest.mark.parametrize("kinds", ["PP PP PP PP PP PP", "PP PL LP PH HP A"])
def test_all_solutions_lead_to_all(build, kinds):
    known, _, _ = build.platform(kinds, np.random.default_rng(1))
    target, _, _ = build.platform(kinds, np.random.default_rng(2))
    found = follow(known, solve_system(known).points, target, rng=np.random.default_rng(3))
    assert found is not None
    expected = solve_system(target).points
    assert len(found.points) == len(expected)
    np.testing.assert_allclose((found.points[:, :4] ** 2).sum(axis=1), 1)
    inner = np.abs(lines(found.points).conj() @ lines(expected).T)
    assert sorted(inner.argmax(axis=1)) == list(range(len(expected)))
    assert inner.max(axis=1).min() > 1 - 1e-9
    assert (found.condition > 0).all()


def test_scale_of_the_equations_does_not_matter(build):
    rng = np.random.default_rng(4)
    known, target = (build.platform("PP PP PP PP PP PL", rng)[0] for _ in range(2))
    points = solve_system(known).points
    sizes = np.exp(rng.standard_normal(6))
    one, other = (
        follow(known, points, system, rng=np.random.default_rng(5))
        for system in (target, target.scaled(sizes, sizes[::-1]))
    )
    assert one is not None
    assert other is not None
    np.testing.assert_allclose(one.points, other.points, atol=1e-8)


def test_paths_that_end_together_are_not_said_to_have_been_followed(build):
    """Congruent bodies: an infinite set of solutions."""
    rng = np.random.default_rng(6)
    y = rng.standard_normal((6, 3))
    known = build.legs(y, rng.standard_normal((6, 3)), rng.uniform(1, 2, 6))
    special = build.legs(y, y, [1.0] * 6)
    points = solve_system(known).points
    assert follow(known, points, special, rng=np.random.default_rng(7)) is None


def test_what_is_no_solution_is_not_followed(build):
    known, target = (build.platform("PP " * 6, np.random.default_rng(s))[0] for s in (8, 9))
    wrong = np.random.default_rng(10).standard_normal((3, 8)).astype(complex)
    assert follow(known, wrong, target, rng=np.random.default_rng(11)) is None
