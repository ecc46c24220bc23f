"""Two independent ways to the same poses: the closed form and path tracking."""

from __future__ import annotations

import numpy as np
import pytest
from closed_forms import closed_form_poses
from hypothesis import given, settings
from hypothesis import strategies as st
from matching import pose_set_distance

from gspcli.catalogue.types import all_types, type_by_number
from gspcli.continuation.quadrics import evaluate
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import study_from_pose
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import solve
from gspcli.solver.study_systems import target_systems
from tests.support.oracle.poses_by_paths import solve_by_tracking

seeds = st.integers(0, 10**6)


@given(st.integers(1, len(all_types())), seeds)
def test_a_pose_satisfies_the_quadrics_of_its_sides(number, seed):
    instance, (R, T) = random_instance(type_by_number(number), np.random.default_rng(seed))
    arrangement = Arrangement.of(instance)
    inner = arrangement.normalized
    inward = (T - arrangement.base_centre + R @ arrangement.platform_centre) / arrangement.length
    point = np.concatenate(study_from_pose(R, inward))
    errors = []
    for system in target_systems(inner):
        *factors, tau = system.coefficients
        g, h = (evaluate(quadrics, point[None])[0] for quadrics in factors)
        values = np.where(system.structure.products, g * h - tau, g)
        errors.append(np.abs(values).max())
    assert min(errors) < 1e-12
    assert sorted(errors)[1:] == [] or sorted(errors)[1] > 1e-9


@given(st.integers(1, 1120), seeds)
@settings(max_examples=25)
def test_closed_form_and_path_tracking_agree(number, seed):
    instance, _ = random_instance(type_by_number(number), np.random.default_rng(seed))
    arrangement = Arrangement.of(instance)
    closed = closed_form_poses(arrangement)
    assert closed is not None
    tracked = solve_by_tracking(arrangement, seed=seed)
    assert closed.account.expected == tracked.account.expected
    assert closed.real.sum() == tracked.real.sum()
    distance = pose_set_distance((closed.R, closed.T), (tracked.R, tracked.T), arrangement.length)
    assert distance < 1e-8


@pytest.mark.parametrize(
    "name", ["DPP DPP DPP DPP DPP DPP", "DPP DPL DPH DHP DLL ALH", "DPH DPH DPH DHP DHP DHP"]
)
def test_other_classes_are_solved_completely_and_certified(name):
    number = next(t.number for t in all_types() if t.id == name)
    instance, (R, _) = random_instance(type_by_number(number), np.random.default_rng(3))
    result = solve(instance)
    assert result.verdict == "complete"
    assert result.counts.found == result.counts.certified == result.expected
    assert np.abs(result.R[result.real] - R).max(axis=(1, 2)).min() < 1e-9
