"""Simple solutions are distinguished from double ones for any condition numbers."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.continuation.endpoints import random_start
from gspcli.continuation.quadrics import evaluate
from gspcli.continuation.regularity import clearly_simple, nonlinearity, simple
from gspcli.continuation.start import start_system
from gspcli.continuation.systems import System
from gspcli.continuation.tracker import track
from tests.support.systems import solve_system


def solved(target: System):
    """The system in its canonical order and balanced, its paths, and the results."""
    start = start_system(target.structure.canonical())
    balanced, _ = target.canonical().coefficients.balanced()
    system = System(start.system.structure, balanced)
    return system, track(random_start(start, 1, 0), system, start.points)


@pytest.mark.parametrize("kinds", ["PP PP PP PP PP PP", "PL LP PH HP A A", "LL LL PP PL PH A"])
def test_solutions_of_random_platforms_are_simple(build, kinds):
    target, _, _ = build.platform(kinds, np.random.default_rng(5))
    system, results = solved(target)
    assert clearly_simple(results).all()
    assert nonlinearity(system, results.points[0]).max() < 1e-6


@pytest.mark.parametrize(("distance", "found"), [(0.0, 79), (1e-5, 80), (1e-2, 80)])
def test_a_point_on_a_line_is_a_double_solution_and_one_near_it_two(build, distance, found):
    """Both factors of the product vanish, which leaves the scaled rows well-conditioned."""
    solutions = solve_system(build.point_at_a_line(distance, np.random.default_rng(8)))
    assert solutions.account.verdict == "complete"
    assert solutions.account.found == 80
    assert len(solutions.points) == found
    assert solutions.singular.sum() == 80 - found


def test_a_point_on_a_line_is_not_simple(build):
    system, results = solved(build.point_at_a_line(0.0, np.random.default_rng(8)))
    ends = results.points[0]
    product = system.structure.is_product
    factors = [np.abs(evaluate(x[product], ends)[:, 0]) for x in system.coefficients[:2]]
    on_line = (factors[0] < 1e-6) & (factors[1] < 1e-6)
    assert on_line.sum() == 2
    assert not simple(system, ends[on_line]).any()
    assert not clearly_simple(results)[0][on_line].any()
    # Dividing the rows by what cancels in them hides it.
    assert results.condition[0][on_line].max() < 1e6
    assert simple(system, ends[~on_line]).all()
