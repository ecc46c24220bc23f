"""The trace test is passed by all solutions, and by no others."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.catalogue.names import parse_type
from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.systems import Structure, System
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.random_instances import random_instance
from gspcli.solver.study_systems import target_systems
from tests.support.systems import solve_system
from tools.atlas.tasks import moving_equation, trace_test

SEED = 4
ANGLES = {"3D3A": 3, "4D2A": 2, "5D1A": 1}
#: Every space moves, as a quadric and as a product.
TYPES = (
    "3D3A PH PH PH",
    "3D3A PL LP LL",
    "4D2A PP PP PP PP",
    "4D2A PL LP LP LL",
    "5D1A PL PL HP PH LL",
    "6PL",
    "6D LP LP HP HP LL LL",
)


def _solved(name: str) -> tuple[System, ComplexArray]:
    gsp_type = parse_type(name + " ALL" * ANGLES.get(name[:4], 0))
    instance, _ = random_instance(gsp_type, np.random.default_rng(SEED), one_sided=True)
    target = target_systems(Arrangement.of(instance))[0]
    return target, solve_system(target).points


@pytest.mark.parametrize("name", TYPES)
def test_all_solutions_pass_and_all_but_one_do_not(name: str) -> None:
    target, points = _solved(name)
    trace = trace_test(target, points, SEED)
    assert trace.passed
    assert trace.defect < 1e-9
    assert trace.without_one > 1e-7
    found = trace_test(target, np.delete(points, len(points) // 2, axis=0), SEED)
    assert not found.passed
    assert found.defect > 0.1 * trace.without_one


def test_half_of_the_solutions_do_not_pass() -> None:
    target, points = _solved("6D PL PL PL PH PH PH")
    rng = np.random.default_rng(SEED)
    for _ in range(2):
        half = rng.permutation(len(points))[: len(points) // 2]
        assert not trace_test(target, points[half], SEED).passed


def test_what_is_no_solution_does_not_pass() -> None:
    target, points = _solved("4D2A PP PP PP PP")
    points[3] = np.random.default_rng(SEED).normal(size=8)
    assert not trace_test(target, points, SEED).passed


def test_three_angles_show_rotations_only() -> None:
    target, points = _solved("3D3A PP PP PP")
    order = np.argsort(np.round(points[:, 1] / points[:, 0], 6))
    assert trace_test(target, points, SEED).passed
    # One pose of the two for each rotation: the limit of the test that docs/counts.md states.
    assert trace_test(target, points[order[::2]], SEED).passed
    assert not trace_test(target, points[order[:8]], SEED).passed


def test_which_equation_moves() -> None:
    assert moving_equation(Structure("aaappp", (False,) * 6)) == 0
    assert moving_equation(Structure("aapqlp", (False, False, True, True, False, False))) == 4
    assert moving_equation(Structure("llllll", (True,) * 6)) == 0
